// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/specimen.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "host/base/error.hpp"
#include "host/bench/cube_scene.hpp"
#include "host/bench/error/bricks.hpp"
#include "host/bench/error/quadratic_tets.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/surface.hpp"
#include "host/mesh/write_tetgen.hpp"
#include "host/precompute/body.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr std::size_t kPlaces = 12;

// ---- scenes --------------------------------------------------------------------------------------------------------

/// The paper's cube of 30 mm; its top may be touched.
Meshed cube(int nodes_per_side, double poisson) {
    Scene scene = cube_scene(nodes_per_side, poisson);
    scene.touch.push_back({std::array<double, 6>{-1, -1, 0.03 - 1e-9, 1, 1, 1}, "", 1});
    scene.tables.columns = ColumnRows::kNone;
    const Fineness fineness = nodes_per_side > 17  ? Fineness::kFine
                              : nodes_per_side > 9 ? Fineness::kMiddle
                                                   : Fineness::kCoarse;
    return {fmt::format("{} a side", nodes_per_side), scene, fineness};
}

Specimen cubes(double poisson, bool quick) {
    Specimen specimen{fmt::format("cube, nu {}", poisson), 0.005, {}};
    for (int nodes : {5, 9, 13, 17, 25, 33})
        if (!quick || nodes <= 13) specimen.meshes.push_back(cube(nodes, poisson));
    return specimen;
}

/// A scene of meshes/ as it is, and with its tetrahedra in eight.
Specimen from_file(const std::string& name, double finger_radius_m, bool quick, const fs::path& build) {
    Scene scene = read_scene("meshes/" + name + ".toml");
    scene.tables.columns = ColumnRows::kNone;
    const TetMesh mesh = make_mesh(scene.mesh);
    Specimen specimen{
        name, finger_radius_m, {{thousands(mesh.position_m.size()) + " nodes", scene, Fineness::kMiddle}}};
    if (quick) return specimen;
    const TetMesh fine = in_eight(mesh);
    scene.name += "-in-eight";
    std::vector<Vector3d> in_file = fine.position_m;
    for (Vector3d& x : in_file) x += fine.origin_m;
    scene.mesh.file = write_tetgen(in_file, fine.tet, build / scene.name);
    scene.mesh.scale_m = 1.0;
    specimen.meshes.push_back({thousands(fine.position_m.size()) + " nodes", scene, Fineness::kFine});
    return specimen;
}

// ---- truth of a cube -----------------------------------------------------------------------------------------------

std::vector<Eigen::Matrix3d> cube_stiffness(const Material& material, const std::vector<Footprint>& footprints,
                                            int inner, int outer) {
    const auto across = graded_planes(0.0, 0.03, 0.006, 0.024, inner, outer);
    const Box box{{across, across, graded_planes(0.0, 0.03, 0.021, 0.03, inner / 2, outer + 1)}, false};
    auto c = brick_compliances(box, Lame::from_young(material.young_pa, material.poisson), footprints);
    for (auto& one : c) one = one.inverse().eval();
    return c;
}

// ---- truth of a mesh -----------------------------------------------------------------------------------------------

std::vector<Eigen::Matrix3d> mesh_stiffness(const Scene& scene, const TetMesh& mesh,
                                            const std::vector<Footprint>& footprints) {
    const QuadraticMesh quadratic = make_quadratic(scene, mesh);
    const Factor factor(assemble_quadratic(quadratic, scene.material));
    std::vector<LoadShares> loads;
    for (const Footprint& footprint : footprints) loads.push_back(shares_on(quadratic, footprint));
    auto c = compliances(factor, loads, quadratic.unknown);
    for (auto& one : c) one = one.inverse().eval();
    return c;
}

bool is_cube(const Specimen& specimen) { return !specimen.meshes.front().scene.mesh.generate.empty(); }

}  // namespace

std::vector<Specimen> specimens(bool quick, const fs::path& build) {
    return {cubes(0.3, quick), cubes(0.49, quick), from_file("mouse", 0.010, quick, build),
            from_file("liver", 0.015, quick, build)};
}

std::vector<Place> spiral(const Vector3d& middle_m, double width_m, std::size_t count) {
    std::vector<Place> places;
    for (std::size_t i = 0; i < count; ++i) {
        const double r = 0.5 * width_m * std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(count));
        const double angle = 2.399963 * static_cast<double>(i);  // the golden angle
        places.push_back({middle_m + r * Vector3d(std::cos(angle), std::sin(angle), 0.0), Vector3d::UnitZ()});
    }
    return places;
}

