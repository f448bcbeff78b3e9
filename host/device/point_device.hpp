// SPDX-License-Identifier: GPL-2.0-or-later
// The simulated device: a point mass with viscous and Coulomb friction, an encoder and a force limit, held by a hand.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "host/scene/scene.hpp"

namespace haptable {

/// A hand as a spring and a damper to where it wants to be. Sources of the numbers: docs/SPEC.md.
struct Hand {
    double stiffness_n_per_m = 200.0;
    double damping_n_s_per_m = 5.0;
};

/// Where the hand wants the finger to be.
struct HandGoal {
    Eigen::Vector3d position_m;
    Eigen::Vector3d velocity_m_s;
    std::uint32_t buttons = 0;  ///< that it holds down: bits of enum haptable_button
};

class PointDevice {
public:
    /// At rest at `start_m`.
    PointDevice(const Device& device, const Hand& hand, const Eigen::Vector3d& start_m);

    /// Sets the motors' force: cut to the device's limit; what is not finite is zero. Held until set again.
    void set_force(const Eigen::Vector3d& force_n);
    /// Moves the device `step_s` on, with the goal as it is in the middle of the step. Unconditionally stable.
    void advance(const HandGoal& goal, double step_s);

    const Eigen::Vector3d& position_m() const { return position_m_; }
    const Eigen::Vector3d& velocity_m_s() const { return velocity_m_s_; }
    const Eigen::Vector3d& force_n() const { return force_n_; }
    /// What the encoders read: the position on their grid.
    Eigen::Vector3d encoder_m() const;
    /// Kinetic energy and that of the hand's spring, J.
    double energy_j(const Eigen::Vector3d& goal_m) const;

private:
    Device device_;
    Hand hand_;
    Eigen::Vector3d position_m_;
    Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d force_n_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
