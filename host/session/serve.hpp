// SPDX-License-Identifier: GPL-2.0-or-later
// The loop of a program that answers a device over LCM: messages, the watchdog, the status ten times a second.
#pragma once

#include <algorithm>

#include "host/base/interrupt.hpp"
#include "host/session/session.hpp"

namespace haptable {

inline constexpr std::chrono::milliseconds kStatusPeriod{100};  // 10 Hz

/// When a session ends by itself, s; 0: never.
struct SessionEnd {
    double after_s = 0.0;
    double until_silent_s = 0.0;  ///< the device was silent for so long, having spoken once
};

/// True when the session is over.
inline bool is_over(const Session& session, const SessionEnd& end, Clock::time_point begin) {
    using Seconds = std::chrono::duration<double>;
    const Clock::time_point now = Clock::now();
    if (end.after_s > 0.0 && now - begin >= Seconds(end.after_s)) return true;
    return end.until_silent_s > 0.0 && session.has_states() &&
           now - session.last_state() >= Seconds(end.until_silent_s);
}

/// Until the session's end, or an interrupt. `handle` takes what comes until the time that it is given, and may return
/// earlier.
template <typename Handle>
void serve(Session& session, const SessionEnd& end, Handle handle) {
    const Clock::time_point begin = Clock::now();
    Clock::time_point next_status = begin + kStatusPeriod;
    while (!interrupted() && !is_over(session, end, begin)) {
        handle(std::min(next_status, session.watch_at()));
        const Clock::time_point now = Clock::now();
        session.watch(now);
        if (now < next_status) continue;
        session.publish_status();
        next_status = now + kStatusPeriod;
    }
    session.publish_status();
}

}  // namespace haptable
