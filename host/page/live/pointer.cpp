// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/live/pointer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/device/driver.hpp"
#include "host/link/realtime.hpp"

namespace haptable {

namespace {

// The pointer comes in steps of a picture: a hand goes between them.
constexpr double kGoal_ticks = 25.0;
constexpr int kPriority = 49;
// After this a servo has forgotten its device, and another may have it.
constexpr std::chrono::milliseconds kForgotten{30};

Hand hand_of(const PointerWish& wish) {
    Hand hand;
    hand.stiffness_n_per_m = wish.stiffness_n_per_m;
    return hand;
}

}  // namespace

void PointerDesk::ask(const std::function<void(PointerWish&)>& change) {
    const std::lock_guard lock(mutex_);
    change(wish_);
    changed_.notify_all();
}

PointerWish PointerDesk::wish() const {
    const std::lock_guard lock(mutex_);
    return wish_;
}

bool PointerDesk::wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || wish_.is_there; });
    return !closed_;
}

void PointerDesk::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    wish_.is_there = false;
    changed_.notify_all();
}

PointerDriver::PointerDriver(const Device& device, const PointerDesk& desk)
    : desk_(desk),
      wish_(desk.wish()),
      device_(device, hand_of(wish_), wish_.goal_m),
      goal_{wish_.goal_m, Eigen::Vector3d::Zero()} {}

bool PointerDriver::has_ended() const {
    const PointerWish now = desk_.wish();
    return !now.is_there || now.place != wish_.place;
}

Reading PointerDriver::read(std::int64_t) {
    const PointerWish now = desk_.wish();
    if (now.place == wish_.place) wish_ = now;
    device_.hold(hand_of(wish_));
    const double share = 1.0 - std::exp(-1.0 / kGoal_ticks);
    const Eigen::Vector3d step_m = share * (wish_.goal_m - goal_.position_m);
    goal_.position_m += step_m;
    goal_.velocity_m_s = step_m / kDeviceTick_s;
    substep_ = 0;
    return {device_.encoder_m(), device_.velocity_m_s(), goal_.position_m, wish_.buttons};
}

void PointerDriver::advance(std::int64_t, double share) {
    const double step_s = kDeviceTick_s / kDeviceSubsteps;
    const int until = static_cast<int>(std::min(share, 1.0) * kDeviceSubsteps);
    for (; substep_ < until; ++substep_) {
        // Evenly from the last tick's goal to this one's.
        const double left_s = kDeviceTick_s - (substep_ + 0.5) * step_s;
        device_.advance({goal_.position_m - left_s * goal_.velocity_m_s, goal_.velocity_m_s}, step_s);
    }
}

PointerDevice::PointerDevice(const Device& device, std::int64_t model_hash, LiveState::Tell tell, std::size_t finger)
    : device_(device), model_hash_(model_hash), tell_(std::move(tell)), finger_(finger), thread_([this] { run(); }) {}

PointerDevice::~PointerDevice() { finish(); }

std::int64_t PointerDevice::finish() {
    desk_.close();
    if (thread_.joinable()) thread_.join();
    return ticks_;
}

void PointerDevice::run() {
    ask_for_real_time(kPriority);
    while (desk_.wait() && !interrupted()) {
        try {
            run_session();
        } catch (const Error& error) {
            LiveState(tell_).say(fmt::format("the pointer's device: {}", error.what()));
        }
        std::this_thread::sleep_for(kForgotten);
    }
}

void PointerDevice::run_session() {
    Connection connection;
    PointerDriver driver(device_, desk_);
    SessionOptions options;
    options.patience_s = 0.0;
    options.model_hash = model_hash_;
    options.tell = tell_;
    options.finger = finger_;
    ++sessions_;
    ticks_ += DeviceSession(driver, connection, options, nullptr).run().ticks;
}

}  // namespace haptable
