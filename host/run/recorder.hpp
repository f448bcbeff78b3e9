// SPDX-License-Identifier: GPL-2.0-or-later
// What is heard of a session: kept as an LCM log, and told in one line a second.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "host/link/channels.hpp"
#include "host/link/connection.hpp"
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
    /// Subscribes to all channels. What is heard goes to `log` from the next message on.
    Recorder(Connection& connection, LogWriter& log);
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// Of a device, or of both.
    std::int64_t states() const { return side_[0].states + side_[1].states; }
    /// What came since the last call: "contact  0.412 N  2.93 mm  1000 ticks, 0 unanswered  latency 85 us ...". Where a
    /// second finger has spoken, its part follows behind a bar.
    std::string line();

private:
    // Times of states that wait for their answer: an answer that is later yet has no latency.
    static constexpr std::size_t kWaiting = 64;
    // Counters of a servo are some tens; names that somebody else invents take no more memory than so many.
    static constexpr std::size_t kMostFaults = 256;

    /// What is heard of one finger and its device.
    struct Side {
        std::array<std::pair<std::int64_t, std::int64_t>, kWaiting> sent{};  ///< seq, utime
        std::int64_t states = 0, told_states = 0, answers = 0;
        DurationStatistics latency;
        int servo_state = -1;
        double force_n = 0.0, depth_m = 0.0;  ///< of the last answer
    };

    void listen(Connection& connection, std::size_t finger);
    /// Keeps what comes on the channel, and takes what is whole.
    template <typename Message, typename Take>
    void listen(Connection& connection, const char* channel, Take take);
    static void take(const device_state& state, std::int64_t utime, Side& side);
    static void take(const servo_force& force, std::int64_t utime, Side& side);
    void take(const contact& touched, Side& side) const;
    void take(const servo_status& status);
    std::string line(Side& side) const;
    std::string grown_faults();

    LogWriter& log_;
    std::array<Side, kFingers> side_;
    BodyFrame body_;
    bool simulated_ = false;
    std::map<std::string, std::int64_t> faults_, told_faults_;
};

}  // namespace haptable
