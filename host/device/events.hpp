// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo's answers tell a user: one line when something begins, not one for every tick of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "host/link/messages.hpp"

namespace haptable {

class Events {
public:
    /// What begins with this answer, if anything does. The same is told again after a second of ticks at the earliest.
    std::optional<std::string> note(const servo_force& force) {
        const int before = std::exchange(state_, int{force.servo_state});
        const std::int32_t faults = std::exchange(faults_, force.faults);
        if (force.servo_state == servo_force::FAULTED && (before != servo_force::FAULTED || faults != force.faults))
            return "the servo stands still: " + reasons(force.faults) + "; press acknowledge (button 2)";
        if (before == force.servo_state) return std::nullopt;
        if (force.servo_state == servo_force::REJECTED && is_due(force.seq, rejected_))
            return "the servo does not believe a position: no force until 20 good ones have come";
        if (force.servo_state == servo_force::LIMITED && is_due(force.seq, limited_))
            return "the servo limits the force";
        return std::nullopt;
    }

private:
    static constexpr std::int64_t kAgain_ticks = 1000;

    static bool is_due(std::int64_t seq, std::int64_t& told) {
        if (seq - told < kAgain_ticks) return false;
        told = seq;
        return true;
    }
    static std::string reasons(std::int32_t faults) {
        std::string text;
        const auto add = [&text](const char* what) { text += (text.empty() ? "" : ", ") + std::string(what); };
        if ((faults & 1) != 0) add("its tables are damaged, or were not checked");
        if ((faults & 2) != 0) add("a force was not a number");
        if ((faults & 4) != 0) add("positions jump again and again");
        return text.empty() ? "a fault" : text;
    }

    int state_ = servo_force::SILENT;
    std::int32_t faults_ = 0;
    std::int64_t rejected_ = -kAgain_ticks, limited_ = -kAgain_ticks;
};

}  // namespace haptable
