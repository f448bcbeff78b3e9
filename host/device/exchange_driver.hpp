// SPDX-License-Identifier: GPL-2.0-or-later
// What drivers of real devices share: a force goes out and asks for a reading, which is there by the next tick.
#pragma once

#include <string>
#include <vector>

#include "host/device/driver.hpp"
#include "host/device/drivers.hpp"
#include "host/link/clock.hpp"

namespace haptable {

/// The force is cut to the limit; a reading that comes late, jumps or is none is counted and left out; a device that
/// has not answered for 20 ms has gone: Error, and no force. A driver says how a force is sent and what came.
class ExchangeDriver : public Driver {
public:
    Reading read(std::int64_t tick) final;
    void set_force(const Eigen::Vector3d& force_n) final;
    const Eigen::Vector3d& force_n() const final { return force_n_; }
    std::vector<Counter> counters() const override { return {{"late_readings", late_}, {"odd_readings", odd_}}; }

protected:
    /// `name`: for messages, "/dev/ttyACM0".
    ExchangeDriver(std::string name, const DriverOptions& options)
        : name_(std::move(name)), limit_n_(options.max_force_n), silence_s_(options.silence_s) {}

    /// Sends the force that it is given, which also asks for a reading. Throws Error when the device has gone.
    virtual void send(const Eigen::Vector3d& force_n) = 0;
    /// Takes what has come, without waiting. True where `reading` is a new one.
    virtual bool take(Reading& reading) = 0;

    /// Asks without a force until the first reading comes; for constructors. Throws Error with `hint` after
    /// `patience_s`.
    void wait_for_first(double patience_s, const std::string& hint);
    /// For destructors: no force, as far as the device still listens.
    void send_no_force() noexcept;
    /// One more of what came and is no reading.
    void count_odd() { ++odd_; }
    const std::string& name() const { return name_; }

private:
    void ask(const Eigen::Vector3d& force_n);
    bool take_plausible();

    std::string name_;
    double limit_n_, silence_s_;
    Eigen::Vector3d force_n_ = Eigen::Vector3d::Zero();
    Reading newest_;
    Clock::time_point came_{};   ///< the newest reading
    Clock::time_point asked_{};  ///< the first that has no answer yet
    bool waits_ = false;         ///< for an answer
    bool has_asked_ = false;     ///< since the last read
    bool has_one_ = false;
    std::int64_t late_ = 0, odd_ = 0;
};

}  // namespace haptable
