// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/elements.hpp"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>

#include "host/bench/error/masked.hpp"
#include "host/bench/error/specimen.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr double kNotKept = 0.4999;
constexpr std::array kRatios{0.3, 0.49, kNotKept};
constexpr std::array kLockingRatios{0.3, 0.45, 0.49, 0.499, 0.4999};

Number percent(double share) { return number(share, fmt::format("{:+.1f} %", 100.0 * share)); }

std::vector<double> normals_of(const std::vector<Truth>& truths) {
    std::vector<double> normal;
    for (const Truth& t : truths) normal.push_back(t.place.outward.dot(t.stiffness_n_per_m * t.place.outward));
    return normal;
}

/// The truth at the ratio that docs/numbers.json has no truth of, on the coarser mesh.
std::vector<Truth> solve_nearly_incompressible(Specimen cube, Progress& progress) {
    progress.stage(fmt::format("the body itself: cube, nu {}", kNotKept));
    for (Meshed& meshed : cube.meshes) meshed.scene.material.poisson = kNotKept;
    return solve_truth(cube, true);
}

NumberTable measure_worth(const Specimen& cube, const nlohmann::ordered_json& known, Progress& progress) {
    const std::vector<Place> places = places_of(cube);
    std::vector<std::vector<double>> body;
    NumberTable table{{"element, nodes a side", "nodes"}, {}};
    for (const double poisson : kRatios) {
        body.push_back(normals_of(poisson == kNotKept ? solve_nearly_incompressible(cube, progress)
                                                      : truth_of(known, fmt::format("cube, nu {}", poisson))));
        table.columns.push_back(fmt::format("ratio {}", poisson));
    }
    table.columns.insert(table.columns.end(), {"factor and blocks, 0.49", "over linear"});
    std::map<std::string, double> linear_s;
    for (const Element element : {Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic})
        for (const Meshed& meshed : cube.meshes) {
            const bool is_quadratic = element == Element::kQuadratic;
            const bool is_fine = meshed.fineness == Fineness::kFine || meshed.name == "17 a side";
            if (is_quadratic ? is_fine : meshed.name == "5 a side" || meshed.name == "33 a side") continue;
            progress.stage(fmt::format("elements: {}, {}", word(element), meshed.name));
            Masked masked(meshed.scene, element, fingers_at(places, cube.finger_radius_m));
            auto& row = table.rows.emplace_back(
                std::vector<Cell>{fmt::format("{}, {}", word(element), meshed.name), thousands(masked.nodes())});
            double cpu_s = 0.0;
            for (std::size_t i = 0; i < kRatios.size(); ++i) {
                const Masked::Felt felt = masked.at(kRatios[i]);
                row.push_back(percent(excess(felt.normal_n_per_m, body[i])));
                if (kRatios[i] == 0.49) cpu_s = felt.cpu_s;
            }
            if (element == Element::kLinear) linear_s[meshed.name] = cpu_s;
            row.push_back(seconds(cpu_s));
            const auto linear = linear_s.find(meshed.name);
            row.push_back(linear == linear_s.end()
                              ? Cell("")
                              : number(cpu_s / linear->second, fmt::format("{:.1f}", cpu_s / linear->second)));
        }
    return table;
}

NumberTable measure_locking(const std::vector<Specimen>& all, Progress& progress) {
    NumberTable table{{"body, mesh", "finger's radius", "Poisson's ratio", "foreseen (--check)", "told by a run",
                       "over quadratic, the same mesh"},
                      {}};
    for (const Specimen& specimen : all) {
        const std::vector<Place> places = places_of(specimen);
        const std::string body = specimen.name.substr(0, specimen.name.find(','));
        for (const Meshed& meshed : specimen.meshes) {
            if (meshed.fineness == Fineness::kFine || meshed.name == "5 a side" || meshed.name == "17 a side") continue;
            progress.stage(fmt::format("locking: {}, {}", body, meshed.name));
            const std::vector<Finger> fingers = fingers_at(places, specimen.finger_radius_m);
            Masked linear(meshed.scene, Element::kLinear, fingers);
            Masked quadratic(meshed.scene, Element::kQuadratic, fingers);
            for (const double poisson : kLockingRatios) {
                const Masked::Felt felt = linear.at(poisson);
                const double off = excess(felt.normal_n_per_m, quadratic.at(poisson).normal_n_per_m);
                const bool told = felt.told.places > 0;
                table.rows.push_back(
                    {fmt::format("{}, {}", body, meshed.name),
                     number(specimen.finger_radius_m, fmt::format("{:g} mm", 1e3 * specimen.finger_radius_m)),
                     fmt::format("{}", poisson), told ? Cell(percent(linear.foreseen_at(poisson))) : Cell(""),
                     told ? Cell(percent(felt.told.excess)) : Cell(""), percent(off)});
            }
        }
    }
    return table;
}

}  // namespace

ElementTables measure_elements(const fs::path& known, const fs::path& build, Progress& progress) {
    std::vector<Specimen> all = specimens(false, build);
    std::erase_if(all, [](const Specimen& s) { return s.name == "cube, nu 0.49"; });  // the other one's mesh
    NumberTable locking = measure_locking(all, progress);
    return {measure_worth(all.front(), read_numbers(known), progress), std::move(locking)};
}

}  // namespace haptable
