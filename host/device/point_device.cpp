// SPDX-License-Identifier: GPL-2.0-or-later
// m x'' = k (x_t - x) + c (v_t - x') - b x' - f x'/|x'| + F + W
//
// k, c: the hand's spring and damper to its goal x_t, moving at v_t; b, f: the device's viscous and Coulomb friction;
// m: its apparent mass along each axis; F: its motors' force; W: what of its weight nothing balances. Integrated by the
// implicit midpoint rule, which is of second order and stable for every step.
#include "host/device/point_device.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/base/command_line.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kGravity_m_s2 = 9.80665;

/// |w| of a_i w_i + f w_i/|w| = r_i, where |r| > f: the root s of sum (r_i / (a_i s + f))^2 = 1, which falls and is
/// convex in s, so that Newton's steps from the left never pass it. Exact at once where all a_i are one.
double speed_of(const Vector3d& a, const Vector3d& r, double f) {
    double s = (r.norm() - f) / a.maxCoeff();
    if (a.maxCoeff() == a.minCoeff()) return s;
    for (int step = 0; step < 50; ++step) {
        const Vector3d share = r.array() / (a.array() * s + f);
        const double slope = -2.0 * (share.array().square() * a.array() / (a.array() * s + f)).sum();
        const double more = (1.0 - share.squaredNorm()) / slope;
        if (!(more > 1e-15 * s)) break;
        s += more;
    }
    return s;
}

}  // namespace

const std::vector<HandModel>& hands() {
    static const std::vector<HandModel> all{{"default", {}}, {"soft", {50.0, 1.0}}, {"stiff", {800.0, 10.0}}};
    return all;
}

Hand hand_named(const std::string& name) {
    std::string known;
    for (const HandModel& one : hands()) {
        if (one.name == name) return one.hand;
        known += std::string(known.empty() ? "" : ", ") + one.name;
    }
    throw BadCommandLine(fmt::format("--hand: there is no {}; there are {}", name, known));
}

PointDevice::PointDevice(const Device& device, const Hand& hand, const Vector3d& start_m)
    : device_(device), hand_(hand), mass_kg_(device.mass_kg.data()), position_m_(start_m) {
    const Vector3d up = Vector3d(device.up.data()).normalized();
    weight_n_ = -kGravity_m_s2 * device.unbalanced * mass_kg_.cwiseProduct(up);
}

void PointDevice::set_force(const Vector3d& force_n) {
    force_n_ = force_n.allFinite() ? force_n : Vector3d::Zero();
    const double size_n = force_n_.stableNorm();
    if (size_n > device_.max_force_n) force_n_ *= device_.max_force_n / size_n;
    on_its_way_.push_back({time_s_ + device_.delay_s, force_n_});
}

/// The motors' force of this step: what has arrived, behind the lag a' = 2 pi bandwidth (arrived - a).
void PointDevice::act(double step_s) {
    for (; !on_its_way_.empty() && on_its_way_.front().from_s <= time_s_ + 0.5 * step_s; on_its_way_.pop_front())
        arrived_n_ = on_its_way_.front().force_n;
    const double turns = 2.0 * std::numbers::pi * device_.bandwidth_hz * step_s;
    acting_n_ = turns > 0.0 ? Vector3d(arrived_n_ + std::exp(-turns) * (acting_n_ - arrived_n_)) : arrived_n_;
    time_s_ += step_s;
}

// With w = (v + v')/2 the velocity in the middle of the step h, and x + h w / 2 the position there, along each axis i:
//
//   (2 m_i/h + k h/2 + c + b) w_i + f w_i/|w| = 2 m_i/h v_i + k (x_t - x)_i + c v_t,i + F_i + W_i
//
// The left side is a factor a_i and a friction of constant size along w. Where |r| <= f, r the right side, the device
// sticks; else |w| is the root of one equation. Then x' = x + h w, v' = 2 w - v. With a goal at rest, F = 0 and W = 0
// the energy (sum m_i v_i^2 + k (x_t - x)^2)/2 changes by exactly -h ((b + c) w^2 + f |w|).
void PointDevice::advance(const HandGoal& goal, double step_s) {
    act(step_s);
    const Vector3d inertia = 2.0 / step_s * mass_kg_;
    const Vector3d a = inertia.array() +
                       (hand_.stiffness_n_per_m * step_s / 2.0 + hand_.damping_n_s_per_m + device_.damping_n_s_per_m);
    const Vector3d r = inertia.cwiseProduct(velocity_m_s_) + hand_.stiffness_n_per_m * (goal.position_m - position_m_) +
                       hand_.damping_n_s_per_m * goal.velocity_m_s + acting_n_ + weight_n_;
    if (r.norm() <= device_.friction_n) {
        // Stuck. The midpoint rule alone would turn the small rest of the velocity round, for ever.
        velocity_m_s_.setZero();
        return;
    }
    const double speed_m_s = speed_of(a, r, device_.friction_n);
    const Vector3d w = speed_m_s / (a.array() * speed_m_s + device_.friction_n) * r.array();
    position_m_ += step_s * w;
    velocity_m_s_ = 2.0 * w - velocity_m_s_;
    stop_at_reach();
}

/// Mechanical stops: hard, and without a rebound.
void PointDevice::stop_at_reach() {
    for (int i = 0; i < 3; ++i) {
        const double most_m = device_.reach_m[static_cast<std::size_t>(i)] / 2.0;
        if (most_m <= 0.0 || std::abs(position_m_[i]) <= most_m) continue;
        position_m_[i] = std::copysign(most_m, position_m_[i]);
        velocity_m_s_[i] = 0.0;
    }
}

Eigen::Vector3d PointDevice::encoder_m() const {
    const double step_m = device_.encoder_step_m;
    if (step_m <= 0.0) return position_m_;
    return (position_m_ / step_m).array().round().matrix() * step_m;
}

double PointDevice::energy_j(const Eigen::Vector3d& goal_m) const {
    return 0.5 * mass_kg_.dot(velocity_m_s_.cwiseAbs2()) +
           0.5 * hand_.stiffness_n_per_m * (goal_m - position_m_).squaredNorm();
}

}  // namespace haptable
