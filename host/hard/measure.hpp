// SPDX-License-Identifier: GPL-2.0-or-later
// One hard case through the whole way, scene to servo, against a dense reference in long double.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/hard/cases.hpp"
#include "host/hard/reference.hpp"
#include "host/precompute/digits.hpp"
#include "host/precompute/precompute.hpp"

namespace haptable {

/// A case with its tables and its servo, in memory.
class HardBody {
public:
    /// Runs precompute below `folder`. Throws Error where the case is refused.
    HardBody(const HardCase& hard, ForceLaw force, const std::filesystem::path& folder);
    HardBody(const HardBody&) = delete;
    HardBody& operator=(const HardBody&) = delete;

    const HardCase& hard() const { return hard_; }
    const Body& body() const { return result_.body; }
    const Summary& summary() const { return result_.summary; }
    const Tables& tables() const { return tables_; }
    const ServoModel& servo() const { return servo_; }
    /// The servo's model with the scene's force and this god-object.
    haptable_model model(GodObject god_object = GodObject::kNearest) const;
    std::vector<std::string> warnings() const { return digit_warnings(hard_.scene, result_.summary); }

private:
    HardCase hard_;
    Result result_;
    Tables tables_;
    ServoModel servo_;
};

/// S of every touchable free node, in double, against the reference.
struct StiffnessErrors {
    double worst = 0.0;  ///< ||S - S_d|| / ||S_d||
    double in_terms_of_l =
        0.0;                 ///< ||S - S_d|| / (||S|| cond(S)): what L_ii was off by, whatever the inverse magnified
    double asymmetry = 0.0;  ///< ||S - S^T|| / ||S||
    double least_eigenvalue = 0.0;  ///< of any S over its largest: below 0, S would pull
    double condition = 1.0;         ///< of the worst S
};
StiffnessErrors compare_stiffness(const HardBody& body, const Reference& reference);

/// The servo's force as a finger goes straight into patches, one after the other, spread over the body.
struct ForceErrors {
    std::size_t touches = 0, missed = 0;  ///< patches with contact, and without
    double worst = 0.0;      ///< ||F - F_d|| / ||F_d||, F_d by the reference for the same finger and area coordinates
    double rounding = 0.0;   ///< the same from the servo's own god-object, over cond(S): in units of 1, a few 2^-24
    double misplaced = 0.0;  ///< from the god-object to its area coordinates' point, of the largest coordinate
};
ForceErrors compare_force(const HardBody& body, const Reference& reference, GodObject god_object, int most_patches);

}  // namespace haptable
