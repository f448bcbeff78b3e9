// SPDX-License-Identifier: GPL-2.0-or-later
// tick -> frame -> target -> frame -> checked -> counted
#include "host/session/bridge/line_stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.hpp"

namespace haptable {

namespace {

// How much longer than options.hold a target is waited for its answers tell.
constexpr Clock::duration kMostHold = std::chrono::microseconds(HAPTABLE_SILENCE_US);
constexpr int kHoldTicks = 16;  // to forget a slow one
constexpr double kRateRounding = 1.001;

bool is_finite(const float v[3]) {
    return std::all_of(v, v + 3, [](float x) { return std::isfinite(x); });
}

bool is_same_scene(const TargetHello& a, const TargetHello& b) {
    constexpr unsigned kKind = HAPTABLE_LINE_FREE | HAPTABLE_LINE_TOOL;
    return a.fingers == b.fingers && a.modes == b.modes && (a.flags & kKind) == (b.flags & kKind);
}

std::string in_words(const TargetHello& of) {
    return fmt::format("{} of {} with {} modes",
                       (of.flags & HAPTABLE_LINE_TOOL) != 0 ? "a tool"
                       : of.fingers == 1                    ? "one finger"
                                                            : fmt::format("{} fingers", of.fingers),
                       (of.flags & HAPTABLE_LINE_FREE) != 0 ? "a body that nothing holds" : "a body that is held",
                       of.modes);
}

}  // namespace

LineStepper::LineStepper(SerialTarget& target, const LineOptions& options)
    : Stepper(target.scene()), target_(target), options_(options), hold_(options.hold) {
    if (scene_.body != nullptr) haptable_body_init(scene_.body, &pose_);
    if (scene_.tool != nullptr) tool_.emplace(scene_);
}

// ---- session -> target ---------------------------------------------------------------------------------------------

bool LineStepper::begin(const TickRequest& request) {
    const Clock::time_point now = Clock::now();
    if (!waiting_) deaf_since_ = now;
    for (std::size_t finger = 0; finger < finger_count(); ++finger)
        if (request.is_overtaken[finger]) ++counters_[finger].lost_answers;
    in_ = request.in;
    make_frame(time_for_target(request.time_us));
    waiting_ = true;
    ++number_;
    first_sent_ = now;
    send();
    return false;
}

/// After a gap where all that are there begin: the target knows no sessions.
std::uint32_t LineStepper::time_for_target(std::uint32_t time_us) {
    const bool all_begin = std::all_of(in_.begin(), in_.end(), [](const auto& in) { return !in || in->begins; });
    if (all_begin && number_ > 0) clock_us_ = sent_us_ + HAPTABLE_SILENCE_US - time_us;
    return time_us + clock_us_;
}

/// Who begins beside one that goes on says so by a bit: a gap in time would end the other's contact, too.
void LineStepper::make_frame(std::uint32_t time_us) {
    const bool goes_on = std::any_of(in_.begin(), in_.end(), [](const auto& in) { return in && !in->begins; });
    sent_us_ = time_us;
    frame_ = {};
    frame_.time_us = time_us;
    for (std::size_t finger = 0; finger < finger_count(); ++finger) {
        if (!in_[finger]) continue;
        haptable_input& to = frame_.in[finger];
        to.is_there = 1;
        std::copy(in_[finger]->at_m.begin(), in_[finger]->at_m.end(), to.finger_m);
        to.buttons = in_[finger]->buttons;
        if (goes_on && in_[finger]->begins) frame_.begins |= static_cast<std::uint8_t>(1U << finger);
    }
    if (in_[0]) frame_.turn = in_[0]->turn;
}

void LineStepper::send() {
    last_sent_ = Clock::now();
    if (!is_known_) return target_.ask();
    target_.send(number_, frame_);
}

Clock::time_point LineStepper::free_at(bool is_lockstep) const {
    if (!waiting_) return Clock::time_point::min();
    if (!is_lockstep) return first_sent_ + hold_;
    return finger_count() > 1 ? Clock::time_point::max() : Clock::time_point::min();
}

// ---- target -> session ---------------------------------------------------------------------------------------------

bool LineStepper::take() {
    while (const auto frame = target_.take())
        if (std::visit([this](const auto& said) { return take(said); }, *frame)) return true;
    return false;
}

/// It comes when it is asked for, and when the target begins anew.
bool LineStepper::take(const TargetHello& hello) {
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
    if (!std::exchange(is_known_, true) && waiting_) send();
    return false;
}

bool LineStepper::take(const TargetAnswer& answer) {
    if (!waiting_ || answer.sequence != number_) {
        ++counters_[0].stale_answers;
        hold_ = std::min(2 * hold_, kMostHold);
        return false;
    }
    if (!is_possible(answer)) {
        ++counters_[0].rejected_forces;
        return false;
    }
    waiting_ = false;
    answered_ = answer.sequence;
    const Clock::duration took = Clock::now() - first_sent_;
    hold_ += (std::max<Clock::duration>(std::min(2 * took, kMostHold), options_.hold) - hold_) / kHoldTicks;
    pose_ = answer.body;
    modes_ = answer.modes;
    if (tool_) tool_->take(answer.tool);
    for (std::size_t finger = 0; finger < finger_count(); ++finger) {
        out_[finger] = in_[finger] ? answer.output[finger] : silent_output();
        if (!in_[finger]) continue;
        ++counters_[finger].ticks;
        if (haptable_touches(out_[finger].state) != 0) ++counters_[finger].contact_ticks;
    }
    tick_us_ = to_us(took);
    round_trip_.add(tick_us_);
    note(in_);
    return true;
}

/// What reaches the device is what a servo of these tables can have said, whatever the frame's CRC: a state that there
/// is, numbers, no more than the device's limit, none without contact (but what a release lets fade), nodes that exist.
bool LineStepper::is_possible(const haptable_output& output) const {
    const haptable_model& model = *scene_.model;
    if (output.state > HAPTABLE_FAULTED || !is_finite(output.force_n) || !is_finite(output.god_object_m)) return false;
    if (!std::all_of(output.nodal_force_n, output.nodal_force_n + 3, is_finite)) return false;
    const double size_n = std::hypot(output.force_n[0], output.force_n[1], output.force_n[2]);
    if (size_n > 1.001 * double(model.max_force_n)) return false;
    if (haptable_touches(output.state) != 0) return is_on_a_patch(output);
    if (output.state == HAPTABLE_FREE && output.vertex[0] != HAPTABLE_NONE && !is_on_a_patch(output)) return false;
    const bool fades = output.state == HAPTABLE_FREE && (model.release != nullptr || model.passivity != nullptr);
    return fades || size_n <= 0.0;
}

/// Within so many newtons of what lies between none and the last force given, as haptable_limit_rate keeps it.
bool LineStepper::rises_within(double most_n, const float force_n[3], const float before_n[3]) {
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
bool LineStepper::is_possible(const TargetAnswer& answer) const {
    const haptable_model& model = *scene_.model;
    const double ticks = answer.sequence - answered_;
    const double most_n = kRateRounding * ticks * double{model.rate_n} + 1e-6 * double{model.max_force_n};
    for (std::size_t finger = 0; finger < finger_count(); ++finger) {
        if (!in_[finger]) continue;
        if (!is_possible(answer.output[finger])) return false;
        const float* before_n = out_[finger].force_n;
        if (model.rate != nullptr && !rises_within(most_n, answer.output[finger].force_n, before_n)) return false;
    }
    if (tool_ && !is_possible(answer.tool, ticks)) return false;
    return (scene_.body == nullptr || is_possible(answer.body)) &&
           std::all_of(answer.modes.q, answer.modes.q + HAPTABLE_MODES, [](float q) { return std::isfinite(q); });
}

/// Finite, and a turn.
bool LineStepper::is_possible(const haptable_body_state& body) {
    return is_finite(body.position_m) && is_finite(body.velocity_m_per_s) && is_finite(body.spin_rad_per_s) &&
           is_turn(body.turn);
}

/// Of length 1.
bool LineStepper::is_turn(const float turn[4]) {
    constexpr float kRounding = 1e-4F;
    float length2 = 0.0F;
    for (int i = 0; i < 4; ++i) length2 += turn[i] * turn[i];
    return std::abs(length2 - 1.0F) <= kRounding;
}

/// A torque as a force: within its limits, none without contact. Points that there are, on patches that there are.
bool LineStepper::is_possible(const haptable_tool_line_answer& answer, double ticks) const {
    const haptable_tool_model& tool = *scene_.tool;
    const float* torque_n_m = answer.out.torque_n_m;
    if (!is_finite(torque_n_m) || !is_finite(answer.out.position_m) || !std::isfinite(answer.stored_j)) return false;
    if (!is_turn(answer.out.turn)) return false;
    const double size_n_m = std::hypot(torque_n_m[0], torque_n_m[1], torque_n_m[2]);
    if (size_n_m > (haptable_touches(answer.out.hand.state) != 0 ? 1.001 * double{tool.max_torque_n_m} : 0.0))
        return false;
    const double per_force = double{tool.max_torque_n_m} / double{scene_.model->max_force_n};
    const double most_n_m =
        kRateRounding * ticks * double{scene_.model->rate_n} * per_force + 1e-6 * double{tool.max_torque_n_m};
    if (scene_.model->rate != nullptr && !rises_within(most_n_m, torque_n_m, tool_->output().torque_n_m.data()))
        return false;
    for (std::uint32_t i = 0; i < HAPTABLE_POINTS; ++i)
        if ((answer.inside >> i & 1U) != 0 && (i >= tool.points.count || !is_possible(answer.point[i]))) return false;
    return true;
}

bool LineStepper::is_possible(const haptable_line_point& point) const {
    return point.patch < scene_.model->patch_count && is_within_a_patch(point.alpha) && is_finite(point.god_object_m) &&
           is_finite(point.load_n);
}

/// Its corners are vertices, and the god-object lies between them.
bool LineStepper::is_on_a_patch(const haptable_output& output) const {
    return std::all_of(output.vertex, output.vertex + 3,
                       [this](std::uint16_t vertex) { return vertex < scene_.model->vertex_count; }) &&
           is_within_a_patch(output.alpha);
}

bool LineStepper::is_within_a_patch(const float alpha[3]) {
    constexpr float kRounding = 1e-4F;  // of area coordinates, which sum to 1
    float sum = 0.0F;
    for (int c = 0; c < 3; ++c) {
        if (!(alpha[c] >= -kRounding && alpha[c] <= 1.0F + kRounding)) return false;
        sum += alpha[c];
    }
    return std::abs(sum - 1.0F) <= kRounding;
}

// ---- neither ------------------------------------------------------------------------------------------------------

void LineStepper::release(std::size_t finger) {
    in_[finger].reset();
    waiting_ = waiting_ && std::any_of(in_.begin(), in_.end(), [](const auto& in) { return in.has_value(); });
    out_[finger] = silent_output();
    if (tool_) tool_->release();
    end_account(finger);
}

Clock::time_point LineStepper::watch_at() const {
    return waiting_ ? last_sent_ + options_.retry : Clock::time_point::max();
}

void LineStepper::watch(Clock::time_point now) {
    if (waiting_ && now - deaf_since_ >= std::chrono::duration<double>(options_.patience_s))
        throw Error(
            fmt::format("{}: the target has not answered for {} s ({} bytes of garbage came): is it running, "
                        "of this version (make firmware), and is --baud its own?",
                        target_.line().name(), options_.patience_s, target_.skipped_bytes()));
    if (now < watch_at()) return;
    ++counters_[0].resent_frames;
    if (is_known_) target_.ask();  // it may have begun anew, with other tables
    send();
}

LineCounters LineStepper::counters(std::size_t finger) const {
    LineCounters counters = counters_[finger];
    counters.skipped_bytes = static_cast<std::int64_t>(target_.skipped_bytes());
    counters.foreign_frames = static_cast<std::int64_t>(target_.foreign_frames());
    return counters;
}

void LineStepper::count(std::size_t finger, const Visit& visit) const {
    const LineCounters counters = this->counters(finger);
    if (finger == 0) return counters.each(visit);
    visit("ticks", counters.ticks);
    visit("contact_ticks", counters.contact_ticks);
    visit("lost_answers", counters.lost_answers);
}

}  // namespace haptable
