// SPDX-License-Identifier: GPL-2.0-or-later
// What computes a session's ticks: the servo in this process, or a target at the other end of a line.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "host/link/clock.hpp"
#include "host/link/messages.hpp"
#include "host/session/energy.hpp"
#include "host/session/scene.hpp"

namespace haptable {

/// What a tick has of a finger.
struct FingerInput {
    std::array<float, 3> at_m{};
    std::uint32_t buttons = 0;
    bool begins = false;                                ///< what was before is forgotten
    std::array<float, 4> turn{1.0F, 0.0F, 0.0F, 0.0F};  ///< of a tool, w x y z: from its axes to the world's
};

/// What a tick gives of a tool beside the hand's output, whose contact is that of the point that presses most.
struct ToolOutput {
    std::array<float, 3> torque_n_m{};  ///< on the hand, about the handle
    std::array<float, 3> position_m{};  ///< of the handle, where the tool is drawn
    std::array<float, 4> turn{1.0F, 0.0F, 0.0F, 0.0F};
    std::vector<haptable_output> point;         ///< each point's contact, as a finger's
    std::vector<std::array<float, 3>> point_m;  ///< where each is
    double stored_j = 0.0;                      ///< by all points
};

/// By finger; none: it has no device, or that is silent.
using FingerInputs = std::array<std::optional<FingerInput>, kFingers>;
using FingerOutputs = std::array<haptable_output, kFingers>;

/// A tick that a session asks for.
struct TickRequest {
    FingerInputs in;
    std::uint32_t time_us = 0;                  ///< the firmware's wrapping clock
    std::array<bool, kFingers> is_overtaken{};  ///< an earlier tick's answer to the finger's device is given up
};

/// A scene's servo of one or two fingers and its body, wherever it runs: its last outputs, and what they came to.
class Stepper {
public:
    /// For the counters' lists: a name and its value.
    using Visit = std::function<void(const char* name, std::int64_t value)>;

    explicit Stepper(const ServoScene& scene);
    virtual ~Stepper() = default;
    Stepper(const Stepper&) = delete;
    Stepper& operator=(const Stepper&) = delete;

    /// Begins a tick. True: it is done; false: take() says when.
    virtual bool begin(const TickRequest& request) = 0;
    /// Takes what has come meanwhile. True: the tick under way is done.
    virtual bool take() { return false; }
    /// When a tick may begin, if need be by overtaking the one under way.
    virtual Clock::time_point free_at(bool is_lockstep) const;
    /// As after silence: no contact, no force.
    virtual void release(std::size_t finger) = 0;
    /// Work between two ticks.
    virtual void idle() {}
    /// When watch has work again.
    virtual Clock::time_point watch_at() const { return Clock::time_point::max(); }
    virtual void watch(Clock::time_point /*now*/) {}
    /// Where the body was in the last tick, whose contact is in its frame. Null where it is held.
    virtual const haptable_body_state* touched() const = 0;
    /// The modes at the end of the last tick. Null where there are none.
    virtual const haptable_modes_state* modes() const = 0;
    /// The tool in the last tick. Null where a scene has none.
    virtual const ToolOutput* tool() const { return nullptr; }
    /// Its own counters.
    virtual void count(std::size_t finger, const Visit& visit) const = 0;

    const ServoScene& scene() const { return scene_; }
    std::size_t finger_count() const { return fingers_of(scene_); }
    /// None of these was there before.
    bool is_first_tick(const FingerInputs& in) const;
    const haptable_output& output(std::size_t finger) const { return out_[finger]; }
    const FingerOutputs& outputs() const { return out_; }
    const ForceReport& forces(std::size_t finger) const { return forces_[finger]; }
    /// Energy given to the hands together, the largest so far, J.
    double most_given_j() const { return most_given_j_; }
    /// The last tick's duration.
    double tick_us() const { return tick_us_; }

protected:
    /// Adds the last tick's outputs to what the forces came to.
    void note(const FingerInputs& in);
    /// Nothing is given over a silence.
    void end_account(std::size_t finger) { forces_[finger].energy.add({}, out_[finger]); }

    ServoScene scene_;
    FingerOutputs out_{};
    double tick_us_ = 0.0;

private:
    std::array<ForceReport, kFingers> forces_;
    double most_given_j_ = 0.0;
};

/// The output of a finger that is not there.
haptable_output silent_output();

/// Numbers the ticks of two fingers, whose states are numbered each by its own device.
class TickNumbers {
public:
    /// is_first: no finger was there before this tick. A gap of silence tells so to who reads the numbers.
    std::int64_t next(bool is_first) {
        number_ += is_first && number_ >= 0 ? 1 + HAPTABLE_SILENCE_US / HAPTABLE_TICK_US : 1;
        return number_;
    }

private:
    std::int64_t number_ = -1;
};

}  // namespace haptable
