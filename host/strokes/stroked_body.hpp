// SPDX-License-Identifier: GPL-2.0-or-later
// One body with one of the three forces: its tables, its servo in memory, and what judges them.
#pragma once

#include <filesystem>
#include <string>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/base/modes.hpp"
#include "host/base/progress.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/scene/scene.hpp"
#include "host/strokes/judge.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// A way of touching (docs/CONTACT.md).
struct TouchMode {
    ForceLaw force = ForceLaw::kInterpolated;
    GodObject god_object = GodObject::kNearest;
    bool friction = false;

    std::string name() const {
        return std::string(word(force)) + "-" + word(god_object) + (friction ? "-friction" : "");
    }
};

/// All twelve: force by force.
std::vector<TouchMode> all_modes();

/// The scene touched so: friction 0.3 and 0.2, and what else a scene has by default.
Scene in_mode(Scene scene, const TouchMode& mode);

/// In this order a body's tables take least: the inversion for edges gives S_i too.
inline constexpr auto kForcesOfTables = every<ForceLaw>();

/// A body's tables for each force, in folders of their own; what is there is not computed again. K is factorised once,
/// and S_i are those of one force for all.
class BodyTables {
public:
    /// A tick is judged by these tables themselves: their error is not what is judged here, and single precision is
    /// enough.
    static constexpr double kTolerance = 1e-4;

    BodyTables(Scene scene, std::filesystem::path folder) : scene_(std::move(scene)), folder_(std::move(folder)) {}

    /// Throws Error as precompute does.
    Tables with(ForceLaw force);
    /// CPU seconds that the tables took which are there, when they were computed.
    double cpu_s() const;

private:
    std::filesystem::path folder_of(ForceLaw force) const { return folder_ / word(force); }

    Scene scene_;
    std::filesystem::path folder_;
    CholmodInverse inverse_;
};

class StrokedBody {
public:
    explicit StrokedBody(Tables tables);
    /// scene: with its force. Tables go to `folder`; they are not computed again where it holds them.
    StrokedBody(const Scene& scene, const std::filesystem::path& folder, Progress& progress);
    StrokedBody(const StrokedBody&) = delete;
    StrokedBody& operator=(const StrokedBody&) = delete;

    /// The servo's model with that force and otherwise these options. `this` must outlive it; the next call
    /// ends it.
    haptable_model model(const ContactOptions& contact) const;
    Touched touched(const haptable_model& model) const { return {solid_, law_, servo_, model}; }
    const ServoModel& servo() const { return servo_; }

private:
    Tables tables_;
    ServoModel servo_;
    Solid solid_;
    Law law_;
};

}  // namespace haptable
