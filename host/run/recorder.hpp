// SPDX-License-Identifier: GPL-2.0-or-later
// What is heard of a session: kept as an LCM log, and told in one line a second.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "host/link/connection.hpp"
#include "host/link/log_writer.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"

namespace haptable {

/// True of the counters that say that something went wrong, or was kept from going wrong; the others say how much was
/// done.
bool is_fault(const std::string& counter);

class Recorder {
public:
    /// Subscribes to all channels. What is heard goes to `log` from the next message on.
    Recorder(Connection& connection, LogWriter& log);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    std::int64_t states() const { return states_; }
    /// What came since the last call: "contact  0.412 N  2.93 mm  1000 ticks, 0 unanswered  latency 85 us ...".
    std::string line();

private:
    void keep(const char* channel, std::span<const std::uint8_t> bytes, std::int64_t utime);
    void take(const device_state& state, std::int64_t utime);
    void take(const servo_force& force, std::int64_t utime);
    void take(const contact& touched);
    void take(const servo_status& status);
    std::string grown_faults();

    // Times of states that wait for their answer: an answer that is later yet has no latency.
    static constexpr std::size_t kWaiting = 64;

    LogWriter& log_;
    std::array<std::pair<std::int64_t, std::int64_t>, kWaiting> sent_{};  ///< seq, utime
    std::int64_t states_ = 0, told_states_ = 0, answers_ = 0;
    DurationStatistics latency_;
    bool simulated_ = false;
    int servo_state_ = -1;
    double force_n_ = 0.0, depth_m_ = 0.0;  ///< of the last answer
    std::map<std::string, std::int64_t> faults_, told_faults_;
};

}  // namespace haptable
