// SPDX-License-Identifier: GPL-2.0-or-later
// A passive hand for sessions that judge energy, and how long they are.
#pragma once

#include <Eigen/Core>
#include <cstdlib>

namespace haptable::test {

/// A mass on a spring and a damper to where it wants to be: passive, as a hand that holds still is. Its damping is to
/// be what a sampled contact of stiffness K gives at the most, K T / 2 (Colgate and Schenkel 1997), and 5 % more.
struct Hand {
    static constexpr double kTick_s = 0.001;

    Eigen::Vector3d at_m = Eigen::Vector3d::Zero(), wants_m = Eigen::Vector3d::Zero(),
                    velocity = Eigen::Vector3d::Zero();
    double mass_kg = 0.2, stiffness = 60.0, damping = 0.0;

    void damp(double contact_n_per_m) { damping = 1.05 * 0.5 * kTick_s * contact_n_per_m; }
    void move(const Eigen::Vector3d& force) {
        const Eigen::Vector3d middle = (mass_kg * velocity + 0.5 * kTick_s * (force + stiffness * (wants_m - at_m))) /
                                       (mass_kg + 0.5 * kTick_s * damping + 0.25 * kTick_s * kTick_s * stiffness);
        at_m += kTick_s * middle;
        velocity = 2.0 * middle - velocity;
    }
};

/// What the environment asks for: HAPTABLE_SESSIONS=200 HAPTABLE_SECONDS=60 is the whole judgement.
inline int asked(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::atoi(text) : otherwise;
}

}  // namespace haptable::test
