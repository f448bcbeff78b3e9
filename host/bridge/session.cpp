// SPDX-License-Identifier: GPL-2.0-or-later
// state -> the other finger's, too? -> frame -> target -> frame -> checked -> forces published -> contacts published ->
// counted and recorded
#include "host/bridge/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.hpp"
#include "host/session/pose_message.hpp"
#include "host/session/status.hpp"
#include "host/session/tell.hpp"

namespace haptable {

namespace {

// How much longer than options.hold a target is waited for its answers tell.
constexpr Clock::duration kMostHold = std::chrono::microseconds(HAPTABLE_SILENCE_US);
constexpr int kHoldTicks = 16;  // to forget a slow one
constexpr double kRateRounding = 1.001;

Clock::duration seconds(double s) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

haptable_output silent() {
    haptable_output output{};
    output.patch = HAPTABLE_NONE;
    std::fill_n(output.vertex, 3, HAPTABLE_NONE);
    return output;
}

bool is_same_scene(const TargetHello& a, const TargetHello& b) {
    return a.fingers == b.fingers && a.modes == b.modes &&
           (a.flags & HAPTABLE_LINE_FREE) == (b.flags & HAPTABLE_LINE_FREE);
}

std::string in_words(const TargetHello& of) {
    return fmt::format("{} of {} with {} modes", of.fingers == 1 ? "one finger" : fmt::format("{} fingers", of.fingers),
                       (of.flags & HAPTABLE_LINE_FREE) != 0 ? "a body that nothing holds" : "a body that is held",
                       of.modes);
}

}  // namespace

BridgeSession::BridgeSession(const ServoScene& scene, Connection& connection, SerialTarget& target,
                             const BridgeOptions& options, ServoRecord* record, LiveState::Tell tell)
    : scene_(scene),
      connection_(connection),
      target_(target),
      options_(options),
      record_(record),
      answer_(scene, connection),
      hold_(options.hold),
      live_(std::move(tell)) {
    if (scene.body != nullptr) haptable_body_init(scene.body, &pose_);
    const std::size_t count = scene.pair != nullptr ? kFingers : 1;
    for (std::size_t finger = 0; finger < count; ++finger) {
        side_.emplace_back(StateGate(answer_.servo(), answer_.model_hash()));
        side_.back().output = silent();
    }
    for (std::size_t finger = 0; finger < kFingers; ++finger) subscribe(finger);
    connection.after_all([this] { ask_if_ready(); });
}

void BridgeSession::subscribe(std::size_t finger) {
    connection_.subscribe<device_state>(channel_of<device_state>(finger),
                                        [this, finger](const device_state& state, std::int64_t received_utime) {
                                            if (finger < side_.size()) return on_state(finger, state, received_utime);
                                            side_[0].gate.count_absent_finger();
                                        });
}

// ---- device -> target ----------------------------------------------------------------------------------------------

void BridgeSession::on_state(std::size_t finger, const device_state& state, std::int64_t received_utime) {
    Side& side = side_[finger];
    const bool waited = side.waits;
    const Clock::time_point now = Clock::now();
    if (is_of_other_time(finger, state)) return side.gate.count_odd();
    switch (side.gate.judge(state, received_utime, now)) {
        case StateIs::refused:
            return;
        case StateIs::others:
            return answer_.refuse(state, side.gate.state().session, finger);
        case StateIs::repeated:
            // The device did not get our answer: the same again, as soon as there is one.
            if (!side.is_asked && !side.waits)
                answer_.publish_force(side.state, side.output, side.answered_utime, finger);
            return ask_if_ready();
        case StateIs::beginning:
            side.begins = true;
            side.clock_us = 0;
            // A clock of its own: it goes on from where the other finger's is.
            for (std::size_t other = 0; other < side_.size(); ++other)
                if (other != finger && is_there(other, now)) side.clock_us = tick_utime_ - state.utime;
            break;
        case StateIs::next:
            break;
    }
    if (waited) side.gate.count_skipped();
    if (!waited) side.waits_since = now;
    side.waits = true;
    side.is_late = false;
    if (is_simulated(state)) ask_if_ready();
}

/// One finger in lockstep and the other in real time have no tick in common.
bool BridgeSession::is_of_other_time(std::size_t finger, const device_state& state) const {
    const Clock::time_point now = Clock::now();
    for (std::size_t other = 0; other < side_.size(); ++other)
        if (other != finger && is_there(other, now) && state.mode != side_[other].gate.state().mode) return true;
    return false;
}

bool BridgeSession::is_there(std::size_t finger, Clock::time_point now) const {
    return side_[finger].waits || side_[finger].gate.is_owned(now);
}

/// As ServoSession's. In lockstep a tick of two fingers does not overtake one that a device waits for; in real time
/// none overtakes one whose answer may still come, so that a slow target has no backlog: it gets the newest states.
bool BridgeSession::is_ready(Clock::time_point now) const {
    bool waits = false, is_missing = false, has_waited = false, is_lockstep = false;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        waits |= side.waits;
        is_missing |= is_there(finger, now) && !side.waits && !side.is_late;
        if (!side.waits) continue;
        is_lockstep |= is_simulated(side.gate.state());
        has_waited |= side.begins || (!is_simulated(side.gate.state()) && now - side.waits_since >= kTick);
    }
    if (waiting_ && (is_lockstep ? side_.size() > 1 : now < first_sent_ + hold_)) return false;
    return has_waited || (waits && !is_missing);
}

