// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/replay.hpp"

#include <fmt/format.h>

#include <cstring>

#include "host/base/progress.hpp"
#include "host/session/record.hpp"

namespace haptable {

namespace {

// Often enough for a progress bar, seldom enough not to be felt.
constexpr std::size_t kProgressEvery_ticks = 4096;

std::optional<FingerInput> input(const std::optional<RecordedFinger>& finger) {
    if (!finger) return std::nullopt;
    return FingerInput{to_finger(finger->position_m.data()), finger->buttons, finger->begins, finger->turn};
}

FingerInputs inputs(const RecordedTick& tick) {
    FingerInputs in;
    for (std::size_t finger = 0; finger < kFingers; ++finger) in[finger] = input(tick.finger[finger]);
    return in;
}

void compare(const RecordedTick& tick, const LocalStepper& fingers, ReplayReport& report) {
    for (std::size_t finger = 0; finger < kFingers; ++finger) {
        if (!tick.finger[finger] || !tick.finger[finger]->force_n) continue;
        const haptable_output& output = fingers.output(finger);
        ++report.compared;
        // Bit for bit. NOLINTNEXTLINE(bugprone-suspicious-memory-comparison)
        if (std::memcmp(tick.finger[finger]->force_n->data(), output.force_n, sizeof output.force_n) == 0) continue;
        if (report.other_forces++ == 0) report.first_other = tick.number;
    }
}

/// The scene as the recording needs it: a path of one finger is felt as in a scene with one.
ServoScene scene_for(ServoScene scene, const Recording& recording) {
    if (recording.fingers > fingers_of(scene))
        throw Error(
            fmt::format("the path has {0} fingers, and the scene {1} has {2}: write fingers = {0} in [contact] "
                        "and make it again",
                        recording.fingers, scene.name, fingers_of(scene)));
    if (recording.has_tool != (scene.tool != nullptr))
        throw Error(std::string("the path has ") + (recording.has_tool ? "the" : "no") +
                    " orientation of a tool, and the scene " + scene.name +
                    (scene.tool != nullptr ? " has a [tool]: give a path x,y,z,qw,qx,qy,qz"
                                           : " has no [tool]: give a path x,y,z"));
    if (recording.fingers == 1 && !recording.is_log) scene.pair = nullptr;
    return scene;
}

/// As the servo of the session does.
class Replay {
public:
    Replay(const ServoScene& scene, const std::filesystem::path& out, bool is_log)
        : fingers_(scene), is_numbered_(scene.pair == nullptr || !is_log) {
        if (!out.empty()) record_.emplace(scene, out);
    }

    void add(const RecordedTick& tick) {
        const FingerInputs in = inputs(tick);
        const std::int64_t number = is_numbered_ ? tick.number : numbers_.next(fingers_.is_first_tick(in));
        fingers_.tick(in, tick.time_us);
        compare(tick, fingers_, report_);
        if (record_)
            record_->add(number, in, fingers_.outputs(), fingers_.touched(), fingers_.modes(), fingers_.tool());
    }

    ReplayReport finish() {
        static_cast<ServoReport&>(report_) = fingers_.report(0);
        for (std::size_t i = 1; i < fingers_.finger_count(); ++i) report_.others.push_back(fingers_.report(i));
        report_.most_given_j = fingers_.most_given_j();
        if (record_) record_->finish();
        return report_;
    }

private:
    LocalStepper fingers_;
    bool is_numbered_;
    TickNumbers numbers_;
    std::optional<ServoRecord> record_;
    ReplayReport report_;
};

}  // namespace

ReplayReport replay(const ServoScene& scene, const Recording& recording, const std::filesystem::path& out, bool quiet) {
    Progress progress(quiet);
    progress.stage("replay");
    Replay run(scene_for(scene, recording), out, recording.is_log);
    for (std::size_t i = 0; i < recording.ticks.size(); ++i) {
        run.add(recording.ticks[i]);
        if (i % kProgressEvery_ticks == 0)
            progress.done(static_cast<double>(i) / static_cast<double>(recording.ticks.size()));
    }
    return run.finish();
}

ReplayReport replay(const ServoScene& scene, const std::filesystem::path& in, const std::filesystem::path& out,
                    bool quiet) {
    return replay(scene, read_recording(in), out, quiet);
}

}  // namespace haptable
