// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-hard: the hard cases as one table: case, condition, error, verdict. tests/hard holds each to its bound.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/base/progress.hpp"
#include "host/hard/measure.hpp"
#include "host/numbers/numbers.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

constexpr int kPatches = 100;

/// What came out of one case and force.
struct Outcome {
    std::string refused;
    double condition = 0.0;
    StiffnessErrors stiffness;
    ForceErrors force;
    double stated = 0.0;
    bool warned = false;
    std::vector<Remedy> remedies;
};

Outcome measure(const HardCase& hard, ForceLaw force, const fs::path& folder) try {
    const HardBody body(hard, force, folder);
    const Reference reference = solve_densely(hard.scene, body.body());
    Outcome outcome;
    outcome.condition = body.summary().inverse.checks.scaled_condition;
    outcome.stiffness = compare_stiffness(body, reference);
    outcome.force = compare_force(body, reference, GodObject::kNearest, kPatches);
    outcome.stated = digits_of(body.summary()).servo.worst;
    outcome.warned = !body.warnings().empty();
    outcome.remedies = body.summary().size.remedies;
    return outcome;
} catch (const Error& error) {
    Outcome outcome;
    outcome.refused = error.what();
    return outcome;
}

const std::string kWrong = "WRONG";

std::string verdict(const HardCase& hard, const Outcome& outcome) {
    if (!hard.refusal.empty())
        return outcome.refused.find(hard.refusal) == std::string::npos ? kWrong + ": " + outcome.refused : "refused";
    if (!outcome.refused.empty()) return kWrong + (": " + outcome.refused);
    if (!(outcome.stiffness.least_eigenvalue > 0.0) || outcome.force.touches == 0 || outcome.force.missed > 0 ||
        !std::isfinite(outcome.force.worst))
        return kWrong;
    if (outcome.warned) return "told";
    return outcome.force.worst > kMostServoError ? kWrong : "within 1e-3";
}

/// The row of a case, by both forces: the worse verdict.
void add_row(const HardCase& hard, const Outcome& paper, const Outcome& consistent, NumberTable& table) {
    const std::string one = verdict(hard, paper), other = verdict(hard, consistent);
    if (!hard.refusal.empty()) {
        table.rows.push_back({hard.name, "", "", "", "", "", one});
        return;
    }
    const bool first = one.starts_with(kWrong) || (paper.warned && !other.starts_with(kWrong));
    table.rows.push_back({hard.name, number(paper.condition, fmt::format("{:.1e}", paper.condition)),
                          error_of(paper.stiffness.worst), error_of(paper.force.worst),
                          error_of(consistent.force.worst), error_of(std::max(paper.stated, consistent.stated)),
                          first ? one : other});
}

/// Throws Error where a case did not go as it must.
void require_right(const NumberTable& table) {
    for (const auto& row : table.rows)
        if (std::get<std::string>(row.back()).starts_with(kWrong))
            throw Error(fmt::format("hard case \"{}\": is neither exact nor told nor refused with its cause",
                                    std::get<std::string>(row.front())));
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Computes the hard cases and compares them with dense references in long double.", "haptable-hard");
    fs::path build = "build/hard", out;
    bool quiet = false;
    app.option("--build", build, "folder for meshes and tables").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    app.flag("--quiet", quiet, "no progress bar");
    return run_program(app, argc, argv, [&] {
        Progress progress(quiet);
        NumberTable table{{"case", "condition of K, scaled", "S in double", "force of the servo, interpolated",
                           "the same, consistent", "what the tool states", "verdict"},
                          {}};
        NumberTable remedies{{"case", "force", "error stated", "what helps", "error then"}, {}};
        for (const HardCase& hard : hard_cases(build / "meshes")) {
            progress.stage(hard.name);
            const Outcome paper = measure(hard, ForceLaw::kInterpolated, build / "tables");
            const Outcome consistent = measure(hard, ForceLaw::kConsistent, build / "tables");
            add_row(hard, paper, consistent, table);
            for (const auto& [force, outcome] : {std::pair{"interpolated", &paper}, {"consistent", &consistent}})
                for (const Remedy& remedy : outcome->remedies)
                    remedies.rows.push_back(
                        {hard.name, force, error_of(outcome->stated), remedy.text, error_of(remedy.error)});
        }
        Numbers numbers("make bench");
        numbers.add("hard", table);
        numbers.add("hard-remedies", remedies);
        progress.clear();
        print_topics(numbers);
        require_right(table);
        if (!out.empty()) numbers.write(out);
    });
}
