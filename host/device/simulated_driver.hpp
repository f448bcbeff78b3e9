// SPDX-License-Identifier: GPL-2.0-or-later
// The simulated device as a driver: a point, and a wrist, in a hand that follows a path and presses buttons.
#pragma once

#include <string>
#include <vector>

#include "host/device/driver.hpp"
#include "host/device/mapping.hpp"
#include "host/device/path.hpp"
#include "host/device/point_device.hpp"
#include "host/device/wrist.hpp"

namespace haptable {

/// A button that is held from one time to another, s.
struct Press {
    std::int32_t button;
    double from_s, to_s;
};

/// "clutch:0.5:0.8,grab:1:2": button, from, to. Throws Error for another button or an empty time.
std::vector<Press> presses_of(const std::string& text);

/// The path is the body's, seen through the mapping as it is at the begin: where the clutch brings another index, the
/// hand goes on in its own coordinates.
class SimulatedDriver : public Driver {
public:
    SimulatedDriver(const PointDevice& device, const Path& path, const DeviceMapping& mapping = DeviceMapping(),
                    std::vector<Press> presses = {});

    Reading read(std::int64_t tick) override;
    void set_force(const Eigen::Vector3d& force_n) override { device_.set_force(force_n); }
    void set_torque(const Eigen::Vector3d& torque_n_m) override { wrist_.set_torque(torque_n_m); }
    const Eigen::Vector3d& force_n() const override { return device_.force_n(); }
    void advance(std::int64_t tick, double share) override;
    double duration_s() const override { return path_.duration_s(); }

private:
    HandGoal goal(double time_s) const;

    PointDevice device_;
    Wrist wrist_;
    const Path& path_;
    DeviceMapping mapping_;
    std::vector<Press> presses_;
    int substep_ = 0;  ///< of this tick, as far as it is integrated
};

}  // namespace haptable
