// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-error: how far the force is from the body's, by configuration, against what it costs.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/program.hpp"
#include "host/base/progress.hpp"
#include "host/bench/error/contact_error.hpp"
#include "host/bench/error/elements.hpp"
#include "host/bench/error/elsewhere.hpp"
#include "host/bench/error/known.hpp"
#include "host/bench/error/large_strain.hpp"
#include "host/bench/error/points.hpp"
#include "host/bench/error/specimen.hpp"
#include "host/numbers/numbers.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

Numbers solve_truths(const fs::path& build, Progress& progress) {
    std::vector<std::pair<std::string, std::vector<Truth>>> truths;
    for (const Specimen& specimen : specimens(true, build)) {
        progress.stage("the body itself: " + specimen.name);
        truths.emplace_back(specimen.name, solve_truth(specimen));
    }
    Numbers numbers("make bench-large PART=truth");
    numbers.add("truth", truth_table(truths));
    return numbers;
}

void measure_all(const fs::path& known, bool quick, const fs::path& build, Progress& progress, Numbers& numbers) {
    const auto topics = read_numbers(known);
    std::vector<Point> points;
    std::vector<std::vector<Cell>> contacts;
    for (const Specimen& specimen : specimens(quick, build)) {
        const auto truths = truth_of(topics, specimen.name);
        for (const Meshed& meshed : specimen.meshes) {
            progress.stage(fmt::format("error and speed: {}, {}", specimen.name, meshed.name));
            for (const auto& measured : {measure_points(specimen, meshed, truths, build, quick, progress),
                                         measure_instead(specimen, meshed, truths)})
                points.insert(points.end(), measured.begin(), measured.end());
        }
        const Meshed& coarse = specimen.meshes[specimen.meshes.size() > 2 ? 2 : 0];
        for (auto& row : contact_errors(specimen, coarse, truths, build)) contacts.push_back(std::move(row));
    }
    numbers.add("points", point_table(points));
    numbers.add("contact-error", contact_error_table(std::move(contacts)));
}

Numbers compare_with_known(const fs::path& build, Progress& progress) {
    Numbers numbers("make bench-large PART=known");
    numbers.add("known", known_answers(build / "known", progress));
    return numbers;
}

Numbers compare_elsewhere(const fs::path& build, Progress& progress) {
    Numbers numbers("make bench-large PART=elsewhere");
    numbers.add("elsewhere", measure_elsewhere(build, progress));
    return numbers;
}

Numbers measure_large_strain(const fs::path& build, Progress& progress) {
    Numbers numbers("make bench-large PART=large-strain");
    const LargeStrain measured = large_strain(build / "large", progress);
    numbers.add("large-strain", measured.limits);
    numbers.add("large-strain-curve", measured.curve);
    return numbers;
}

Numbers compare_elements(const fs::path& known, const fs::path& build, Progress& progress) {
    Numbers numbers("make bench-large PART=elements");
    const ElementTables measured = measure_elements(known, build, progress);
    numbers.add("elements", measured.worth);
    numbers.add("locking", measured.locking);
    return numbers;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Measures error against the body, and what it costs, by configuration.", "haptable-bench-error");
    fs::path build = "build/error", out, known = "docs/numbers.json";
    bool truth = false, answers = false, strain = false, elements = false, elsewhere = false, quick = false,
         quiet = false;
    app.option("--build", build, "folder for tables").show_default();
    app.option("--numbers", known, "where the truth is kept").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    app.flag("--truth", truth, "solve for the body itself instead: minutes, kept in docs/numbers.json");
    app.flag("--known-answers", answers, "compare with closed forms and with CalculiX instead");
    app.flag("--large-strain", strain, "compare with CalculiX at large strain instead: many minutes, kept there too");
    app.flag("--elements", elements, "compare the elements with the body itself instead: minutes, kept there too");
    app.flag("--elsewhere", elsewhere, "the same of other fingers, places and bodies instead: minutes, kept there too");
    app.flag("--quick", quick, "coarse meshes only");
    app.flag("--quiet", quiet, "no progress bar");
    return run_program(app, argc, argv, [&] {
        Progress progress(quiet);
        Numbers numbers("make bench");
        if (truth)
            numbers = solve_truths(build, progress);
        else if (answers)
            numbers = compare_with_known(build, progress);
        else if (strain)
            numbers = measure_large_strain(build, progress);
        else if (elements)
            numbers = compare_elements(known, build, progress);
        else if (elsewhere)
            numbers = compare_elsewhere(build, progress);
        else
            measure_all(known, quick, build, progress, numbers);
        progress.clear();
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
