// SPDX-License-Identifier: GPL-2.0-or-later
// An hour of faults: sessions of a minute of simulated time, each with a mixture by lot, watched at every tick. Linked
// with the sanitizers (make soak), which count what is allocated.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/progress.hpp"
#include "host/base/summary_lines.hpp"
#include "tests/loop/faulty_session.hpp"
#include "tests/loop/limited_box.hpp"

// Of the sanitizers' runtime; gcc 12 brings no header for it.
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();

namespace haptable::test {
namespace {

constexpr double kSession_s = 60.0;
// A session has all that it will ever need by then.
constexpr std::int64_t kSettled_ticks = 10'000;
// A byte in 100 ticks would be 500.
constexpr std::size_t kMostGrowth_bytes = 256;

struct Options {
    double seconds = 3600.0;
    std::uint64_t seed = 1;
    bool quiet = false;
};

struct Soaked {
    std::int64_t sessions = 0, ticks = 0, felt_ticks = 0, silences = 0, missed = 0;
    double largest_force_n = 0.0;
    std::size_t largest_growth_bytes = 0;
};

void soak_one(const ServoScene& scene, std::uint64_t seed, double seconds, Progress& progress, double done,
              double share_of_a_tick, Soaked& soaked) {
    const FaultPlan plan = random_faults(seed);
    const auto last = static_cast<std::int64_t>(std::ceil(seconds * 1000.0 - 1e-6)) - 1;
    std::size_t settled_bytes = 0, end_bytes = 0;
    const Watched watched = run_faulty_session(scene, plan, seed, seconds, [&](std::int64_t tick) {
        if (tick == kSettled_ticks) settled_bytes = __sanitizer_get_current_allocated_bytes();
        if (tick == last) end_bytes = __sanitizer_get_current_allocated_bytes();
        if (tick % 1000 == 0)
            progress.done(done + static_cast<double>(tick) * share_of_a_tick, fmt::format("session {}", seed));
    });
    const auto fail = [&](const std::string& what) {
        throw Error(fmt::format("--seed {} --fault {}: {}", seed, to_text(plan), what));
    };
    if (!watched.violation.empty()) fail(watched.violation);
    if (settled_bytes > 0 && end_bytes > settled_bytes + kMostGrowth_bytes)
        fail(fmt::format("{} bytes allocated at tick {}, {} at the end", settled_bytes, kSettled_ticks, end_bytes));
    ++soaked.sessions;
    soaked.ticks += watched.device.ticks;
    soaked.felt_ticks += watched.felt_ticks;
    soaked.silences += watched.silences;
    soaked.missed += watched.device.missed;
    soaked.largest_force_n = std::max(soaked.largest_force_n, watched.device.largest_force_n);
    if (end_bytes > settled_bytes)
        soaked.largest_growth_bytes = std::max(soaked.largest_growth_bytes, end_bytes - settled_bytes);
}

/// By turns without limits beside max_force, and with all of them.
void soak(const Options& o) {
    const SoftBox box;
    const LimitedBox limited;
    Progress progress(o.quiet);
    progress.stage("soak");
    Soaked soaked;
    for (double begun_s = 0.0; begun_s < o.seconds - 1e-9; begun_s += kSession_s)
        soak_one(soaked.sessions % 2 == 0 ? box.scene() : limited.scene(),
                 o.seed + static_cast<std::uint64_t>(soaked.sessions), std::min(kSession_s, o.seconds - begun_s),
                 progress, begun_s / o.seconds, 1e-3 / o.seconds, soaked);
    progress.clear();
    SummaryLines summary;
    summary.add("sessions", soaked.sessions);
    summary.add("ticks", soaked.ticks);
    summary.add("ticks_with_force", soaked.felt_ticks);
    summary.add("silences", soaked.silences);
    summary.add("missed", soaked.missed);
    summary.add("largest_force_n", soaked.largest_force_n);
    summary.add("largest_growth_bytes", static_cast<std::int64_t>(soaked.largest_growth_bytes));
    summary.print(false, o.quiet);
}

}  // namespace
}  // namespace haptable::test

int main(int argc, char** argv) {
    haptable::CommandLine app("Sessions with faults by lot in simulated time, watched at every tick.", "soak");
    haptable::test::Options options;
    app.option("--seconds", options.seconds, "of simulated time").positive().show_default();
    app.option("--seed", options.seed, "of the first session; the next has the next one").show_default();
    app.flag("--quiet", options.quiet, "print nothing but errors");
    return haptable::run_program(app, argc, argv, [&] {
        haptable::catch_interrupts();
        haptable::test::soak(options);
    });
}
