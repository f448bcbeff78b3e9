// SPDX-License-Identifier: GPL-2.0-or-later
// silent? -> buttons -> step of one, or of two at once -> noted
#include "host/session/fingers.hpp"

#include <algorithm>

#include "host/link/clock.hpp"

namespace haptable {

Fingers::Fingers(const ServoScene& scene, const haptable_body* body) : scene_(scene), body_(scene, body) {
    if (scene.pair != nullptr) {
        haptable_pair_init(scene.pair, &pair_);
        require_whole_tables(scene, pair_);
    } else {
        haptable_init(&pair_.servo[0]);
        require_whole_tables(scene, pair_.servo[0]);
    }
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
    for (std::size_t finger = 0; finger < count(); ++finger)
        if (in[finger])
            begin(finger, *in[finger], now_us);
        else
            release(finger);
    step(in, now_us);
    step_us_ = to_us(Clock::now() - begun);
    report_[0].step.add(step_us_);
    note(in);
}

/// A gap in time drops the contact, whether or not anybody watched within it.
void Fingers::begin(std::size_t finger, const FingerInput& in, std::uint32_t now_us) {
    haptable_servo& servo = pair_.servo[finger];
    if (in.begins) release(finger);
    if (haptable_watch(&servo, now_us, &out_[finger]) != 0) report_[finger].note(in.at_m, out_[finger]);
    haptable_buttons(&servo, in.buttons);
}

void Fingers::step(const FingerInputs& in, std::uint32_t now_us) {
    if (in[0] && in[1]) {
        float at_m[kFingers][3];
        for (std::size_t finger = 0; finger < kFingers; ++finger)
            std::copy_n(in[finger]->at_m.begin(), 3, at_m[finger]);
        return body_.step(pair_, at_m, now_us, out_.data());
    }
    if (!in[0] && !in[1]) return;
    const std::size_t finger = in[0] ? 0 : 1;
    body_.step(pair_, static_cast<int>(finger), in[finger]->at_m.data(), now_us, out_[finger]);
}

void Fingers::note(const FingerInputs& in) {
    double given_j = 0.0;
    for (std::size_t finger = 0; finger < count(); ++finger) {
        if (in[finger]) report_[finger].note(in[finger]->at_m, out_[finger], body_.inside(in[finger]->at_m));
        given_j += report_[finger].energy.given_j();
    }
    most_given_j_ = std::max(most_given_j_, given_j);
}

bool Fingers::release(std::size_t finger) {
    haptable_servo& servo = pair_.servo[finger];
    const bool was_there = servo.state != HAPTABLE_SILENT;
    haptable_watch(&servo, servo.position_us + HAPTABLE_SILENCE_US, &out_[finger]);
    // The account begins anew: nothing is given over a silence.
    if (was_there) report_[finger].energy.add({}, out_[finger]);
    return was_there;
}

void Fingers::check(std::uint32_t bytes) {
    if (scene_.pair != nullptr)
        haptable_pair_check(scene_.pair, &pair_, bytes);
    else
        haptable_check(scene_.model, &pair_.servo[0], bytes);
}

ServoReport Fingers::report(std::size_t finger) const {
    ServoReport report = report_[finger];
    report.counters = pair_.servo[finger].counters;
    return report;
}

}  // namespace haptable
