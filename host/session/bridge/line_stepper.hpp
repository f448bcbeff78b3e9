// SPDX-License-Identifier: GPL-2.0-or-later
// A tick out as a frame, its answer in as another: a target as the servo of a session.
#pragma once

#include "host/link/statistics.hpp"
#include "host/session/bridge/target.hpp"
#include "host/session/bridge/target_tool.hpp"
#include "host/session/counted.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

struct LineOptions {
    std::chrono::microseconds retry{50'000};  ///< a state without an answer is sent again after this
    std::chrono::microseconds hold{2000};     ///< so long at least no newer state overtakes one in real time
    double patience_s = 10.0;                 ///< without any answer for so long, the target is gone
};

/// Before the first tick the target says what it is. In lockstep a tick of two fingers does not overtake one that a
/// device waits for; in real time none overtakes one whose answer may still come, so that a slow target has no backlog:
/// it gets the newest states.
class LineStepper final : public Stepper {
public:
    LineStepper(SerialTarget& target, const LineOptions& options);

    bool begin(const TickRequest& request) override;
    /// Throws Error when the target runs another scene, or speaks another version.
    bool take() override;
    Clock::time_point free_at(bool is_lockstep) const override;
    /// The target sees that the finger is not in the next tick, or the gap in time.
    void release(std::size_t finger) override;
    Clock::time_point watch_at() const override;
    /// Asks again for an answer that has not come. Throws Error when the target has not answered for patience_s.
    void watch(Clock::time_point now) override;
    const haptable_body_state* touched() const override { return scene_.body != nullptr ? &pose_ : nullptr; }
    const haptable_modes_state* modes() const override { return scene_.modes != nullptr ? &modes_ : nullptr; }
    const ToolOutput* tool() const override { return tool_ ? &tool_->output() : nullptr; }
    /// Those of another finger are a few: the line's own are the first's.
    void count(std::size_t finger, const Visit& visit) const override;

    LineCounters counters(std::size_t finger = 0) const;
    /// From a tick's first frame to its answer.
    const DurationStatistics& round_trip() const { return round_trip_; }

private:
    std::uint32_t time_for_target(std::uint32_t time_us);
    void make_frame(std::uint32_t time_us);
    void send();
    bool take(const TargetHello& hello);
    bool take(const TargetAnswer& answer);
    bool is_possible(const haptable_output& output) const;
    bool is_possible(const TargetAnswer& answer) const;
    bool is_possible(const haptable_tool_line_answer& answer, double ticks) const;
    bool is_possible(const haptable_line_point& point) const;
    static bool rises_within(double most_n, const float force_n[3], const float before_n[3]);
    static bool is_possible(const haptable_body_state& body);
    static bool is_turn(const float turn[4]);
    static bool is_within_a_patch(const float alpha[3]);
    bool is_on_a_patch(const haptable_output& output) const;

    SerialTarget& target_;
    LineOptions options_;
    haptable_body_state pose_{};                ///< of the last tick, as the line has it
    haptable_modes_state modes_{};              ///< likewise
    FingerInputs in_;                           ///< the tick under way, or the last one
    std::optional<TargetTool> tool_;            ///< likewise; none where the scene has none
    TargetState frame_;                         ///< as the target gets it
    std::uint32_t sent_us_ = 0;                 ///< its time, for the target
    std::uint32_t clock_us_ = 0;                ///< from a session's time to the target's
    std::uint32_t number_ = 0;                  ///< of its frames; counts on over sessions of devices
    std::uint32_t answered_ = 0;                ///< the last one that was published
    bool waiting_ = false;                      ///< for its answer
    Clock::duration hold_;                      ///< so long no newer state overtakes it in real time
    Clock::time_point first_sent_, last_sent_;  ///< its frames
    Clock::time_point deaf_since_;              ///< the first state that was not answered since the last answer
    bool is_known_ = false;                     ///< the target has said what it is
    std::array<LineCounters, kFingers> counters_;
    DurationStatistics round_trip_;
};

}  // namespace haptable
