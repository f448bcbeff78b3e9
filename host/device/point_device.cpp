// SPDX-License-Identifier: GPL-2.0-or-later
// m x'' = k (x_t - x) + c (v_t - x') - b x' - f x'/|x'| + F
//
// k, c: the hand's spring and damper to its goal x_t, moving at v_t; b, f: the device's viscous and Coulomb friction;
// F: its motors' force. Integrated by the implicit midpoint rule, which is of second order and stable for every step.
#include "host/device/point_device.hpp"

#include <algorithm>
#include <cmath>

namespace haptable {

PointDevice::PointDevice(const Device& device, const Hand& hand, const Eigen::Vector3d& start_m)
    : device_(device), hand_(hand), position_m_(start_m) {}

void PointDevice::set_force(const Eigen::Vector3d& force_n) {
    force_n_ = force_n.allFinite() ? force_n : Eigen::Vector3d::Zero();
    const double size_n = force_n_.stableNorm();
    if (size_n > device_.max_force_n) force_n_ *= device_.max_force_n / size_n;
}

// With w = (v + v')/2 the velocity in the middle of the step h, and x + h w / 2 the position there:
//
//   (2m/h + k h/2 + c + b) w + f w/|w| = 2m/h v + k (x_t - x) + c v_t + F
//
// The left side is an isotropic factor a and a friction of constant size, so w has the direction of the right side r
// and |w| = (|r| - f)/a; where |r| <= f the device sticks. Then x' = x + h w, v' = 2 w - v.
// With a goal at rest and F = 0 the energy m v^2/2 + k (x_t - x)^2/2 changes by exactly -h ((b + c) w^2 + f |w|).
void PointDevice::advance(const HandGoal& goal, double step_s) {
    const double inertia = 2.0 * device_.mass_kg / step_s;
    const double a =
        inertia + hand_.stiffness_n_per_m * step_s / 2.0 + hand_.damping_n_s_per_m + device_.damping_n_s_per_m;
    const Eigen::Vector3d r = inertia * velocity_m_s_ + hand_.stiffness_n_per_m * (goal.position_m - position_m_) +
                              hand_.damping_n_s_per_m * goal.velocity_m_s + force_n_;
    const double size = r.norm();
    if (size <= device_.friction_n) {
        // Stuck. The midpoint rule alone would turn the small rest of the velocity round, for ever.
        velocity_m_s_.setZero();
        return;
    }
    const Eigen::Vector3d w = (1.0 - device_.friction_n / size) / a * r;
    position_m_ += step_s * w;
    velocity_m_s_ = 2.0 * w - velocity_m_s_;
}

Eigen::Vector3d PointDevice::encoder_m() const {
    const double step_m = device_.encoder_step_m;
    if (step_m <= 0.0) return position_m_;
    return (position_m_ / step_m).array().round().matrix() * step_m;
}

double PointDevice::energy_j(const Eigen::Vector3d& goal_m) const {
    return 0.5 * device_.mass_kg * velocity_m_s_.squaredNorm() +
           0.5 * hand_.stiffness_n_per_m * (goal_m - position_m_).squaredNorm();
}

}  // namespace haptable
