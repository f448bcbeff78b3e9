// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/simulated_driver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/base/text.hpp"

namespace haptable {

namespace {

// 20 kHz: twenty times finer than the servo sees, and far above the hand's few hertz.

std::int32_t button_of(const std::string& name) {
    if (name == "clutch") return kClutchButton;
    if (name == "grab") return kGrabButton;
    if (name == "acknowledge") return kAcknowledgeButton;
    return 0;
}

}  // namespace

std::vector<Press> presses_of(const std::string& text) {
    std::vector<Press> presses;
    for (const std::string& one : split(text, ',')) {
        const std::vector<std::string> part = split(one, ':');
        Press press{part.empty() ? 0 : button_of(part[0]), 0.0, 0.0};
        if (part.size() != 3 || press.button == 0 || !read_number(part[1], press.from_s) ||
            !read_number(part[2], press.to_s) || !(press.to_s > press.from_s))
            throw Error(
                fmt::format("--press: \"{}\" is not BUTTON:FROM:TO in seconds, such as clutch:0.5:0.8; buttons "
                            "are clutch, grab and acknowledge",
                            one));
        presses.push_back(press);
    }
    return presses;
}

SimulatedDriver::SimulatedDriver(const PointDevice& device, const Path& path, const DeviceMapping& mapping,
                                 std::vector<Press> presses)
    : device_(device),
      wrist_(mapping.to_device(path.at(0.0).wrist).turn),
      path_(path),
      mapping_(mapping),
      presses_(std::move(presses)) {}

HandGoal SimulatedDriver::goal(double time_s) const {
    const double duration_s = path_.duration_s();
    // Longer than the path: along it again. Its very end belongs to it.
    const HandGoal goal = path_.at(time_s > duration_s ? std::fmod(time_s, duration_s) : time_s);
    return {mapping_.to_device(goal.position_m), mapping_.velocity_to_device(goal.velocity_m_s), goal.buttons,
            mapping_.to_device(goal.wrist)};
}

Reading SimulatedDriver::read(std::int64_t tick) {
    const double time_s = static_cast<double>(tick) * kDeviceTick_s;
    substep_ = 0;
    const HandGoal hand = goal(time_s);
    Reading reading{device_.encoder_m(), device_.velocity_m_s(), hand.position_m,
                    static_cast<std::int32_t>(hand.buttons), wrist_.now()};
    for (const Press& press : presses_)
        if (time_s >= press.from_s && time_s < press.to_s) reading.buttons |= press.button;
    return reading;
}

void SimulatedDriver::advance(std::int64_t tick, double share) {
    const double step_s = kDeviceTick_s / kDeviceSubsteps;
    const double begin_s = static_cast<double>(tick) * kDeviceTick_s;
    const int until = static_cast<int>(std::min(share, 1.0) * kDeviceSubsteps);
    for (; substep_ < until; ++substep_) {
        const HandGoal hand = goal(begin_s + (substep_ + 0.5) * step_s);
        device_.advance(hand, step_s);
        wrist_.advance(hand.wrist, step_s);
    }
}

}  // namespace haptable
