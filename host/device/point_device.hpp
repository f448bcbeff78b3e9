// SPDX-License-Identifier: GPL-2.0-or-later
// The simulated device: a point mass with viscous and Coulomb friction, weight, stops, an encoder and motors with a
// limit, a lag and a delay, held by a hand.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "host/device/wrist.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

/// A hand as a spring and a damper to where it wants to be. Sources of the numbers: docs/DEVICES.md.
struct Hand {
    double stiffness_n_per_m = 200.0;
    double damping_n_s_per_m = 5.0;
};

/// Hands by name: the first is the default, "soft" hardly holds the device, "stiff" grips it.
struct HandModel {
    const char* name;
    Hand hand;
};
const std::vector<HandModel>& hands();

/// Throws Error that names the hands there are.
Hand hand_named(const std::string& name);

/// Where the hand wants the finger to be.
struct HandGoal {
    Eigen::Vector3d position_m;
    Eigen::Vector3d velocity_m_s;
    std::uint32_t buttons = 0;  ///< that it holds down: bits of enum haptable_button
    Turning wrist = {};         ///< of a tool
};

class PointDevice {
public:
    /// At rest at `start_m`.
    PointDevice(const Device& device, const Hand& hand, const Eigen::Vector3d& start_m);

    /// Sets the motors' force: cut to the device's limit; what is not finite is zero. Held until set again. It acts
    /// after the device's delay, and then comes up with the motors' lag.
    void set_force(const Eigen::Vector3d& force_n);
    /// Another hand holds it from now on.
    void hold(const Hand& hand) { hand_ = hand; }
    /// Moves the device `step_s` on, with the goal as it is in the middle of the step. Unconditionally stable.
    void advance(const HandGoal& goal, double step_s);

    const Eigen::Vector3d& position_m() const { return position_m_; }
    const Eigen::Vector3d& velocity_m_s() const { return velocity_m_s_; }
    /// As it was set, cut.
    const Eigen::Vector3d& force_n() const { return force_n_; }
    /// What the motors give now.
    const Eigen::Vector3d& acting_n() const { return acting_n_; }
    /// What the encoders read: the position on their grid.
    Eigen::Vector3d encoder_m() const;
    /// Kinetic energy and that of the hand's spring, J.
    double energy_j(const Eigen::Vector3d& goal_m) const;

private:
    struct OnItsWay {
        double from_s;
        Eigen::Vector3d force_n;
    };

    void act(double step_s);
    void stop_at_reach();

    Device device_;
    Hand hand_;
    Eigen::Vector3d mass_kg_, weight_n_;
    double time_s_ = 0.0;
    std::deque<OnItsWay> on_its_way_;
    Eigen::Vector3d arrived_n_ = Eigen::Vector3d::Zero(), acting_n_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d position_m_;
    Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
    Eigen::Vector3d force_n_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
