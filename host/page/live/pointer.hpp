// SPDX-License-Identifier: GPL-2.0-or-later
// A pointer as a device on LCM: where a page wants the hand to be, and the device that this hand holds.
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "host/device/driver.hpp"
#include "host/device/point_device.hpp"
#include "host/device/session.hpp"

namespace haptable {

/// What a page asks of the hand.
struct PointerWish {
    bool is_there = false;                             ///< a page has the pointer over the body
    std::int64_t place = 0;                            ///< another number: the hand is somewhere else at once
    Eigen::Vector3d goal_m = Eigen::Vector3d::Zero();  ///< in body coordinates
    double gain = 1.0;                                 ///< the hand feels so many times the force
    double stiffness_n_per_m = Hand{}.stiffness_n_per_m;
    std::int32_t buttons = 0;
};

/// Between the thread that serves pages and that of the device.
class PointerDesk {
public:
    /// Changes the wish.
    void ask(const std::function<void(PointerWish&)>& change);
    PointerWish wish() const;
    /// Waits until a page has the pointer there; false: closed.
    bool wait();
    void close();

private:
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    PointerWish wish_;
    bool closed_ = false;
};

/// A point device in the hand of a pointer. Ends when the pointer has gone, or is somewhere else.
class PointerDriver : public Driver {
public:
    PointerDriver(const Device& device, const PointerDesk& desk);

    Reading read(std::int64_t tick) override;
    void set_force(const Eigen::Vector3d& force_n) override { device_.set_force(wish_.gain * force_n); }
    const Eigen::Vector3d& force_n() const override { return device_.force_n(); }
    void advance(std::int64_t tick, double share) override;
    bool has_ended() const override;

private:
    const PointerDesk& desk_;
    PointerWish wish_;
    PointDevice device_;
    HandGoal goal_;
    int substep_ = 0;  ///< of this tick, as far as it is integrated
};

/// The thread of the device: a session for each stay of the pointer. A hand that goes elsewhere at once is another
/// session, as a servo believes no position that no finger reaches.
class PointerDevice {
public:
    /// finger: of the scene, 0 or 1.
    PointerDevice(const Device& device, std::int64_t model_hash, LiveState::Tell tell, std::size_t finger = 0);
    ~PointerDevice();
    PointerDevice(const PointerDevice&) = delete;
    PointerDevice& operator=(const PointerDevice&) = delete;

    PointerDesk& desk() { return desk_; }
    /// Ends the thread; the ticks of all its sessions.
    std::int64_t finish();
    /// So far.
    std::int64_t sessions() const { return sessions_; }

private:
    void run();
    void run_session();

    Device device_;
    std::int64_t model_hash_;
    LiveState::Tell tell_;
    std::size_t finger_;
    PointerDesk desk_;
    std::atomic<std::int64_t> ticks_ = 0, sessions_ = 0;
    std::thread thread_;
};

}  // namespace haptable
