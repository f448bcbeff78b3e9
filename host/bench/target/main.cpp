// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-target: instructions of a tick in every mode, on four bodies, on every target, as the tables of
// docs/INSTRUCTIONS.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/subject.hpp"
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
std::unique_ptr<Subject> subject(const Body& body, const std::string& force, const fs::path& folder) {
    Scene scene = read_scene(body.scene);
    scene.contact.force = force;
    scene.contact.mask_radius_m = force == "pressure-mask" ? body.mask_radius_m : 0.0;
    scene.tables.columns = "none";
    const fs::path out = folder / fmt::format("{}-{}", body.name, force);
    Progress progress(true);
    precompute(scene, out, progress);
    return std::make_unique<Subject>(out);
}

/// Instructions of the ticks of one body, mode and target.
struct Ticks {
    std::vector<std::uint64_t> sliding, all;

    void add(const std::vector<TargetTick>& ticks) {
        for (std::size_t i = 1; i < ticks.size(); ++i) {
            if (ticks[i].state == HAPTABLE_REJECTED) continue;
            all.push_back(ticks[i].instructions);
            if (ticks[i].state == HAPTABLE_CONTACT && ticks[i - 1].state == HAPTABLE_CONTACT)
                sliding.push_back(ticks[i].instructions);
        }
    }
    std::uint64_t worst() const { return *std::max_element(all.begin(), all.end()); }
};

std::uint64_t quantile(std::vector<std::uint64_t> values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

std::string thousands(std::uint64_t n) {
    return n < 1000 ? fmt::format("{}", n) : fmt::format("{},{:03}", n / 1000, n % 1000);
}

/// "median / 99.9 % / worst"
std::string cell(const Ticks& ticks) {
    return fmt::format("{} / {} / {}", thousands(quantile(ticks.sliding, 0.5)), thousands(quantile(ticks.all, 0.999)),
                       thousands(ticks.worst()));
}

std::string share(std::uint64_t instructions) {
    return fmt::format("{:.0f} %", 100.0 * static_cast<double>(instructions) / kInstructionsAMillisecond);
}

/// By target, mode and body.
using Counted = std::map<std::string, std::map<std::string, std::map<std::string, Ticks>>>;

/// `fan`: the most patches around a vertex of any of the bodies.
Counted count_all(const fs::path& build, std::uint64_t& fan) {
    Counted counted;
    for (const Body& body : kBodies)
        for (const char* force : {"interpolated", "consistent", "pressure-mask"}) {
            const auto touched = subject(body, force, build / "modes");
            const auto path_m = hard_path(touched->tables(), kStrokes);
            fan = std::max(fan, most_patches_around_a_vertex(touched->model()));
            for (const Mode& mode : every_mode()) {
                if (mode.force != force) continue;
                for (const char* target : kTargets)
                    counted[target][mode.name()][body.name].add(
                        TargetImage(build, "cube", target).measure(in_mode(touched->model(), mode), path_m));
            }
        }
    return counted;
}

/// On the Cortex-M7 by body, and the bound by reasoning.
std::string by_body(const Counted& counted, std::uint64_t fan) {
    std::string text =
        "| Cortex-M7: force, god-object | cube | mouse | needle | torus | worst, of 1 ms | bound | of 1 ms |\n"
        "|---|---|---|---|---|---|---|---|\n";
    for (const Mode& mode : every_mode()) {
        std::uint64_t worst = 0;
        text += fmt::format("| {} ", mode.name());
        for (const Body& body : kBodies) {
            const Ticks& ticks = counted.at("cortex-m7").at(mode.name()).at(body.name);
            worst = std::max(worst, ticks.worst());
            text += fmt::format("| {} ", cell(ticks));
        }
        const std::uint64_t bound = most_cost(mode, fan);
        if (worst > bound) throw Error(mode.name() + ": a tick is above its bound in host/target/modes.cpp");
        text += fmt::format("| {} | {} | {} |\n", share(worst), thousands(bound), share(bound));
    }
    return text;
}

/// All bodies together, the other targets.
std::string by_target(const Counted& counted) {
    std::string text = "| force, god-object | Cortex-M4F | Cortex-M33 | rv32imafc |\n|---|---|---|---|\n";
    for (const Mode& mode : every_mode()) {
        text += fmt::format("| {} ", mode.name());
        for (const char* target : {"cortex-m4", "cortex-m33", "rv32"}) {
            Ticks all;
            for (const auto& [body, ticks] : counted.at(target).at(mode.name())) {
                all.sliding.insert(all.sliding.end(), ticks.sliding.begin(), ticks.sliding.end());
                all.all.insert(all.all.end(), ticks.all.begin(), ticks.all.end());
            }
            text += fmt::format("| {} ", cell(all));
        }
        text += "|\n";
    }
    return text;
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    CLI::App app("Counts the instructions of a tick in every contact mode, for docs/INSTRUCTIONS.md.",
                 "haptable-bench-target");
    std::filesystem::path build = "build", out;
    app.add_option("--build", build, "where images and tables are")->capture_default_str();
    app.add_option("-o", out, "the Markdown tables go here; left out: to standard output");
    return haptable::run_program(app, argc, argv, [&] {
        using namespace haptable;
        const std::string missing = TargetImage(build, "cube", "cortex-m7").missing();
        if (!missing.empty()) throw Error(missing);
        std::uint64_t fan = 0;
        const Counted counted = count_all(build, fan);
        const std::string text =
            by_body(counted, fan) + "\n" + by_target(counted) +
            fmt::format("\nThe bounds are for up to {} patches around a vertex, as these bodies have.\n", fan);
        if (out.empty())
            fmt::print("{}", text);
        else
            write_file(out, text);
    });
}
