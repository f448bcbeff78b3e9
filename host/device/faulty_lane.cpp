// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/faulty_lane.hpp"

#include <cmath>

namespace haptable {

namespace {

// Behind the message of the next tick, before that of the one after it.
constexpr double kReorder_s = 0.0015;

}  // namespace

FaultyLane::FaultyLane(const FaultPlan& plan, std::uint64_t seed) : plan_(plan), dice_(seed), slots_(kSlots) {
    for (Slot& slot : slots_) slot.bytes.reserve(kMost_bytes);
    out_.reserve(kMost_bytes);
}

void FaultyLane::put(std::span<const std::uint8_t> bytes, Clock::time_point now) {
    if (dice_.hits(plan_.drop) || bytes.size() > kMost_bytes) return;
    double late_s = plan_.delay_s + plan_.jitter_s * dice_.uniform();
    if (dice_.hits(plan_.reorder)) late_s += kReorder_s;
    keep(bytes, now + in_seconds(late_s));
    if (dice_.hits(plan_.twice)) keep(bytes, now + in_seconds(late_s + plan_.jitter_s * dice_.uniform()));
}

void FaultyLane::keep(std::span<const std::uint8_t> bytes, Clock::time_point due) {
    for (Slot& slot : slots_) {
        if (slot.used) continue;
        slot.used = true;
        slot.due = due;
        slot.number = number_++;
        slot.bytes.assign(bytes.begin(), bytes.end());
        if (dice_.hits(plan_.corrupt)) damage(slot.bytes);
        return;
    }
}

void FaultyLane::damage(std::vector<std::uint8_t>& bytes) {
    for (std::size_t bits = 1 + dice_.below(3); bits > 0 && !bytes.empty(); --bits)
        bytes[dice_.below(bytes.size())] ^= static_cast<std::uint8_t>(1U << dice_.below(8));
}

const FaultyLane::Slot* FaultyLane::earliest() const {
    const Slot* first = nullptr;
    for (const Slot& slot : slots_) {
        if (!slot.used) continue;
        const bool is_earlier =
            first == nullptr || slot.due < first->due || (slot.due == first->due && slot.number < first->number);
        if (is_earlier) first = &slot;
    }
    return first;
}

Clock::time_point FaultyLane::due() const {
    const Slot* first = earliest();
    return first != nullptr ? first->due : Clock::time_point::max();
}

void FaultyLane::deliver(Clock::time_point now, const std::function<void(std::span<const std::uint8_t>)>& out) {
    for (const Slot* first = earliest(); first != nullptr && first->due <= now; first = earliest()) {
        Slot& slot = slots_[static_cast<std::size_t>(first - slots_.data())];
        slot.used = false;
        out_.assign(slot.bytes.begin(), slot.bytes.end());
        out(out_);
    }
}

}  // namespace haptable
