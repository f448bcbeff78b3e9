// SPDX-License-Identifier: GPL-2.0-or-later
// A device with faults and its servo in one process and in simulated time, watched: what must never be felt.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "host/device/session.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {

/// What a watched session came to.
struct Watched {
    DeviceReport device;
    std::int64_t forces = 0;      ///< that the servo published
    std::int64_t felt_ticks = 0;  ///< with a force at the motors
    std::int64_t silences = 0;    ///< of the servo
    std::int64_t limited = 0;     ///< answers with a force that a limit holds down
    std::int64_t faulted = 0;     ///< answers of a servo with a fault that waits to be acknowledged
    std::string violation;        ///< of the first property that did not hold, with its tick; empty: all held
};

/// Pokes, drags and circles, and acknowledges what there is each second, for `seconds` of simulated time, watched at
/// each tick:
/// - no force, of the servo's or at the motors, is above the device's limit, or not a number;
/// - the servo's is zero in states that have none;
/// - it rises by no more than `rate_n` from answer to answer, where the tables have that limit;
/// - the motors give none when the state that it answers is 20 ms old;
/// - the servo says zero when it has had no state for 20 ms.
/// `each_tick` may be empty. Two runs with the same plan and seed are the same.
Watched run_faulty_session(const ServoScene& scene, const FaultPlan& plan, std::uint64_t seed, double seconds,
                           const std::function<void(std::int64_t tick)>& each_tick = {});

}  // namespace haptable::test
