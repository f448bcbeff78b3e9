// SPDX-License-Identifier: GPL-2.0-or-later
// The device's side of the loop: state out, force in, once a millisecond of real or of simulated time.
#pragma once

#include <array>
#include <cstdint>

#include "host/device/path.hpp"
#include "host/device/point_device.hpp"
#include "host/device/record.hpp"
#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"

namespace haptable {

struct SessionOptions {
    bool lockstep = false;        ///< the clock waits for the answer to each state
    double seconds = 0.0;         ///< of real or simulated time; 0: once along the path
    double patience_s = 10.0;     ///< how long the first answer, or any in lockstep, may take; 0: do not wait
    std::int64_t model_hash = 0;  ///< of the tables whose servo must answer; 0: the first that does
};

struct DeviceReport {
    std::int64_t ticks = 0;            ///< states published
    std::int64_t missed = 0;           ///< of these, without an answer before the next one
    std::int64_t late_ticks = 0;       ///< that began more than a tick after their time
    std::int64_t resent = 0;           ///< states sent again because no answer came
    std::int64_t foreign_answers = 0;  ///< of another servo than the one this device has met
    std::int64_t contact_ticks = 0;    ///< answers with contact
    std::int64_t silences = 0;         ///< times the force was dropped because the servo had fallen silent
    double largest_force_n = 0.0;      ///< that the motors gave
    DurationStatistics latency;        ///< from publishing a state to its answer
    double wall_s = 0.0;
};

/// Single-threaded, as ServoSession is: with both on one memq:// connection the loop closes within one process.
class DeviceSession {
public:
    /// Subscribes to the servo's forces. `record` may be null.
    DeviceSession(const PointDevice& device, const Path& path, Connection& connection, const SessionOptions& options,
                  DeviceRecord* record);
    DeviceSession(const DeviceSession&) = delete;
    DeviceSession& operator=(const DeviceSession&) = delete;

    /// Runs to the end, or until Ctrl-C. Throws Error when no servo answers in time.
    DeviceReport run();

private:
    void on_force(const servo_force& force);
    void begin_tick(std::int64_t tick);
    void wait_for_answer();
    void wait_until(Clock::time_point next);
    void end_tick();
    void drop_stale_force();
    void integrate_to(int substep);
    HandGoal goal(double time_s) const;
    void publish();

    // The velocity is what a driver makes of its encoders: their way over a window of 10 ms.
    static constexpr std::size_t kWindow_ticks = 10;
    // Publication times that are kept: an answer that is later than this is not worth measuring.
    static constexpr std::size_t kKept_ticks = 64;

    PointDevice device_;
    const Path& path_;
    Connection& connection_;
    SessionOptions options_;
    DeviceRecord* record_;
    device_state state_{};  ///< of this tick
    DeviceRow row_;         ///< of this tick
    std::array<Eigen::Vector3d, kWindow_ticks> reading_m_;
    std::array<Clock::time_point, kKept_ticks> published_{};
    Clock::time_point last_answer_{};
    std::int64_t answered_ = -1;  ///< the newest state that has an answer
    bool silent_ = true;          ///< no answer for 20 ms, or none yet
    int substep_ = 0;             ///< of this tick, as far as it is integrated
    DeviceReport report_;
};

}  // namespace haptable
