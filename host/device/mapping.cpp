// SPDX-License-Identifier: GPL-2.0-or-later
// Power: F_device . v_device = s_f / s_x  F_body . v_body. A body of stiffness S feels s_x s_f S stiff to the hand.
#include "host/device/mapping.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// R M, of length 1 in every row: turned about x, then y, then z; the first axis of a left-handed device is mirrored.
Matrix3d turn_of(const DeviceMap& map) {
    Matrix3d turn = Matrix3d::Identity();
    for (int axis = 0; axis < 3; ++axis) {
        const double angle = map.rotation_deg[static_cast<std::size_t>(axis)] * std::numbers::pi / 180.0;
        turn = Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix() * turn;
    }
    if (map.left_handed) turn.col(0) *= -1.0;
    return turn;
}

}  // namespace

DeviceMapping::DeviceMapping(const DeviceMap& map)
    : turn_(turn_of(map)),
      matrix_(map.motion_scale * turn_),
      inverse_(turn_.transpose() / map.motion_scale),
      force_(map.force_scale * turn_.transpose()),
      handed_(map.left_handed ? -1.0 : 1.0),
      origin_m_(map.position_m.data()),
      finger_m_(origin_m_),
      ramp_s_(map.ramp_s),
      workspace_m_(map.workspace_m) {}

bool DeviceMapping::is_outside(const Vector3d& device_m) const {
    if (!workspace_m_) return false;
    for (std::size_t i = 0; i < 3; ++i) {
        const double at_m = device_m[static_cast<int>(i)];
        // Not "outside of the interval": what is no number is outside too.
        if (!(at_m >= (*workspace_m_)[i] && at_m <= (*workspace_m_)[i + 3])) return true;
    }
    return false;
}

// A turn about an axis is one about that axis's image, the other way round in a mirror.
Turning DeviceMapping::to_body(const Turning& device) const {
    const Matrix3d turned = turn_ * device.turn.toRotationMatrix() * turn_.transpose();
    return {index_ * Eigen::Quaterniond(turned), index_ * (handed_ * (turn_ * device.spin_rad_s))};
}

Turning DeviceMapping::to_device(const Turning& body) const {
    const Matrix3d turned = (index_.conjugate() * body.turn).toRotationMatrix();
    return {Eigen::Quaterniond(Matrix3d(turn_.transpose() * turned * turn_)),
            handed_ * (turn_.transpose() * (index_.conjugate() * body.spin_rad_s))};
}

void DeviceMapping::follow(const Vector3d& device_m, bool clutched, double step_s, const Turning& wrist) {
    // While it was held the device went elsewhere: from now on that place is the finger's.
    if (begun_ && (clutched || was_clutched_)) {
        origin_m_ += finger_m_ - to_body(device_m);
        // Of length 1 again: what it lacks would grow from tick to tick.
        index_ = (tool_.turn * to_body(wrist).turn.conjugate() * index_).normalized();
    }
    finger_m_ = to_body(device_m);
    tool_ = to_body(wrist);
    const double step = ramp_s_ > 0.0 ? step_s / ramp_s_ : 1.0;
    const bool falls = clutched || is_outside(device_m);
    if (!begun_)
        share_ = falls ? 0.0 : 1.0;
    else
        share_ = std::clamp(share_ + (falls ? -step : step), 0.0, 1.0);
    was_clutched_ = clutched;
    begun_ = true;
}

}  // namespace haptable
