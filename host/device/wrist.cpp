// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/wrist.hpp"

namespace haptable {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d rotation_vector(const Quaterniond& turn) {
    const Eigen::AngleAxisd about(turn.w() < 0.0 ? Quaterniond(-turn.coeffs()) : turn);
    return about.angle() * about.axis();
}

Quaterniond turned_by(const Vector3d& rotation_rad) {
    const double angle = rotation_rad.norm();
    return angle > 0.0 ? Quaterniond(Eigen::AngleAxisd(angle, rotation_rad / angle)) : Quaterniond::Identity();
}

void Wrist::set_torque(const Vector3d& torque_n_m) {
    torque_n_m_ = torque_n_m.allFinite() ? torque_n_m : Vector3d::Zero();
}

void Wrist::advance(const Turning& goal, double step_s) {
    const double inertia = 2.0 / step_s * kInertia_kg_m2;
    const Vector3d to_goal = rotation_vector(goal.turn * now_.turn.conjugate());
    const Vector3d spin_rad_s = (inertia * now_.spin_rad_s + kStiffness_n_m_per_rad * to_goal +
                                 kDamping_n_m_s_per_rad * goal.spin_rad_s + torque_n_m_) /
                                (inertia + kStiffness_n_m_per_rad * step_s / 2.0 + kDamping_n_m_s_per_rad);
    now_.turn = (turned_by(step_s * spin_rad_s) * now_.turn).normalized();
    now_.spin_rad_s = 2.0 * spin_rad_s - now_.spin_rad_s;
}

}  // namespace haptable
