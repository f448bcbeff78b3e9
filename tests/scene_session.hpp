// SPDX-License-Identifier: GPL-2.0-or-later
// A scene in memory and its fingers, stepped by a tick.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "host/session/scene_state.hpp"
#include "tests/finger.hpp"

namespace haptable::test {

class SceneSession {
public:
    SceneSession(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
                 const haptable_modes* modes)
        : state(model, pair, body, modes) {
        state.check(HAPTABLE_CHECK_ALL);
    }

    /// One tick; none: the finger is away.
    void step(const std::optional<Eigen::Vector3d>& first_m, const std::optional<Eigen::Vector3d>& second_m = {}) {
        const std::array<std::optional<Eigen::Vector3d>, 2> at_m{first_m, second_m};
        haptable_input in[2]{};
        for (std::size_t f = 0; f < 2; ++f) {
            in[f].is_there = at_m[f].has_value();
            for (int c = 0; at_m[f] && c < 3; ++c) in[f].finger_m[c] = static_cast<float>((*at_m[f])[c]);
        }
        state.step(in, tick++ * 1000, out);
    }
    Eigen::Vector3d force(std::size_t finger = 0) const { return to_vector(out[finger].force_n); }
    bool touches(std::size_t finger = 0) const { return haptable_touches(out[finger].state) != 0; }
    bool both_touch() const { return touches(0) && touches(1); }
    const haptable_contact& contact(std::size_t finger = 0) const { return state.servo(finger).contact; }
    double modes_j() const { return double(haptable_modes_energy(state.scene().modes, state.modes())); }
    /// In contacts and modes, less what is owed of it.
    double all_j() const { return double(state.account().stored_j) - std::max(0.0, double(state.account().owed_j)); }

    SceneState state;
    haptable_output out[2]{};
    std::uint32_t tick = 0;
};

}  // namespace haptable::test
