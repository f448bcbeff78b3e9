// SPDX-License-Identifier: GPL-2.0-or-later
// The servo of a scene's one or two fingers, and its body, in this process.
#pragma once

#include <cstdint>

#include "host/link/statistics.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

/// What happened to a finger in a run, by replay or over LCM.
struct ServoReport : ForceReport {
    haptable_counters counters{};
    DurationStatistics step;  ///< of a tick's step alone; of two fingers with the first
};

class LocalStepper final : public Stepper {
public:
    /// Checks the tables: throws Error where they are damaged.
    explicit LocalStepper(const ServoScene& scene);

    /// One tick of those that are there; the others are released.
    void tick(const FingerInputs& in, std::uint32_t now_us);
    const haptable_servo& servo(std::size_t finger) const { return state_.servo(finger); }
    const SceneState& state() const { return state_; }
    ServoReport report(std::size_t finger = 0) const;

    bool begin(const TickRequest& request) override;
    void release(std::size_t finger) override;
    /// Goes on with the check of the tables.
    void idle() override;
    const haptable_body_state* touched() const override { return state_.touched(); }
    const haptable_modes_state* modes() const override { return state_.modes(); }
    const ToolOutput* tool() const override { return tool_ ? &*tool_ : nullptr; }
    void count(std::size_t finger, const Visit& visit) const override;

private:
    void step(const haptable_input in[], const FingerInputs& fingers, std::uint32_t now_us);
    void take_tool(const haptable_tool_output& out);

    SceneState state_;
    std::optional<ToolOutput> tool_;  ///< none where the scene has none
    DurationStatistics step_;
};

}  // namespace haptable