void BridgeSession::ask_if_ready() {
    const Clock::time_point now = Clock::now();
    if (is_ready(now)) ask(now);
}

void BridgeSession::ask(Clock::time_point now) {
    if (!waiting_) deaf_since_ = now;
    take_states(now);
    make_frame(time_of_tick(now));
    end_asking();
    waiting_ = true;
    ++number_;
    first_sent_ = now;
    send();
}

/// The tick: states that wait, and where a finger is whose state did not come.
void BridgeSession::take_states(Clock::time_point now) {
    bool is_anew = true;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        const bool there = is_there(finger, now);
        if (side.waits) {
            if (side.is_asked) ++side.report.lost_answers;
            side.state = side.gate.state();
            side.is_asked = true;
        }
        side.is_asked &= there;
        in_[finger].reset();
        if (!there) continue;
        in_[finger] = FingerInput{to_finger(side.state.position_m), buttons_of(side.state), side.waits && side.begins};
        is_anew &= in_[finger]->begins || side.output.state == HAPTABLE_SILENT;
    }
    tick_number_ = numbers_.next(is_anew);
}

/// Of the first finger whose state waits; after a gap where all that are there begin: the target knows no sessions.
std::uint32_t BridgeSession::time_of_tick(Clock::time_point now) {
    const Side& lead = *std::find_if(side_.begin(), side_.end(), [](const Side& side) { return side.waits; });
    if (is_simulated(lead.state)) set_time(lead.state.utime + lead.clock_us);
    const std::uint32_t time_us =
        is_simulated(lead.state) ? static_cast<std::uint32_t>(tick_utime_) : to_firmware_us(now);
    const bool all_begin = std::all_of(in_.begin(), in_.end(), [](const auto& in) { return !in || in->begins; });
    if (all_begin && number_ > 0) clock_us_ = sent_us_ + HAPTABLE_SILENCE_US - time_us;
    return time_us + clock_us_;
}

/// Answers of two fingers with one time are one tick, so that no other has it.
void BridgeSession::set_time(std::int64_t utime) {
    tick_utime_ = side_.size() == 2 && utime == tick_utime_ ? utime + 1 : utime;
}

/// Who begins beside one that goes on says so by a bit: a gap in time would end the other's contact, too.
void BridgeSession::make_frame(std::uint32_t time_us) {
    const bool goes_on = std::any_of(in_.begin(), in_.end(), [](const auto& in) { return in && !in->begins; });
    sent_us_ = time_us;
    frame_ = {};
    frame_.time_us = time_us;
    for (std::size_t finger = 0; finger < kFingers; ++finger) {
        if (!in_[finger]) continue;
        haptable_input& to = frame_.in[finger];
        to.is_there = 1;
        std::copy(in_[finger]->at_m.begin(), in_[finger]->at_m.end(), to.finger_m);
        to.buttons = in_[finger]->buttons;
        if (goes_on && in_[finger]->begins) frame_.begins |= static_cast<std::uint8_t>(1U << finger);
    }
}

void BridgeSession::end_asking() {
    const bool joins = std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.begins; });
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (!side.waits && !joins) side.is_late = in_[finger].has_value();
    }
    for (Side& side : side_) side.waits = side.begins = false;
}

void BridgeSession::send() {
    last_sent_ = Clock::now();
    if (!is_known_) return target_.ask();
    target_.send(number_, frame_);
}

// ---- target -> device ----------------------------------------------------------------------------------------------

void BridgeSession::take_answers() {
    while (const auto frame = target_.take()) std::visit([this](const auto& said) { take(said); }, *frame);
}

