// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/elements.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <map>
#include <nlohmann/json.hpp>

#include "host/base/process_cost.hpp"
#include "host/bench/error/footprint.hpp"
#include "host/bench/error/mask_load.hpp"
#include "host/bench/error/specimen.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/locking.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;

constexpr double kNotKept = 0.4999;
constexpr std::array kRatios{0.3, 0.49, kNotKept};
constexpr std::array kLockingRatios{0.3, 0.45, 0.49, 0.499};

/// A body of one element with the masks of a finger at places; Poisson's ratio comes later.
class Masked {
public:
    Masked(Scene scene, Element element, double radius_m, std::span<const Place> places) : scene_(std::move(scene)) {
        scene_.mesh.element = element;
        scene_.contact.mask_radius_m = radius_m;
        body_ = make_body(scene_, make_mesh(scene_.mesh));
        Workers workers(1);
        Progress quiet(true);
        const Masks masks =
            make_masks(body_.mesh.position_m, body_.touch_patch, radius_m, workers, quiet, body_.touch_quarter);
        for (const Place& place : places) {
            const auto [patch, alpha] = locate(body_.mesh.position_m, body_.touch_patch, place.on_m);
            load_.push_back(mask_load(masks, patch, alpha));
            outward_.push_back(place.outward);
        }
    }

    struct Felt {
        std::vector<double> normal_n_per_m;  ///< n . S n at the places
        double cpu_s = 0.0;                  ///< of the factor and the blocks L_ii, one thread
    };
    Felt at(double poisson) {
        scene_.material.poisson = poisson;
        const Stiffness k = assemble_free(scene_, body_);
        std::vector<NodePair> blocks;
        for (std::int32_t node : body_.touch_node) {
            const std::int32_t i = body_.unknown[static_cast<std::size_t>(node)];
            blocks.push_back({i, i});
        }
        Felt felt;
        Progress quiet(true);
        const double begin = process_cost().cpu_s;
        CholmodInverse inverse(1);
        inverse.analyse(k, {{blocks}, {}, {}, false, 3});
        inverse.factorize(k, quiet);
        inverse.blocks(blocks, Precision::kDouble, quiet);
        felt.cpu_s = process_cost().cpu_s - begin;
        const std::vector<Matrix3d> c = compliances(inverse, load_, body_.unknown);
        for (std::size_t i = 0; i < c.size(); ++i)
            felt.normal_n_per_m.push_back(outward_[i].dot(c[i].inverse() * outward_[i]));
        return felt;
    }
    double expected_locking_at(double poisson) {
        scene_.material.poisson = poisson;
        return expected_locking(scene_, body_.mesh);
    }
    std::size_t nodes() const { return body_.mesh.position_m.size(); }

private:
    Scene scene_;
    Body body_;
    std::vector<LoadShares> load_;
    std::vector<Eigen::Vector3d> outward_;
};

/// The mean over the places of one over the other, less 1.
double excess(const std::vector<double>& felt, const std::vector<double>& body) {
    double sum = 0.0;
    for (std::size_t i = 0; i < felt.size(); ++i) sum += felt[i] / body[i] - 1.0;
    return sum / static_cast<double>(felt.size());
}

Number percent(double share) { return number(share, fmt::format("{:+.1f} %", 100.0 * share)); }

std::vector<double> normals_of(const std::vector<Truth>& truths) {
    std::vector<double> normal;
    for (const Truth& t : truths) normal.push_back(t.place.outward.dot(t.stiffness_n_per_m * t.place.outward));
    return normal;
}

/// Of the ratio that docs/numbers.json has no truth of, on the coarser mesh.
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
            if (meshed.fineness == Fineness::kFine || meshed.name == (is_quadratic ? "17 a side" : "5 a side"))
                continue;
            progress.stage(fmt::format("elements: {}, {}", word(element), meshed.name));
            Masked masked(meshed.scene, element, cube.finger_radius_m, places);
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
    NumberTable table{{"body, mesh", "finger's radius", "Poisson's ratio", "expected", "measured"}, {}};
    for (const Specimen& specimen : all) {
        const std::vector<Place> places = places_of(specimen);
        const std::string body = specimen.name.substr(0, specimen.name.find(','));
        for (const Meshed& meshed : specimen.meshes) {
            if (meshed.fineness == Fineness::kFine || meshed.name == "5 a side" || meshed.name == "17 a side") continue;
            progress.stage(fmt::format("locking: {}, {}", body, meshed.name));
            Masked linear(meshed.scene, Element::kLinear, specimen.finger_radius_m, places);
            Masked quadratic(meshed.scene, Element::kQuadratic, specimen.finger_radius_m, places);
            for (const double poisson : kLockingRatios) {
                const double off = excess(linear.at(poisson).normal_n_per_m, quadratic.at(poisson).normal_n_per_m);
                const double expected = linear.expected_locking_at(poisson);
                table.rows.push_back(
                    {fmt::format("{}, {}", body, meshed.name),
                     number(specimen.finger_radius_m, fmt::format("{:g} mm", 1e3 * specimen.finger_radius_m)),
                     number(poisson, fmt::format("{}", poisson)), expected > 0.0 ? Cell(percent(expected)) : Cell(""),
                     percent(off)});
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
