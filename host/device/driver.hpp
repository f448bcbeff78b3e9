// SPDX-License-Identifier: GPL-2.0-or-later
// What a session needs of a device, simulated or real: a driver is one file that does this.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "host/device/wrist.hpp"

namespace haptable {

/// Bits of a device's buttons.
inline constexpr std::int32_t kClutchButton = 1, kGrabButton = 2, kAcknowledgeButton = 4;

inline constexpr double kDeviceTick_s = 1e-3;
/// In which what is simulated goes through a tick.
inline constexpr int kDeviceSubsteps = 20;

/// In the device's coordinates: metres, metres a second.
struct Reading {
    Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  ///< the true one where the driver knows it, else zero
    Eigen::Vector3d goal_m = Eigen::Vector3d::Zero();  ///< of the hand where the driver knows it, else the position
    std::int32_t buttons = 0;
    Turning wrist = {};  ///< of a tool; of a device without orientation as it is at the begin
};

/// What happened, by name, for a summary.
struct Counter {
    std::string name;
    std::int64_t value;
};

/// A device's end point and motors. Single-threaded; every call is bounded in time.
class Driver {
public:
    virtual ~Driver() = default;

    /// The newest that is known at the begin of a tick. Throws Error when the device has gone; its motors are then
    /// without force as far as the driver can bring that about.
    virtual Reading read(std::int64_t tick) = 0;
    /// The force that the motors give from now on: cut to the device's limit, zero for what is not finite.
    virtual void set_force(const Eigen::Vector3d& force_n) = 0;
    /// The torque likewise, N m about the handle; a device without such motors gives none.
    virtual void set_torque(const Eigen::Vector3d& /*torque_n_m*/) {}
    /// What they were asked for, after that.
    virtual const Eigen::Vector3d& force_n() const = 0;
    /// Time goes on to a share of 0 to 1 of a tick. A real device needs no telling.
    virtual void advance(std::int64_t, double) {}
    /// True when it is over for good: the session ends.
    virtual bool has_ended() const { return false; }
    /// How long its path is, s; 0: endless.
    virtual double duration_s() const { return 0.0; }
    virtual std::vector<Counter> counters() const { return {}; }
};

}  // namespace haptable