/// It comes when it is asked for, and when the target begins anew.
void BridgeSession::take(const TargetHello& hello) {
    const TargetHello& own = target_.expected();
    const std::string& line = target_.line().name();
    if (hello.version != own.version)
        throw Error(fmt::format(
            "{}: the target speaks version {} of the line, this program version {}: build and flash it again", line,
            hello.version, own.version));
    if (hello.hash != own.hash)
        throw Error(
            fmt::format("{}: the target runs the tables {:016x}, the folder's are {:016x}: build and flash it again",
                        line, hello.hash, own.hash));
    if (!is_same_scene(hello, own))
        throw Error(fmt::format("{}: the target knows {}, the folder's scene has {}: build and flash it again", line,
                                in_words(hello), in_words(own)));
    // A target that heard another version once has heard ours since: this is its answer to it, or one to come.
    if (std::exchange(is_known_, true) || !waiting_) return;
    send();
}

void BridgeSession::take(const TargetAnswer& answer) {
    if (!waiting_ || answer.sequence != number_) {
        ++side_[0].report.stale_answers;
        hold_ = std::min(2 * hold_, kMostHold);
        return;
    }
    if (!is_possible(answer)) {
        ++side_[0].report.rejected_forces;
        return;
    }
    finish(answer);
}

void BridgeSession::finish(const TargetAnswer& answer) {
    waiting_ = false;
    answered_ = answer.sequence;
    const Clock::duration takes = std::min(2 * (Clock::now() - first_sent_), kMostHold);
    hold_ += (std::max<Clock::duration>(takes, options_.hold) - hold_) / kHoldTicks;
    for (std::size_t finger = 0; finger < side_.size(); ++finger)
        side_[finger].output = in_[finger] ? answer.output[finger] : silent();
    pose_ = answer.body;
    modes_ = answer.modes;
    publish_forces();
    publish_motion();
    note(Clock::now());
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (std::exchange(side.is_asked, false)) answer_.publish_contact(side.state, side.output, finger);
    }
    record();
    ask_if_ready();
}

void BridgeSession::publish_forces() {
    bool is_real = false;
    for (const Side& side : side_) is_real |= side.is_asked && !is_simulated(side.state);
    if (is_real) set_time(utime_now());
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        Side& side = side_[finger];
        if (!side.is_asked) continue;
        answer_.publish_force(side.state, side.output, tick_utime_, finger);
        side.answered_utime = tick_utime_;
    }
}

/// For the first finger that is answered.
void BridgeSession::publish_motion() {
    const auto lead = std::find_if(side_.begin(), side_.end(), [](const Side& side) { return side.is_asked; });
    if (lead == side_.end()) return;
    const auto of = [&](auto message) {
        return addressed(message, lead->state, tick_utime_, answer_.servo(), *scene_.model);
    };
    if (scene_.body != nullptr) connection_.publish(channel_of<body_pose>(), of(to_pose_message(*scene_.body, pose_)));
    if (scene_.modes != nullptr)
        connection_.publish(channel_of<body_modes>(), of(to_modes_message(*scene_.modes, modes_)));
}

/// A world position in the frame of the last tick.
std::array<float, 3> BridgeSession::inside(const std::array<float, 3>& world_m) const {
    std::array<float, 3> inside_m = world_m;
    if (scene_.body != nullptr) haptable_body_from_world(scene_.body, &pose_, world_m.data(), inside_m.data());
    return inside_m;
}

void BridgeSession::record() {
    if (record_ == nullptr) return;
    if (side_.size() == 1)
        return record_->add(side_[0].state.seq, in_[0]->at_m, in_[0]->buttons, side_[0].output, pose(), modes());
    record_->add(tick_number_, in_, {side_[0].output, side_[1].output}, pose(), modes());
}

/// What reaches the device is what a servo of these tables can have said, whatever the frame's CRC: a state that there
/// is, numbers, no more than the device's limit, none without contact (but what a release lets fade), nodes that exist.
bool BridgeSession::is_possible(const haptable_output& output) const {
    const haptable_model& model = *scene_.model;
    const auto finite = [](const float v[3]) {
        return std::all_of(v, v + 3, [](float x) { return std::isfinite(x); });
    };
    if (output.state > HAPTABLE_FAULTED || !finite(output.force_n) || !finite(output.god_object_m)) return false;
    if (!std::all_of(output.nodal_force_n, output.nodal_force_n + 3, finite)) return false;
    const double size_n = std::hypot(output.force_n[0], output.force_n[1], output.force_n[2]);
    if (size_n > 1.001 * double(model.max_force_n)) return false;
    if (haptable_touches(output.state) != 0) return is_on_a_patch(output);
    if (output.state == HAPTABLE_FREE && output.vertex[0] != HAPTABLE_NONE && !is_on_a_patch(output)) return false;
    const bool fades = output.state == HAPTABLE_FREE && (model.release != nullptr || model.passivity != nullptr);
    return fades || size_n <= 0.0;
}

