// SPDX-License-Identifier: GPL-2.0-or-later
// What happens in a session, told while it runs: one line when something begins, not one for every message of it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "host/link/clock.hpp"

namespace haptable {

/// Tells of counters that rise. What goes on without a second's pause is one event.
class LiveState {
public:
    /// Takes one line, without its end.
    using Tell = std::function<void(const std::string&)>;

    /// An empty `tell`: nothing is told.
    explicit LiveState(Tell tell) : tell_(std::move(tell)) {}

    /// Tells `text()` when the counter of this name has risen and had not in the second before. Give its value a few
    /// times a second at least.
    template <typename Text>
    void look(std::string_view counter, std::int64_t value, Clock::time_point now, const Text& text) {
        // Even of 0: a session has all the memory that it needs from its first look on.
        auto seen = seen_.find(counter);
        if (seen == seen_.end()) seen = seen_.emplace(counter, Seen{}).first;
        if (value <= seen->second.value) return;
        const bool goes_on = seen->second.value > 0 && now - seen->second.risen < kPause;
        seen->second = {value, now};
        if (!goes_on) say(text());
    }
    /// Tells it now.
    void say(const std::string& text) const {
        if (tell_) tell_(text);
    }

private:
    static constexpr std::chrono::seconds kPause{1};
    struct Seen {
        std::int64_t value = 0;
        Clock::time_point risen{};
    };

    Tell tell_;
    std::map<std::string, Seen, std::less<>> seen_;
};

/// Lines "PROGRAM: TEXT" on standard error; with `quiet` none.
LiveState::Tell teller(const std::string& program, bool quiet);

}  // namespace haptable
