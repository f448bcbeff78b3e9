// SPDX-License-Identifier: GPL-2.0-or-later
// From the device's hand to the body and back: x_body = p + s_x R M x_device, F_device = s_f (R M)^T F_body.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "host/device/wrist.hpp"
#include "host/scene/device.hpp"

namespace haptable {

/// The device's coordinates and the body's, with a clutch. Lengths in metres, forces in newtons.
///
/// While the clutch is held, the finger stays where it is at the body and the force falls; when it is let go, the
/// finger goes on from there (the index is another one) and the force comes back. Both take DeviceMap::ramp_s. Outside
/// of the workspace the force falls too, and the finger follows the device.
class DeviceMapping {
public:
    explicit DeviceMapping(const DeviceMap& map = {});

    /// With the index as it is now.
    Eigen::Vector3d to_body(const Eigen::Vector3d& device_m) const { return origin_m_ + matrix_ * device_m; }
    Eigen::Vector3d to_device(const Eigen::Vector3d& body_m) const { return inverse_ * (body_m - origin_m_); }
    Eigen::Vector3d velocity_to_body(const Eigen::Vector3d& device_m_s) const { return matrix_ * device_m_s; }
    Eigen::Vector3d velocity_to_device(const Eigen::Vector3d& body_m_s) const { return inverse_ * body_m_s; }

    /// An orientation in the body's axes: a tool that is not turned in the device's is not turned in the body's.
    Turning to_body(const Turning& device) const;
    Turning to_device(const Turning& body) const;

    /// The device is at `device_m`, `step_s` later than at the last call; the first call's does not count.
    void follow(const Eigen::Vector3d& device_m, bool clutched, double step_s, const Turning& wrist = {});
    /// Where the finger is at the body.
    const Eigen::Vector3d& finger_m() const { return finger_m_; }
    /// How the tool is turned there.
    const Turning& tool() const { return tool_; }

    /// What the motors give for a force of the body's: scaled, turned, and the share of it that the clutch lets
    /// through.
    Eigen::Vector3d to_motors(const Eigen::Vector3d& body_n) const { return share_ * (force_ * body_n); }
    /// The torque likewise, about the handle: scaled as the force.
    Eigen::Vector3d torque_to_motors(const Eigen::Vector3d& body_n_m) const {
        return share_ * handed_ * (force_ * body_n_m);
    }
    /// A force of the device's in the body's axes, not scaled: for records.
    Eigen::Vector3d turned_to_body(const Eigen::Vector3d& device_n) const { return turn_ * device_n; }
    /// Share of the force: 1, and less while the clutch or the workspace has it fall.
    double share() const { return share_; }

private:
    bool is_outside(const Eigen::Vector3d& device_m) const;

    Eigen::Matrix3d turn_, matrix_, inverse_, force_;
    double handed_;  ///< -1: the device's coordinates are left-handed
    Eigen::Vector3d origin_m_, finger_m_;
    Eigen::Quaterniond index_ = Eigen::Quaterniond::Identity();  ///< that the clutch has turned the tool by
    Turning tool_;
    double ramp_s_;
    std::optional<std::array<double, 6>> workspace_m_;
    double share_ = 1.0;
    bool begun_ = false, was_clutched_ = false;
};

}  // namespace haptable
