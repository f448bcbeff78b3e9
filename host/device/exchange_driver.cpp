// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/exchange_driver.hpp"

#include <fmt/format.h>

#include <thread>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"

namespace haptable {

namespace {

constexpr std::chrono::milliseconds kAskAgain{50};
constexpr std::chrono::microseconds kLook{200};

// No hand throws a device faster, and no encoder's step is longer.
constexpr double kFastest_m_s = 10.0, kStep_m = 1e-3;

double seconds_since(Clock::time_point then) { return std::chrono::duration<double>(Clock::now() - then).count(); }

}  // namespace

void ExchangeDriver::ask(const Eigen::Vector3d& force_n) {
    if (!waits_) asked_ = Clock::now();
    waits_ = has_asked_ = true;
    send(force_n);
}

/// A reading that is a number and no farther from the last one than a hand could bring it.
bool ExchangeDriver::take_plausible() {
    Reading reading = newest_;
    if (!take(reading)) return false;
    reading.goal_m = reading.position_m;
    const double way_m = (reading.position_m - newest_.position_m).norm();
    if (!reading.position_m.allFinite() || (has_one_ && !(way_m <= kFastest_m_s * seconds_since(came_) + kStep_m))) {
        count_odd();
        return false;
    }
    newest_ = reading;
    came_ = Clock::now();
    waits_ = false;
    has_one_ = true;
    return true;
}

Reading ExchangeDriver::read(std::int64_t) {
    const bool is_new = take_plausible();
    if (!has_asked_) ask(force_n_);
    has_asked_ = false;
    if (is_new) return newest_;
    ++late_;
    const double waited_s = seconds_since(asked_);
    if (waited_s < silence_s_) return newest_;
    send_no_force();
    throw Error(fmt::format("{}: the device has not answered for {:.0f} ms; its force was set to zero. Start again",
                            name_, 1e3 * waited_s));
}

void ExchangeDriver::set_force(const Eigen::Vector3d& force_n) {
    force_n_ = force_n.allFinite() ? force_n : Eigen::Vector3d::Zero();
    const double size_n = force_n_.stableNorm();
    if (size_n > limit_n_) force_n_ *= limit_n_ / size_n;
    ask(force_n_);
}

void ExchangeDriver::wait_for_first(double patience_s, const std::string& hint) {
    const Clock::time_point begin = Clock::now();
    for (Clock::time_point next = begin; !interrupted(); std::this_thread::sleep_for(kLook)) {
        if (Clock::now() >= next) {
            ask(Eigen::Vector3d::Zero());
            next = Clock::now() + kAskAgain;
        }
        if (take_plausible()) return;
        if (seconds_since(begin) > patience_s)
            throw Error(fmt::format("{}: no reading within {} s: {}", name_, patience_s, hint));
    }
    throw Error(name_ + ": interrupted before the first reading");
}

void ExchangeDriver::send_no_force() noexcept {
    force_n_.setZero();
    try {
        send(force_n_);
    } catch (const std::exception&) {
        return;  // nobody is left to be told
    }
}

}  // namespace haptable
