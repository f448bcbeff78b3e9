// SPDX-License-Identifier: GPL-2.0-or-later
// What is heard of a session: kept as an LCM log, and told in one line a second.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "host/link/connection.hpp"
#include "host/link/joined.hpp"
#include "host/link/log_writer.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/run/body_frame.hpp"

namespace haptable {

/// True of the counters that say that something went wrong, or was kept from going wrong; the others say how much was
/// done.
bool is_fault(const std::string& counter);

class Recorder {
public:
    /// Hears all channels of the list. What is heard goes to `log` from the next message on.
    Recorder(Connection& connection, LogWriter& log);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// States of a device, or of both.
    std::int64_t states() const { return side_[0].states + side_[1].states; }
    /// What came since the last call: "contact  0.412 N  2.93 mm  1000 ticks, 0 unanswered  latency 85 us ...". Where a
    /// second finger has spoken, its part follows behind a bar.
    std::string line();

private:
    // States that wait for their answer: one that is later yet has no latency.
    static constexpr std::size_t kWaiting = 64;
    // Counters of a servo are some tens; names that somebody else invents take no more memory than so many.
    static constexpr std::size_t kMostFaults = 256;

    /// What is heard of one finger and its device.
    struct Side {
        OpenStates<std::int64_t> sent{kWaiting};  ///< when
        std::int64_t states = 0, told_states = 0, answers = 0;
        DurationStatistics latency;
        int servo_state = -1;
        double force_n = 0.0, depth_m = 0.0;  ///< of the last answer
    };

    void take(const device_state& state, std::int64_t utime, Side& side);
    static void take(const servo_force& force, std::int64_t utime, Side& side);
    void take(const body_pose& pose, std::int64_t, Side&);
    void take(const tool_wrench& wrench, std::int64_t, Side&);
    template <typename Message>
    static void take(const Message&, std::int64_t, Side&) {}  // others are kept, not told
    void take(const contact& touched, std::int64_t, Side& side) const;
    void take(const servo_status& status, std::int64_t, Side&);
    std::string line(Side& side) const;
    std::string grown_faults();

    LogWriter& log_;
    std::array<Side, kFingers> side_;
    BodyFrame body_;
    bool simulated_ = false;
    std::map<std::string, std::int64_t> faults_, told_faults_;
};

}  // namespace haptable
