// SPDX-License-Identifier: GPL-2.0-or-later
// Messages that belong together: a state and its answers by session and seq, the fingers of a tick by their time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "host/link/messages.hpp"

namespace haptable {

/// The states of one finger whose answers may still come, and what is kept of each. Of more than `most` the first is
/// forgotten: it has no answer.
template <typename Kept>
class OpenStates {
public:
    explicit OpenStates(std::size_t most = 4096) : most_(most) {}

    /// False where that state is open already: it was sent once more.
    bool add(const device_state& state, Kept kept) {
        const Name name(state.session, state.seq);
        if (!open_.try_emplace(name, std::move(kept)).second) return false;
        order_.push_back(name);
        if (order_.size() > most_) {
            open_.erase(order_.front());
            order_.pop_front();
        }
        return true;
    }
    /// What is kept of the state that a message answers; null: it is not known.
    template <typename Answer>
    Kept* find(const Answer& answer) {
        const auto found = open_.find(Name(answer.session, answer.seq));
        return found == open_.end() ? nullptr : &found->second;
    }
    /// The same, once: a second answer to it is none.
    template <typename Answer>
    std::optional<Kept> take(const Answer& answer) {
        const auto found = open_.find(Name(answer.session, answer.seq));
        if (found == open_.end()) return std::nullopt;
        return std::move(open_.extract(found).mapped());
    }

private:
    using Name = std::pair<std::int64_t, std::int64_t>;  ///< session, seq

    std::size_t most_;
    std::map<Name, Kept> open_;
    std::deque<Name> order_;  ///< in which they came; some are taken already
};

/// The parts of a tick: what has one time, of each finger at most one.
template <typename Part>
class JoinedTick {
public:
    struct Tick {
        std::int64_t utime = 0;
        std::size_t first = 0;  ///< the finger that came first
        std::array<std::optional<Part>, kFingers> part{};
    };

    bool is_open() const { return tick_.has_value(); }
    /// Nothing of another time belongs to it.
    bool is_of(std::int64_t utime) const { return tick_ && tick_->utime == utime; }
    bool is_full(std::size_t fingers) const {
        for (std::size_t finger = 0; finger < fingers; ++finger)
            if (!tick_ || !tick_->part[finger]) return false;
        return true;
    }
    /// Ends the tick that the part does not belong to, and gives it; then the part begins the next one.
    std::optional<Tick> add(std::size_t finger, std::int64_t utime, Part part) {
        std::optional<Tick> ended;
        if (tick_ && (tick_->utime != utime || tick_->part[finger])) ended = end();
        if (!tick_) tick_ = Tick{utime, finger, {}};
        tick_->part[finger] = std::move(part);
        return ended;
    }
    /// The tick, where one is open, which is over.
    std::optional<Tick> end() { return std::exchange(tick_, std::nullopt); }

private:
    std::optional<Tick> tick_;
};

}  // namespace haptable
