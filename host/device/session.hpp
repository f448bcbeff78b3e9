// SPDX-License-Identifier: GPL-2.0-or-later
// The device's side of the loop: state out, force in, once a millisecond of real or of simulated time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/device/driver.hpp"
#include "host/device/events.hpp"
#include "host/device/faults.hpp"
#include "host/device/faulty_lane.hpp"
#include "host/device/mapping.hpp"
#include "host/device/path.hpp"
#include "host/device/point_device.hpp"
#include "host/device/record.hpp"
#include "host/link/clock.hpp"
#include "host/link/connection.hpp"
#include "host/link/live_state.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"

namespace haptable {

struct SessionOptions {
    bool lockstep = false;        ///< the clock waits for the answer to each state
    double seconds = 0.0;         ///< of real or simulated time; 0: once along the path
    double patience_s = 10.0;     ///< how long the first answer, or any in lockstep, may take; 0: do not wait
    LiveState::Tell tell;         ///< gets a line for each event; may be empty
    std::int64_t model_hash = 0;  ///< of the tables whose servo must answer; 0: the first that does
    FaultPlan faults;             ///< on purpose; none unless asked for
    std::uint64_t seed = 1;       ///< of their dice
    std::function<void(const DeviceRow&)> watch;  ///< called at the end of each tick; may be empty
    DeviceMap map;                                ///< from the device to the body
    std::size_t finger = 0;                       ///< of the scene, 0 or 1, that it is
    bool has_tool = false;                        ///< its hand holds the scene's tool: its orientation is told too
};

struct DeviceReport {
    std::int64_t ticks = 0;                 ///< states published
    std::int64_t missed = 0;                ///< of these, without an answer before the next one
    std::int64_t late_ticks = 0;            ///< that began more than a tick after their time
    std::int64_t resent = 0;                ///< states sent again because no answer came
    std::int64_t foreign_answers = 0;       ///< of another servo than the one this device belongs to
    std::int64_t other_device_answers = 0;  ///< to another device
    std::int64_t refused_answers = 0;       ///< of a servo that belongs to another device
    std::int64_t stale_answers = 0;         ///< older than 20 ms: as if none had come
    std::int64_t contact_ticks = 0;         ///< answers with contact
    std::int64_t clutched_ticks = 0;        ///< with the clutch held, or outside of the workspace
    std::int64_t silences = 0;              ///< times the force was dropped because the servo had fallen silent
    double largest_force_n = 0.0;           ///< that the motors gave
    double largest_torque_n_m = 0.0;        ///< of a tool, likewise
    DurationStatistics latency;             ///< from publishing a state to its answer, however late
    DurationStatistics force_age;           ///< at the end of each tick, of the state that its force answers
    double wall_s = 0.0;
};

class DeviceSession;

/// Hands of one program, on one connection: their ticks begin together, and in lockstep wait for both answers. They
/// have the servo one after the other, the first one first, so that two such sessions are the same. Runs as
/// DeviceSession::run does, until the longest path's end.
void run_together(const std::vector<DeviceSession*>& hands);

/// Single-threaded, as Session is: with both on one memq:// connection the loop closes within one process.
class DeviceSession {
public:
    /// Subscribes to the servo's forces. `record` may be null.
    DeviceSession(Driver& driver, Connection& connection, const SessionOptions& options, DeviceRecord* record);
    /// With a simulated device on that path of the body's.
    DeviceSession(const PointDevice& device, const Path& path, Connection& connection, const SessionOptions& options,
                  DeviceRecord* record);
    DeviceSession(const DeviceSession&) = delete;
    DeviceSession& operator=(const DeviceSession&) = delete;

    /// Runs to the end, or until Ctrl-C. Throws Error when no servo answers in time.
    DeviceReport run();
    const DeviceReport& report() const { return report_; }

private:
    friend void run_together(const std::vector<DeviceSession*>& hands);
    class Loop;

    void on_force(const servo_force& force);
    Eigen::Vector3d torque_of(const servo_force& force) const;
    void begin_faults();
    void deliver();
    Clock::time_point due() const;
    std::int64_t tick_count() const;
    bool is_unanswered() const { return answered_ < state_.seq; }
    void feel(const Eigen::Vector3d& body_n, const Eigen::Vector3d& body_n_m = Eigen::Vector3d::Zero());
    bool is_for_us(const servo_force& force);
    Clock::duration age_of(const servo_force& force, Clock::time_point now) const;
    void forget_servo();
    std::string why_none() const;
    std::string of_other_scene() const;
    void begin_tick(std::int64_t tick);
    void ask_again(int resends);
    [[noreturn]] void give_up() const;
    void end_tick();
    void drop_stale_force();
    void tell();
    DeviceSession(std::unique_ptr<Driver> driver, Connection& connection, const SessionOptions& options,
                  DeviceRecord* record);
    void publish();

    // The velocity is what a driver makes of its encoders: their way over a window of 10 ms.
    static constexpr std::size_t kWindow_ticks = 10;
    // Publication times that are kept, 4 s of them: an answer that is later yet is as late as the oldest.
    static constexpr std::size_t kKept_ticks = 4096;

    std::unique_ptr<Driver> own_;  ///< null where the driver is another's
    Driver& driver_;
    Connection& connection_;
    SessionOptions options_;
    DeviceMapping mapping_;
    DeviceRecord* record_;
    /// What stands between this session and its servo, where faults are asked for.
    struct Faults {
        DeviceFaults device;
        FaultyLane out, in;
        bool gone = false;  ///< in this tick
    };
    std::optional<Faults> faults_;
    Eigen::Vector3d body_force_n_ = Eigen::Vector3d::Zero();     ///< of the newest answer
    Eigen::Vector3d body_torque_n_m_ = Eigen::Vector3d::Zero();  ///< the same
    hand_pose pose_{};                                           ///< of a tool in this tick
    tool_wrench wrench_{};                                       ///< the newest, whose force may still come
    device_state state_{};                                       ///< of this tick
    DeviceRow row_;                                              ///< of this tick
    std::array<Eigen::Vector3d, kWindow_ticks> reading_m_;
    std::vector<Clock::time_point> published_ = std::vector<Clock::time_point>(kKept_ticks);
    Clock::time_point asked_{};     ///< when the state was published that the force answers
    std::int64_t other_owner_ = 0;  ///< session of a device that has the servo which refused us
    std::int64_t other_scene_ = 0;  ///< times a servo of other tables said what it is
    std::int64_t other_hash_ = 0;   ///< its tables
    std::int64_t first_ = 0;        ///< whose answer is taken: after silence the next one
    std::int64_t answered_ = -1;    ///< the newest state that has an answer
    bool silent_ = true;            ///< no answer for 20 ms, or none yet
    Events events_;
    LiveState live_;
    DeviceReport report_;
};

}  // namespace haptable
