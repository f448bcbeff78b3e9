// SPDX-License-Identifier: GPL-2.0-or-later
// One way of a connection on which messages are lost, late, doubled, out of order or damaged, by lot.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/device/faults.hpp"

namespace haptable {

class FaultyLane {
public:
    FaultyLane(const FaultPlan& plan, std::uint64_t seed);

    /// A message goes in, at most kMost_bytes; a longer one, and one more than kSlots that are on their way, is lost.
    void put(std::span<const std::uint8_t> bytes, Clock::time_point now);
    /// When the next one comes out; far away where none is on its way.
    Clock::time_point due() const;
    /// Hands all that come out by now, the earliest first, to `out`, which may put in more.
    void deliver(Clock::time_point now, const std::function<void(std::span<const std::uint8_t>)>& out);

    static constexpr std::size_t kSlots = 256;
    static constexpr std::size_t kMost_bytes = 512;

private:
    struct Slot {
        bool used = false;
        Clock::time_point due;
        std::uint64_t number = 0;
        std::vector<std::uint8_t> bytes;
    };

    void keep(std::span<const std::uint8_t> bytes, Clock::time_point due);
    void damage(std::vector<std::uint8_t>& bytes);
    const Slot* earliest() const;

    FaultPlan plan_;
    Dice dice_;
    std::vector<Slot> slots_;
    std::vector<std::uint8_t> out_;
    std::uint64_t number_ = 0;
};

}  // namespace haptable
