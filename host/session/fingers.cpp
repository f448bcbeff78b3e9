// SPDX-License-Identifier: GPL-2.0-or-later
// silent? -> buttons -> step of one, or of two at once -> noted
#include "host/session/fingers.hpp"

#include <algorithm>

#include "host/link/clock.hpp"

namespace haptable {

Fingers::Fingers(const ServoScene& scene) : state_(state_of(scene)) {
    require_whole_tables(scene, state_);
    for (std::size_t finger = 0; finger < count(); ++finger) {
        out_[finger].patch = HAPTABLE_NONE;
        std::fill_n(out_[finger].vertex, 3, HAPTABLE_NONE);
    }
}

bool Fingers::is_anew(const FingerInputs& in) const {
    for (std::size_t finger = 0; finger < count(); ++finger)
        if (in[finger] && !in[finger]->begins && servo(finger).state != HAPTABLE_SILENT) return false;
    return true;
}

void Fingers::tick(const FingerInputs& in, std::uint32_t now_us) {
    const Clock::time_point begun = Clock::now();
    haptable_input to[kFingers]{};
    for (std::size_t finger = 0; finger < count(); ++finger) {
        // An account of what was given ends with what was before: a silence, seen or not.
        const bool is_late = now_us - servo(finger).position_us >= HAPTABLE_SILENCE_US;
        if (!in[finger] || in[finger]->begins || is_late) release(finger);
        if (!in[finger]) continue;
        to[finger].is_there = 1;
        to[finger].buttons = in[finger]->buttons;
        std::copy_n(in[finger]->at_m.begin(), 3, to[finger].finger_m);
    }
    state_.step(to, now_us, out_.data());
    step_us_ = to_us(Clock::now() - begun);
    report_[0].step.add(step_us_);
    note(in);
}

void Fingers::note(const FingerInputs& in) {
    double given_j = 0.0;
    for (std::size_t finger = 0; finger < count(); ++finger) {
        if (in[finger]) report_[finger].note(in[finger]->at_m, out_[finger], state_.inside(in[finger]->at_m));
        given_j += report_[finger].energy.given_j();
    }
    most_given_j_ = std::max(most_given_j_, given_j);
}

bool Fingers::release(std::size_t finger) {
    haptable_servo& servo = state_.servo(finger);
    const bool was_there = servo.state != HAPTABLE_SILENT;
    haptable_servo_watch(&servo, servo.position_us + HAPTABLE_SILENCE_US, &out_[finger]);
    // The account begins anew: nothing is given over a silence.
    if (was_there) report_[finger].energy.add({}, out_[finger]);
    return was_there;
}

void Fingers::check(std::uint32_t bytes) { state_.check(bytes); }

ServoReport Fingers::report(std::size_t finger) const {
    ServoReport report = report_[finger];
    report.counters = servo(finger).counters;
    return report;
}

}  // namespace haptable
