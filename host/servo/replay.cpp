// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/servo/replay.hpp"

#include <cstring>
#include <optional>

#include "host/base/progress.hpp"
#include "host/link/clock.hpp"
#include "host/session/record.hpp"

namespace haptable {

namespace {

// Often enough for a progress bar, seldom enough not to be felt.
constexpr std::size_t kProgressEvery_ticks = 4096;

/// As ServoSession does.
haptable_output step(const ServoScene& scene, haptable_servo& servo, const RecordedTick& tick, ReplayReport& report) {
    const std::array<float, 3> finger_m = to_finger(tick.position_m.data());
    haptable_output output{};
    const Clock::time_point begin = Clock::now();
    if (tick.begins) haptable_watch(&servo, servo.position_us + HAPTABLE_SILENCE_US, &output);
    // A gap in time drops the contact.
    if (haptable_watch(&servo, tick.time_us, &output) != 0) report.note(finger_m, output);
    haptable_buttons(&servo, tick.buttons);
    haptable_step(scene.model, &servo, finger_m.data(), tick.time_us, &output);
    report.step.add(to_us(Clock::now() - begin));
    report.note(finger_m, output);
    return output;
}

void compare(const RecordedTick& tick, const haptable_output& output, ReplayReport& report) {
    if (!tick.force_n) return;
    ++report.compared;
    // Bit for bit. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
    if (std::memcmp(tick.force_n->data(), output.force_n, sizeof output.force_n) == 0) return;
    if (report.other_forces++ == 0) report.first_other = tick.number;
}

}  // namespace

ReplayReport replay(const ServoScene& scene, const Recording& recording, const std::filesystem::path& out, bool quiet) {
    Progress progress(quiet);
    progress.stage("replay");
    std::optional<ServoRecord> record;
    if (!out.empty()) record.emplace(scene, out);
    ReplayReport report;
    haptable_servo servo;
    haptable_init(&servo);
    require_whole_tables(scene, servo);
    for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
        const RecordedTick& tick = recording.ticks[i];
        const haptable_output output = step(scene, servo, tick, report);
        compare(tick, output, report);
        if (record) record->add(tick.number, to_finger(tick.position_m.data()), tick.buttons, output);
        if (i % kProgressEvery_ticks == 0)
            progress.done(static_cast<double>(i) / static_cast<double>(recording.ticks.size()));
    }
    report.counters = servo.counters;
    if (record) record->finish();
    return report;
}

ReplayReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                    bool quiet) {
    return replay(scene, read_recording(in), out, quiet);
}

}  // namespace haptable
