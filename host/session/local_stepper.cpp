// SPDX-License-Identifier: GPL-2.0-or-later
// silent? -> buttons -> step of one, or of two at once -> noted
#include "host/session/local_stepper.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace haptable {

namespace {

static_assert(kTick == std::chrono::microseconds(HAPTABLE_TICK_US));
static_assert(kFingers == HAPTABLE_HANDS);

}  // namespace

LocalStepper::LocalStepper(const ServoScene& scene) : Stepper(scene), state_(state_of(scene)) {
    require_whole_tables(scene, state_);
    if (state_.tool() == nullptr) return;
    tool_.emplace();
    release(0);
}

/// The tool's output besides the hand's.
void LocalStepper::take_tool(const haptable_tool_output& out) {
    out_[0] = out.hand;
    std::copy_n(out.torque_n_m, 3, tool_->torque_n_m.begin());
    std::copy_n(out.position_m, 3, tool_->position_m.begin());
    std::copy_n(out.turn, 4, tool_->turn.begin());
    tool_->stored_j = state_.tool_energy_j();
    tool_->point.resize(state_.tool()->points.count);
    tool_->point_m.resize(tool_->point.size());
    const Eigen::Quaternionf turn(out.turn[0], out.turn[1], out.turn[2], out.turn[3]);
    for (std::size_t i = 0; i < tool_->point.size(); ++i) {
        tool_->point[i] = state_.point(i);
        Eigen::Map<Eigen::Vector3f>(tool_->point_m[i].data()) =
            Eigen::Vector3f(out.position_m) + turn * Eigen::Vector3f(state_.tool()->point_m[i]);
    }
}

void LocalStepper::step(const haptable_input in[], const FingerInputs& fingers, std::uint32_t now_us) {
    if (!tool_) return state_.step(in, now_us, out_.data());
    haptable_tool_input tool{in[0], {1.0F, 0.0F, 0.0F, 0.0F}};
    if (fingers[0]) std::copy_n(fingers[0]->turn.begin(), 4, tool.turn);
    haptable_tool_output out{};
    state_.step(tool, now_us, out);
    take_tool(out);
}

void LocalStepper::tick(const FingerInputs& in, std::uint32_t now_us) {
    const Clock::time_point begun = Clock::now();
    haptable_input to[kFingers]{};
    for (std::size_t finger = 0; finger < finger_count(); ++finger) {
        // An account of what was given ends with what was before: a silence, seen or not.
        const bool is_late = now_us - servo(finger).position_us >= HAPTABLE_SILENCE_US;
        if (!in[finger] || in[finger]->begins || is_late) release(finger);
        if (!in[finger]) continue;
        to[finger].is_there = 1;
        to[finger].buttons = in[finger]->buttons;
        std::copy_n(in[finger]->at_m.begin(), 3, to[finger].finger_m);
    }
    step(to, in, now_us);
    tick_us_ = to_us(Clock::now() - begun);
    step_.add(tick_us_);
    note(in);
}

bool LocalStepper::begin(const TickRequest& request) {
    tick(request.in, request.time_us);
    return true;
}

void LocalStepper::release(std::size_t finger) {
    haptable_servo& servo = state_.servo(finger);
    const bool was_there = servo.state != HAPTABLE_SILENT;
    if (tool_) {
        haptable_tool_output out{};
        state_.release(servo.position_us + HAPTABLE_SILENCE_US, out);
        take_tool(out);
    } else {
        haptable_servo_watch(&servo, servo.position_us + HAPTABLE_SILENCE_US, &out_[finger]);
    }
    if (was_there) end_account(finger);
}

// A part of the tables after each answer: the cube's are gone through in half a second, and no tick is felt as longer.
void LocalStepper::idle() { state_.check(HAPTABLE_CHECK_BYTES); }

void LocalStepper::count(std::size_t finger, const Visit& visit) const {
#define HAPTABLE_VISIT(name) visit(#name, servo(finger).counters.name);
    HAPTABLE_COUNTERS(HAPTABLE_VISIT)
#undef HAPTABLE_VISIT
}

ServoReport LocalStepper::report(std::size_t finger) const {
    ServoReport report{forces(finger), servo(finger).counters, {}};
    if (finger == 0) report.step = step_;
    return report;
}

}  // namespace haptable
