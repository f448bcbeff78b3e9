// SPDX-License-Identifier: GPL-2.0-or-later
// The forces of a session: the largest, and their energy: what the body stores, and what they gave to the user.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>

#include "firmware/haptable_model.h"
#include "host/base/summary_lines.hpp"

namespace haptable {

/// What a tool adds to its hand's tick.
struct ToolWork {
    std::array<float, 4> turn{};        ///< of the hand, w x y z
    std::array<float, 3> torque_n_m{};  ///< on it
    double stored_j = 0.0;              ///< by all points
};

/// Kept on the host, in double: the servo pays nothing for it. Fixed memory, any number of ticks.
class EnergyAccount {
public:
    /// One tick: where the finger was (m) and what the servo answered. A force is held until the next tick, so that the
    /// one before did F . d over a motion d (Hannaford and Ryu 2002). After a rejected position, or silence, there is
    /// none.
    /// inside_m: where the finger was in body coordinates, as the output's god-object and loads are; of a body that is
    /// held finger_m.
    /// tool: of one, whose finger is its handle: its torque does work too, and what it stores is its points'.
    void add(const std::array<float, 3>& finger_m, const haptable_output& output, const std::array<float, 3>& inside_m,
             const ToolWork* tool = nullptr);
    void add(const std::array<float, 3>& finger_m, const haptable_output& output) { add(finger_m, output, finger_m); }

    /// 1/2 u . f of the last tick, u from the god-object to the finger and f the contact's load before max_force: in
    /// the body, and in the coupling where the scene has one. J.
    double stored_j() const { return stored_j_; }
    /// The largest of stored_j() so far.
    double most_stored_j() const { return most_stored_j_; }
    /// Given to the user so far, less what was taken, J: never above what rounding makes of 0 where the servo is
    /// passive and contact begins at rest on the surface.
    double given_j() const { return given_j_; }
    /// The largest of given_j() so far, 0 at the least.
    double most_given_j() const { return most_given_j_; }

    /// All of them for reports: names without a unit, J.
    std::array<std::pair<std::string, double>, 4> by_name() const {
        return {{{"energy_stored", stored_j_},
                 {"energy_most_stored", most_stored_j_},
                 {"energy_given", given_j_},
                 {"energy_most_given", most_given_j_}}};
    }

private:
    struct Held {
        std::array<float, 3> finger_m;
        std::array<float, 3> force_n;
        ToolWork tool;
    };

    std::optional<Held> last_;
    double stored_j_ = 0.0, most_stored_j_ = 0.0;
    double given_j_ = 0.0, most_given_j_ = 0.0;
};

/// What a session's forces came to: of a servo, or of the bridge that stands for it.
struct ForceReport {
    double largest_force_n = 0.0;
    EnergyAccount energy;

    /// One tick, as EnergyAccount::add.
    void note(const std::array<float, 3>& finger_m, const haptable_output& output, const std::array<float, 3>& inside_m,
              const ToolWork* tool = nullptr);
    void note(const std::array<float, 3>& finger_m, const haptable_output& output) { note(finger_m, output, finger_m); }
    /// suffix: at the end of each name.
    void add_to(SummaryLines& summary, const std::string& suffix = "") const;
};

}  // namespace haptable