std::vector<Place> mesh_places(const Scene& scene, const TetMesh& mesh, double radius_m) {
    const QuadraticMesh marked = make_quadratic(scene, mesh);
    const auto at = [&](std::int32_t node) { return marked.position_m[static_cast<std::size_t>(node)]; };
    const auto normal = [&](const std::array<std::int32_t, 6>& t) {
        return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalized().eval();
    };
    const auto is_good = [&](const Place& place) {
        for (const auto& t : marked.triangle)
            for (std::size_t c = 0; c < 6; ++c)
                if ((at(t[c]) - place.on_m).norm() < 1.2 * radius_m &&
                    (normal(t).dot(place.outward) < 0.7 || marked.unknown[static_cast<std::size_t>(t[c])] < 0))
                    return false;
        return true;
    };
    std::mt19937 random(3);
    std::vector<Place> places;
    for (int attempt = 0; places.size() < kPlaces && attempt < 10000; ++attempt) {
        const auto& t = marked.triangle[random() % marked.triangle.size()];
        Vector3d alpha;
        for (double& a : alpha) a = 1.0 + static_cast<double>(random() % 1000);
        alpha /= alpha.sum();
        const Place place{alpha[0] * at(t[0]) + alpha[1] * at(t[1]) + alpha[2] * at(t[2]), normal(t)};
        if (is_good(place)) places.push_back(place);
    }
    if (places.size() < kPlaces) throw Error(scene.name + ": no places for the bench to press");
    return places;
}

std::vector<Place> places_of(const Specimen& specimen) {
    const Scene& scene = specimen.meshes.front().scene;
    return is_cube(specimen) ? spiral({0.015, 0.015, 0.03}, 0.008, kPlaces)
                             : mesh_places(scene, make_mesh(scene.mesh), specimen.finger_radius_m);
}

std::vector<Truth> solve_truth(const Specimen& specimen, bool coarser_alone) {
    const Scene& scene = specimen.meshes.front().scene;
    const TetMesh mesh = make_mesh(scene.mesh);
    const std::vector<Place> places = places_of(specimen);
    std::vector<Footprint> footprints;
    for (const Place& place : places) footprints.push_back({place.on_m, specimen.finger_radius_m});
    const auto coarse =
        is_cube(specimen) ? cube_stiffness(scene.material, footprints, 10, 3) : mesh_stiffness(scene, mesh, footprints);
    const auto fine = coarser_alone       ? coarse
                      : is_cube(specimen) ? cube_stiffness(scene.material, footprints, 14, 4)
                                          : mesh_stiffness(scene, in_eight(mesh), footprints);
    std::vector<Truth> truths;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Vector3d& n = places[i].outward;
        truths.push_back({places[i], fine[i], n.dot(coarse[i] * n) / n.dot(fine[i] * n) - 1.0});
    }
    return truths;
}

NumberTable truth_table(const std::vector<std::pair<std::string, std::vector<Truth>>>& truths) {
    NumberTable table{{"body", "place", "stiffness along the normal", "on the coarser mesh"}, {}};
    for (const auto& [name, of_body] : truths)
        for (const Truth& truth : of_body) {
            const Vector3d &x = truth.place.on_m, &n = truth.place.outward;
            const Eigen::Matrix3d& s = truth.stiffness_n_per_m;
            table.rows.push_back({name,
                                  Number{{x[0], x[1], x[2], n[0], n[1], n[2]},
                                         fmt::format("{:.1f}, {:.1f}, {:.1f} mm", 1e3 * x[0], 1e3 * x[1], 1e3 * x[2])},
                                  Number{{s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)},
                                         fmt::format("{:.1f} N/m", n.dot(s * n))},
                                  number(truth.coarser, fmt::format("{:+.2f} %", 100.0 * truth.coarser))});
        }
    return table;
}

std::vector<Truth> truth_of(const nlohmann::ordered_json& topics, const std::string& specimen) {
    std::vector<Truth> truths;
    if (topics.contains("truth"))
        for (const auto& row : topics.at("truth").at("rows")) {
            if (row.at(0) != specimen) continue;
            const auto x = row.at(1).at("value").get<std::vector<double>>();
            const auto s = row.at(2).at("value").get<std::vector<double>>();
            Truth truth{{{x.at(0), x.at(1), x.at(2)}, {x.at(3), x.at(4), x.at(5)}}, {}, row.at(3).at("value")};
            truth.stiffness_n_per_m << s.at(0), s.at(3), s.at(5), s.at(3), s.at(1), s.at(4), s.at(5), s.at(4), s.at(2);
            truths.push_back(truth);
        }
    if (truths.empty())
        throw Error(specimen + ": docs/numbers.json has no truth of it; run haptable-bench-error --truth");
    return truths;
}

}  // namespace haptable
