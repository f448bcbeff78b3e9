// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/servo/replay.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "host/base/progress.hpp"
#include "host/link/clock.hpp"
#include "host/session/body_motion.hpp"
#include "host/session/record.hpp"

namespace haptable {

namespace {

// Often enough for a progress bar, seldom enough not to be felt.
constexpr std::size_t kProgressEvery_ticks = 4096;

/// As ServoSession does.
haptable_output step(BodyMotion& body, haptable_servo& servo, const RecordedTick& tick, ReplayReport& report) {
    const std::array<float, 3> finger_m = to_finger(tick.position_m.data());
    haptable_output output{};
    const Clock::time_point begin = Clock::now();
    if (tick.begins) haptable_watch(&servo, servo.position_us + HAPTABLE_SILENCE_US, &output);
    // A gap in time drops the contact.
    if (haptable_watch(&servo, tick.time_us, &output) != 0) report.note(finger_m, output);
    haptable_buttons(&servo, tick.buttons);
    body.step(servo, finger_m, tick.time_us, output);
    report.step.add(to_us(Clock::now() - begin));
    report.note(finger_m, output);
    return output;
}

/// What two fingers' ticks came to.
void note(const std::array<std::array<float, 3>, 2>& finger_m, const haptable_output out[2], ReplayReport& report) {
    report.note(finger_m[0], out[0]);
    report.second->note(finger_m[1], out[1]);
    report.most_given_j = std::max(report.most_given_j, report.energy.given_j() + report.second->energy.given_j());
}

/// The same of two fingers.
void step(BodyMotion& body, haptable_pair& pair, const RecordedTick& tick, haptable_output out[2],
          ReplayReport& report) {
    const std::array finger_m{to_finger(tick.position_m.data()), to_finger(tick.second_m->data())};
    const float positions_m[2][3] = {{finger_m[0][0], finger_m[0][1], finger_m[0][2]},
                                     {finger_m[1][0], finger_m[1][1], finger_m[1][2]}};
    const Clock::time_point begin = Clock::now();
    bool silent = false;
    for (int finger = 0; finger < 2; ++finger) {
        haptable_servo& servo = pair.servo[finger];
        if (tick.begins) haptable_pair_watch(&pair, finger, servo.position_us + HAPTABLE_SILENCE_US, &out[finger]);
        silent |= haptable_pair_watch(&pair, finger, tick.time_us, &out[finger]) != 0;
        haptable_buttons(&servo, finger == 0 ? tick.buttons : tick.second_buttons);
    }
    if (silent) note(finger_m, out, report);
    body.step(pair, positions_m, tick.time_us, out);
    report.step.add(to_us(Clock::now() - begin));
    note(finger_m, out, report);
}

void compare(const RecordedTick& tick, const haptable_output& output, ReplayReport& report) {
    if (!tick.force_n) return;
    ++report.compared;
    // Bit for bit. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    if (std::memcmp(tick.force_n->data(), output.force_n, sizeof output.force_n) == 0) return;
    if (report.other_forces++ == 0) report.first_other = tick.number;
}

}  // namespace

namespace {

bool has_two(const Recording& recording) {
    return !recording.ticks.empty() && recording.ticks.front().second_m.has_value();
}

/// Two fingers' record.
ReplayReport replay_two(const ServoScene& scene, const Recording& recording, const std::filesystem::path& out,
                        Progress& progress, const haptable_body* body) {
    std::optional<ServoRecord> record;
    if (!out.empty()) record.emplace(scene, out, 2, body != nullptr);
    ReplayReport report;
    report.second.emplace();
    haptable_pair pair;
    haptable_pair_init(scene.pair, &pair);
    for (haptable_servo& servo : pair.servo) require_whole_tables(scene, servo);
    BodyMotion motion(scene, body);
    for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
        const RecordedTick& tick = recording.ticks[i];
        haptable_output output[2]{};
        step(motion, pair, tick, output, report);
        if (record)
            record->add(tick.number, {to_finger(tick.position_m.data()), to_finger(tick.second_m->data())},
                        {tick.buttons, tick.second_buttons}, output, motion.state());
        if (i % kProgressEvery_ticks == 0)
            progress.done(static_cast<double>(i) / static_cast<double>(recording.ticks.size()));
    }
    report.counters = pair.servo[0].counters;
    report.second->counters = pair.servo[1].counters;
    if (record) record->finish();
    return report;
}

}  // namespace

ReplayReport replay(const ServoScene& scene, const Recording& recording, const std::filesystem::path& out, bool quiet,
                    const haptable_body* body) {
    Progress progress(quiet);
    progress.stage("replay");
    if (has_two(recording)) {
        if (scene.pair == nullptr)
            throw Error(std::string("the path has two fingers, and the scene ") + scene.name +
                        " has one: write fingers = 2 in [contact] and make it again");
        return replay_two(scene, recording, out, progress, body);
    }
    std::optional<ServoRecord> record;
    if (!out.empty()) record.emplace(scene, out, 1, body != nullptr);
    ReplayReport report;
    haptable_servo servo;
    haptable_init(&servo);
    require_whole_tables(scene, servo);
    BodyMotion motion(scene, body);
    for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
        const RecordedTick& tick = recording.ticks[i];
        const haptable_output output = step(motion, servo, tick, report);
        compare(tick, output, report);
        if (record) record->add(tick.number, to_finger(tick.position_m.data()), tick.buttons, output, motion.state());
        if (i % kProgressEvery_ticks == 0)
            progress.done(static_cast<double>(i) / static_cast<double>(recording.ticks.size()));
    }
    report.counters = servo.counters;
    if (record) record->finish();
    return report;
}

ReplayReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                    bool quiet, const haptable_body* body) {
    return replay(scene, read_recording(in), out, quiet, body);
}

}  // namespace haptable
