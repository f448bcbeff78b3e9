// SPDX-License-Identifier: GPL-2.0-or-later
// How a simulated hand turns a tool: a rigid body on a spring and a damper to the orientation that the hand wants.
#pragma once

#include <Eigen/Geometry>

namespace haptable {

/// A hand's orientation and how fast it turns, world axes.
struct Turning {
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
};

/// The rotation vector, rad, of length at most pi.
Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& turn);
Eigen::Quaterniond turned_by(const Eigen::Vector3d& rotation_rad);

/// I w' = k r + c (w_t - w) + T, r the rotation vector from the orientation to the one wanted, by the implicit midpoint
/// rule as PointDevice. Figures of a pen of 45 g and 0.15 m in a hand; the stiffness of a wrist is of that order
/// (Formica et al., J. Neurophysiol. 108, 2012), a grip on a pen is softer.
class Wrist {
public:
    explicit Wrist(const Eigen::Quaterniond& start) { now_.turn = start; }

    /// On the hand, N m, until set again; what is not finite is zero.
    void set_torque(const Eigen::Vector3d& torque_n_m);
    void advance(const Turning& goal, double step_s);
    const Turning& now() const { return now_; }

private:
    static constexpr double kInertia_kg_m2 = 8e-5, kStiffness_n_m_per_rad = 1.0, kDamping_n_m_s_per_rad = 0.02;

    Turning now_;
    Eigen::Vector3d torque_n_m_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