/// Within so many newtons of what lies between none and the last force given, as haptable_limit_rate keeps it.
bool BridgeSession::rises_within(double most_n, const float force_n[3], const float before_n[3]) {
    double along = 0.0, before2 = 0.0, rise2 = 0.0;
    for (int a = 0; a < 3; ++a) {
        along += double{force_n[a]} * double{before_n[a]};
        before2 += double{before_n[a]} * double{before_n[a]};
    }
    const double share = before2 > 0.0 ? std::clamp(along / before2, 0.0, 1.0) : 0.0;
    for (int a = 0; a < 3; ++a) rise2 += std::pow(double{force_n[a]} - share * double{before_n[a]}, 2);
    return rise2 <= most_n * most_n;
}

/// The target has stepped once for each number since the last answer that was published.
bool BridgeSession::is_possible(const TargetAnswer& answer) const {
    const haptable_model& model = *scene_.model;
    const double ticks = answer.sequence - answered_;
    const double most_n = kRateRounding * ticks * double{model.rate_n} + 1e-6 * double{model.max_force_n};
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        if (!in_[finger]) continue;
        if (!is_possible(answer.output[finger])) return false;
        const float* before_n = side_[finger].output.force_n;
        if (model.rate != nullptr && !rises_within(most_n, answer.output[finger].force_n, before_n)) return false;
    }
    return (scene_.body == nullptr || is_possible(answer.body)) &&
           std::all_of(answer.modes.q, answer.modes.q + HAPTABLE_MODES, [](float q) { return std::isfinite(q); });
}

/// Finite, and a turn.
bool BridgeSession::is_possible(const haptable_body_state& body) {
    constexpr float kRounding = 1e-4F;
    float length2 = 0.0F;
    for (const float w : body.turn) length2 += w * w;
    const auto finite = [](const float v[3]) {
        return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
    };
    return finite(body.position_m) && finite(body.velocity_m_per_s) && finite(body.spin_rad_per_s) &&
           std::abs(length2 - 1.0F) <= kRounding;
}

/// Its corners are vertices, and the god-object lies between them.
bool BridgeSession::is_on_a_patch(const haptable_output& output) const {
    constexpr float kRounding = 1e-4F;  // of area coordinates, which sum to 1
    float sum = 0.0F;
    for (std::size_t c = 0; c < 3; ++c) {
        if (output.vertex[c] >= scene_.model->vertex_count) return false;
        if (!(output.alpha[c] >= -kRounding && output.alpha[c] <= 1.0F + kRounding)) return false;
        sum += output.alpha[c];
    }
    return std::abs(sum - 1.0F) <= kRounding;
}

void BridgeSession::note(Clock::time_point now) {
    const double us = to_us(now - first_sent_);
    side_[0].report.round_trip.add(us);
    longest_us_ = std::max(longest_us_, us);
    double given_j = 0.0;
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        if (in_[finger]) note(finger);
        given_j += side_[finger].report.energy.given_j();
    }
    most_given_j_ = std::max(most_given_j_, given_j);
}

void BridgeSession::note(std::size_t finger) {
    Side& side = side_[finger];
    ++side.report.ticks;
    if (haptable_touches(side.output.state) != 0) ++side.report.contact_ticks;
    side.report.note(in_[finger]->at_m, side.output, inside(in_[finger]->at_m));
    if (side.output.state != HAPTABLE_REJECTED) return;
    ++side.rejected;
    side.rejected_m = in_[finger]->at_m;
}

// ---- neither ------------------------------------------------------------------------------------------------------

/// When a finger falls silent. In lockstep time stands still, but a device that is gone does not hold up the other's.
Clock::time_point BridgeSession::silent_at(std::size_t finger) const {
    const Side& side = side_[finger];
    if (!side.gate.has_states() || side.output.state == HAPTABLE_SILENT) return Clock::time_point::max();
    if (!is_simulated(side.gate.state()))
        return side.gate.last_state() + std::chrono::microseconds(HAPTABLE_SILENCE_US);
    const bool other_waits = std::any_of(side_.begin(), side_.end(), [](const Side& any) { return any.waits; });
    return other_waits && !side.waits ? side.gate.owned_until() : Clock::time_point::max();
}

