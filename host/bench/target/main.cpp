// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-target: instructions of a tick in every mode, on four bodies, on every target, for
// docs/COSTS.md and docs/data.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/subject.hpp"
#include "host/bench/target/bodies.hpp"
#include "host/bench/target/fingers.hpp"
#include "host/bench/target/named.hpp"
#include "host/numbers/numbers.hpp"
#include "host/precompute/precompute.hpp"
#include "host/scene/scene.hpp"
#include "host/target/counts.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr int kStrokes = 200;                        // 4,000 ticks a body
constexpr double kInstructionsAMillisecond = 168e3;  // 168 MHz, one instruction a clock

struct Body {
    const char* name;
    const char* scene;
    double mask_radius_m;
};
constexpr std::array kBodies{Body{"cube", "meshes/cube.toml", 0.012}, Body{"mouse", "meshes/mouse.toml", 0.006},
                             Body{"needle", "meshes/hard/needle.toml", 0.004},
                             Body{"torus", "meshes/hard/torus.toml", 0.010}};

/// The body's tables for a force, precomputed below `folder`.
std::unique_ptr<Subject> subject(const Body& body, ForceLaw force, const fs::path& folder) {
    Scene scene = read_scene(body.scene);
    scene.contact.force = force;
    scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? body.mask_radius_m : 0.0;
    scene.tables.columns = ColumnRows::kNone;
    const fs::path out = folder / fmt::format("{}-{}", body.name, word(force));
    Progress progress(true);
    precompute(scene, out, progress);
    return std::make_unique<Subject>(out);
}

/// Instructions of the ticks of one body, mode and target.
struct Ticks {
    std::vector<std::uint64_t> sliding, all;

    void add(const std::vector<TargetTick>& ticks) {
        for (std::size_t i = 1; i < ticks.size(); ++i) {
            const std::uint32_t before = ticks[i - 1].finger[0].state, after = ticks[i].finger[0].state;
            if (after == HAPTABLE_REJECTED) continue;
            all.push_back(ticks[i].instructions);
            if (after == HAPTABLE_CONTACT && before == HAPTABLE_CONTACT) sliding.push_back(ticks[i].instructions);
        }
    }
    std::uint64_t worst() const { return *std::max_element(all.begin(), all.end()); }
};

