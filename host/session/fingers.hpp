// SPDX-License-Identifier: GPL-2.0-or-later
// The servo of a scene's one or two fingers, and its body: what a tick does, whoever asks for it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/session/energy.hpp"
#include "host/session/scene.hpp"

namespace haptable {

/// What happened to a finger in a run, by replay or over LCM.
struct ServoReport : ForceReport {
    haptable_counters counters{};
    DurationStatistics step;  ///< of a tick's step alone; of two fingers with the first
};

/// What a tick has of a finger.
struct FingerInput {
    std::array<float, 3> at_m{};
    std::uint32_t buttons = 0;
    bool begins = false;  ///< what was before is forgotten
};

/// By finger; none: it has no device, or that is silent.
using FingerInputs = std::array<std::optional<FingerInput>, kFingers>;

class Fingers {
public:
    /// Checks the tables: throws Error where they are damaged.
    explicit Fingers(const ServoScene& scene);

    /// Of the scene: 1 or 2.
    std::size_t count() const { return state_.fingers(); }
    /// None of these was there before.
    bool is_anew(const FingerInputs& in) const;
    /// One tick of those that are there; the others are released.
    void tick(const FingerInputs& in, std::uint32_t now_us);
    /// As after silence: no contact, no force. False where it was so before.
    bool release(std::size_t finger);
    /// Goes on with the check of the tables.
    void check(std::uint32_t bytes);

    const haptable_output& output(std::size_t finger) const { return out_[finger]; }
    const haptable_servo& servo(std::size_t finger) const { return state_.servo(finger); }
    const SceneState& state() const { return state_; }
    ServoReport report(std::size_t finger) const;
    /// The last tick's step.
    double step_us() const { return step_us_; }
    /// Energy given to the hands together, the largest so far, J.
    double most_given_j() const { return most_given_j_; }

private:
    void note(const FingerInputs& in);

    SceneState state_;
    std::array<haptable_output, kFingers> out_{};
    std::array<ServoReport, kFingers> report_;
    double step_us_ = 0.0, most_given_j_ = 0.0;
};

/// Numbers the ticks of two fingers, whose states are numbered each by its own device.
class TickNumbers {
public:
    /// anew: no finger was there before this tick. A gap of silence tells so to who reads the numbers.
    std::int64_t next(bool anew) {
        number_ += anew && number_ >= 0 ? 1 + HAPTABLE_SILENCE_US / HAPTABLE_TICK_US : 1;
        return number_;
    }

private:
    std::int64_t number_ = -1;
};

}  // namespace haptable