Clock::time_point BridgeSession::watch_at() const {
    Clock::time_point at = waiting_ ? last_sent_ + options_.retry : Clock::time_point::max();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) {
        const Side& side = side_[finger];
        at = std::min(at, silent_at(finger));
        if (!side.waits || is_simulated(side.gate.state())) continue;
        at =
            std::min(at, waiting_ ? std::max(side.waits_since + kTick, first_sent_ + hold_) : side.waits_since + kTick);
    }
    return at;
}

void BridgeSession::watch(Clock::time_point now) {
    if (now < watch_at()) return;
    if (waiting_ && now - deaf_since_ >= seconds(options_.patience_s))
        throw Error(
            fmt::format("{}: the target has not answered for {} s ({} bytes of garbage came): is it running, "
                        "of this version (make firmware), and is --baud its own?",
                        target_.line().name(), options_.patience_s, target_.skipped_bytes()));
    for (std::size_t finger = 0; finger < side_.size(); ++finger) watch(finger, now);
    if (is_ready(now)) return ask(now);
    if (!waiting_ || now < last_sent_ + options_.retry) return;
    ++side_[0].report.resent_frames;
    if (is_known_) target_.ask();  // it may have begun anew, with other tables
    send();
}

/// As the servo itself would: the target sees that it is not in the next tick, or the gap in time.
void BridgeSession::watch(std::size_t finger, Clock::time_point now) {
    Side& side = side_[finger];
    if (now < silent_at(finger)) return;
    if (haptable_touches(side.output.state) != 0)
        live_.say(who(finger) + contact_dropped_after(now - side.gate.last_state()));
    in_[finger].reset();
    side.is_asked = false;
    waiting_ = waiting_ && (in_[0] || in_[1]);
    side.output = silent();
    side.report.note(to_finger(side.state.position_m), side.output);
    const std::int64_t utime = is_simulated(side.state) ? tick_utime_ : utime_now();
    answer_.publish_force(side.state, side.output, utime, finger);
    answer_.publish_contact(side.state, side.output, finger);
    side.answered_utime = utime;
}

void BridgeSession::publish_status() {
    const Clock::time_point now = Clock::now();
    Status status(answer_, side_[0].gate.owner(now), side_[0].output, longest_us_);
    report().each(status);
    status.add(side_[0].report);
    if (side_.size() > 1) {
        const std::string suffix = kFingerSuffix[1];
        status("session" + suffix, side_[1].gate.owner(now));
        status("servo_state" + suffix, side_[1].output.state);
        status("faults" + suffix, side_[1].output.faults);
        report(1).each_of_second([&](const char* name, std::int64_t value) { status(name + suffix, value); });
        status.add(side_[1].report, suffix);
    }
    status.publish(connection_);
    if (record_ != nullptr) record_->flush();
    longest_us_ = 0.0;
    tell();
}

void BridgeSession::tell() {
    const Clock::time_point now = Clock::now();
    for (std::size_t finger = 0; finger < side_.size(); ++finger) tell(finger, now);
}

/// Of two fingers, which one a line is about.
std::string BridgeSession::who(std::size_t finger) const {
    return side_.size() == 1 ? "" : "finger " + std::to_string(finger + 1) + ": ";
}

void BridgeSession::tell(std::size_t finger, Clock::time_point now) {
    const Side& side = side_[finger];
    const std::string of = who(finger);
    tell_of_states(side.gate.counters(), now, live_, of);
    live_.look(of + "rejected", side.rejected, now, [&] { return of + why_rejected(*scene_.model, side.rejected_m); });
}

bool BridgeSession::has_states() const {
    return std::any_of(side_.begin(), side_.end(), [](const Side& side) { return side.gate.has_states(); });
}

Clock::time_point BridgeSession::last_state() const {
    Clock::time_point last = side_[0].gate.last_state();
    for (const Side& side : side_)
        if (side.gate.has_states()) last = std::max(last, side.gate.last_state());
    return last;
}

BridgeReport BridgeSession::report(std::size_t finger) const {
    BridgeReport report = side_[finger].report;
    static_cast<StateCounters&>(report) = side_[finger].gate.counters();
    report.skipped_bytes = static_cast<std::int64_t>(target_.skipped_bytes());
    report.foreign_frames = static_cast<std::int64_t>(target_.foreign_frames());
    return report;
}

}  // namespace haptable