std::uint64_t quantile(std::vector<std::uint64_t> values, double fraction) {
    const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

/// "median / 99.9 % / worst"
Number cell(const Ticks& ticks) {
    const std::uint64_t median = quantile(ticks.sliding, 0.5), most = quantile(ticks.all, 0.999), worst = ticks.worst();
    return {{static_cast<double>(median), static_cast<double>(most), static_cast<double>(worst)},
            fmt::format("{} / {} / {}", thousands(median), thousands(most), thousands(worst))};
}

Number of_a_millisecond(std::uint64_t instructions) {
    const double fraction = static_cast<double>(instructions) / kInstructionsAMillisecond;
    return number(fraction, fmt::format("{:.0f} %", 100.0 * fraction));
}

/// By target, mode and body.
using Counted = std::map<std::string, std::map<std::string, std::map<std::string, Ticks>>>;

/// `fan`: the most patches around a vertex of any of the bodies.
Counted count_all(const fs::path& build, std::uint64_t& fan) {
    Counted counted;
    for (const Body& body : kBodies)
        for (const ForceLaw force : every<ForceLaw>()) {
            const auto touched = subject(body, force, build / "modes");
            const auto path_m = hard_path(touched->tables(), kStrokes);
            fan = std::max(fan, most_patches_around_a_vertex(touched->model()));
            for (const Mode& mode : every_mode()) {
                if (mode.force != force) continue;
                for (const char* target : kTargets)
                    counted[target][mode.name()][body.name].add(
                        TargetImage(build, "cube", target).measure({in_mode(touched->model(), mode)}, path_m));
            }
        }
    return counted;
}

/// On the Cortex-M7 by body, and the bound by reasoning.
NumberTable by_body(const Counted& counted, std::uint64_t fan) {
    NumberTable table{{"Cortex-M7: force, god-object"}, {}};
    for (const Body& body : kBodies) table.columns.emplace_back(body.name);
    for (const char* column : {"worst, of 1 ms", "bound", "of 1 ms"}) table.columns.emplace_back(column);
    for (const Mode& mode : every_mode()) {
        std::uint64_t worst = 0;
        auto& row = table.rows.emplace_back(std::vector<Cell>{mode.name()});
        for (const Body& body : kBodies) {
            const Ticks& ticks = counted.at("cortex-m7").at(mode.name()).at(body.name);
            worst = std::max(worst, ticks.worst());
            row.push_back(cell(ticks));
        }
        const std::uint64_t bound = most_cost(mode, fan);
        if (worst > bound) throw Error(mode.name() + ": a tick is above its bound in host/target/modes.cpp");
        for (const Number& last : {of_a_millisecond(worst), count(bound), of_a_millisecond(bound)}) row.push_back(last);
    }
    return table;
}

/// A part that has a target's core, at the clock that it is sold with.
struct Part {
    const char* target;
    const char* name;
    double clock_hz;
};
constexpr std::array kParts{Part{"cortex-m4", "M4F", 168e6}, Part{"cortex-m33", "M33", 150e6},
                            Part{"rv32", "rv32", 400e6}, Part{"cortex-m7", "M7", 600e6}};
constexpr std::array kRates_hz{5e3, 10e3};

/// Whether every tick ends in time, at an instruction a clock: by its bound, by all that were counted, by all but one
/// in a thousand, or not.
std::string in_time(const Part& part, double rate_hz, const Ticks& ticks, std::uint64_t bound) {
    const double most = part.clock_hz / rate_hz;
    if (static_cast<double>(bound) <= most) return "bound";
    if (static_cast<double>(ticks.worst()) <= most) return "counted";
    return static_cast<double>(quantile(ticks.all, 0.999)) <= most ? "99.9 %" : "no";
}

/// All bodies together.
Ticks of_all_bodies(const Counted& counted, const char* target, const Mode& mode) {
    Ticks all;
    for (const auto& [body, ticks] : counted.at(target).at(mode.name())) {
        all.sliding.insert(all.sliding.end(), ticks.sliding.begin(), ticks.sliding.end());
        all.all.insert(all.all.end(), ticks.all.begin(), ticks.all.end());
    }
    return all;
}

/// Which modes run faster than at 1 kHz, on which part.
NumberTable by_rate(const Counted& counted, std::uint64_t fan) {
    NumberTable table{{"force, god-object"}, {}};
    for (const Part& part : kParts)
        for (const double rate_hz : kRates_hz)
            table.columns.push_back(fmt::format("{}, {:.0f} kHz", part.name, rate_hz / 1e3));
    for (const Mode& mode : every_mode()) {
        auto& row = table.rows.emplace_back(std::vector<Cell>{mode.name()});
        for (const Part& part : kParts) {
            const Ticks ticks = of_all_bodies(counted, part.target, mode);
            for (const double rate_hz : kRates_hz)
                row.emplace_back(in_time(part, rate_hz, ticks, most_cost(mode, fan)));
        }
    }
    return table;
}

/// All bodies together, the other targets.
NumberTable by_target(const Counted& counted) {
    NumberTable table{{"force, god-object", "Cortex-M4F", "Cortex-M33", "rv32imafc"}, {}};
    for (const Mode& mode : every_mode()) {
        auto& row = table.rows.emplace_back(std::vector<Cell>{mode.name()});
        for (const char* target : {"cortex-m4", "cortex-m33", "rv32"})
            row.push_back(cell(of_all_bodies(counted, target, mode)));
    }
    return table;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app("Counts the instructions of a tick in every contact mode, for docs/COSTS.md.",
                              "haptable-bench-target");
    std::filesystem::path build = "build", out;
    bool named = false, fingers = false, bodies = false;
    app.option("--build", build, "where images and tables are").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    app.flag("--named", named, "what a scene pays for what it names instead");
    app.flag("--fingers", fingers, "what two fingers take beside one instead");
    app.flag("--bodies", bodies, "what bodies take that nothing holds, or that ring, instead");
    return haptable::run_program(app, argc, argv, [&] {
        using namespace haptable;
        const std::string missing = TargetImage(build, "cube", "cortex-m7").missing();
        if (!missing.empty()) throw Error(missing);
        Numbers numbers("make bench");
        if (fingers) {
            const FingerCosts costs = finger_costs(build);
            numbers.add("fingers", costs.costs);
            numbers.add("fingers-by-rate", costs.rates);
        } else if (bodies) {
            numbers.add("bodies", body_costs(build));
        } else if (named) {
            const NamedCosts costs = named_costs(build);
            numbers.add("named", costs.costs);
            numbers.add("named-mouse", costs.mouse);
            numbers.add("precision-compliance", costs.precision);
        } else {
            std::uint64_t fan = 0;
            const Counted counted = count_all(build, fan);
            numbers.add("modes-by-body", by_body(counted, fan));
            numbers.add("modes-by-target", by_target(counted));
            numbers.add("modes-by-rate", by_rate(counted, fan));
            numbers.add("modes-fan", count(fan));
        }
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
