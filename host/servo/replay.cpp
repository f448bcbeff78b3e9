// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/servo/replay.hpp"

#include "host/base/progress.hpp"
#include "host/link/clock.hpp"
#include "host/link/finger_path.hpp"
#include "host/session/record.hpp"

namespace haptable {

namespace {

// Often enough for a progress bar, seldom enough not to be felt.
constexpr std::size_t kProgressEvery_ticks = 4096;

}  // namespace

ServoReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                   bool quiet) {
    const auto path = read_finger_ticks(in, Positions::any);
    Progress progress(quiet);
    progress.stage("replay");
    ServoRecord record(scene, out);
    ServoReport report;
    haptable_servo servo;
    haptable_init(&servo);
    for (std::size_t tick = 0; tick < path.size(); ++tick) {
        const std::array<float, 3> finger_m = to_finger(path[tick].position_m.data());
        haptable_output output;
        const Clock::time_point begin = Clock::now();
        haptable_buttons(&servo, path[tick].buttons);
        haptable_step(scene.model, &servo, finger_m.data(), static_cast<std::uint32_t>(tick) * HAPTABLE_TICK_US,
                      &output);
        report.step.add(to_us(Clock::now() - begin));
        report.note(finger_m, output);
        record.add(static_cast<std::int64_t>(tick), finger_m, path[tick].buttons, output);
        if (tick % kProgressEvery_ticks == 0)
            progress.done(static_cast<double>(tick) / static_cast<double>(path.size()));
    }
    report.counters = servo.counters;
    record.finish();
    return report;
}

}  // namespace haptable
