// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/elsewhere.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <functional>

#include "host/bench/cube_scene.hpp"
#include "host/bench/error/bricks.hpp"
#include "host/bench/error/masked.hpp"
#include "host/bench/error/quadratic_tets.hpp"
#include "host/hard/cells.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/write_tetgen.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array kRatios{0.3, 0.49, 0.4999};
constexpr std::array kElements{Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};

/// Fingers of one size around one place: a row of the table.
struct Touch {
    std::string place;
    double radius_m;
    std::vector<Place> places;
};

/// n . S n of every finger, on a fine mesh and on a coarser one.
struct Solved {
    std::vector<double> fine, coarse;
};

/// A body, the meshes that are judged on it, and how it is solved without them.
struct Elsewhere {
    std::string name;
    std::vector<Touch> touches;
    std::function<Scene(Element)> scene;
    std::function<Solved(double poisson, const std::vector<Finger>&)> solve;
};

std::vector<Finger> fingers_of(const std::vector<Touch>& touches) {
    std::vector<Finger> fingers;
    for (const Touch& touch : touches)
        for (const Place& place : touch.places) fingers.push_back({touch.radius_m, place});
    return fingers;
}

std::vector<Footprint> footprints_of(const std::vector<Finger>& fingers) {
    std::vector<Footprint> footprints;
    for (const Finger& finger : fingers) footprints.push_back({finger.place.on_m, finger.radius_m});
    return footprints;
}

std::vector<double> normals_of(const std::vector<Matrix3d>& compliance, const std::vector<Finger>& fingers) {
    std::vector<double> normal;
    for (std::size_t i = 0; i < fingers.size(); ++i) {
        const Vector3d& n = fingers[i].place.outward;
        normal.push_back(n.dot(compliance[i].inverse() * n));
    }
    return normal;
}

Touch around(const std::string& place, double radius_m, const Vector3d& middle_m) {
    constexpr double kWidth_m = 0.002;
    return {place, radius_m, spiral(middle_m, kWidth_m, 5)};
}

Lame soft(double poisson) { return Lame::from_young(1e4, poisson); }

// ---- boxes, by bricks ----------------------------------------------------------------------------------------------

/// `finest`: cells of the fine part of the grid along x and y.
Solved solve_box(const std::function<Box(int finest)>& grid, int finest, double poisson,
                 const std::vector<Finger>& fingers) {
    const std::vector<Footprint> footprints = footprints_of(fingers);
    const auto on = [&](int cells) {
        return normals_of(brick_compliances(grid(cells), soft(poisson), footprints), fingers);
    };
    return {on(finest), on(finest * 3 / 4)};
}

/// 30 mm, 13 nodes a side, of quadratic tetrahedra 9 corners: the paper's, its middle, 8.5 mm from an edge and from
/// two.
Elsewhere cube() {
    std::vector<Touch> touches;
    for (const double radius_m : {0.0035, 0.005, 0.007})
        for (const auto& [name, x, y] : {std::tuple{"middle", 0.015, 0.015},
                                         {"8.5 mm from an edge", 0.015, 0.0085},
                                         {"8.5 mm from two edges", 0.0085, 0.0085}})
            touches.push_back(around(name, radius_m, {x, y, 0.03}));
    const auto scene = [](Element element) {
        Scene top = cube_scene(element == Element::kQuadratic ? 9 : 13, 0.3);
        top.touch.push_back({std::array<double, 6>{-1, -1, 0.03 - 1e-9, 1, 1, 1}, "", 1});
        return top;
    };
    const auto grid = [](int finest) {
        const auto across = graded_planes(0.0, 0.03, 0.0, 0.024, finest, 2);
        return Box{{across, across, graded_planes(0.0, 0.03, 0.021, 0.03, finest / 3, finest / 4)}, false};
    };
    return {"cube, 13 a side (quadratic: 9)", touches, scene,
            [=](double poisson, const std::vector<Finger>& fingers) { return solve_box(grid, 16, poisson, fingers); }};
}

Scene scene_of(const std::string& name, const TetMesh& mesh, double held_below_m, const fs::path& build) {
    Scene scene;
    scene.name = name;
    scene.file = name + ".toml";
    scene.material = {1e4, 0.3};
    scene.mesh.file = write_tetgen(mesh.position_m, mesh.tet, build / name);
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, held_below_m}, "", 1});
    return scene;
}

/// 60 mm square, 6 mm thick, glued to its bed, in cells of 2.5 x 2.5 x 2 mm of six tetrahedra each.
Elsewhere plate(const fs::path& build) {
    constexpr double kWidth = 0.06, kThick = 0.006;
    const TetMesh mesh =
        mesh_of({{24, 24, 3},
                 [=](double a, double b, double c) { return Vector3d(kWidth * a, kWidth * b, kThick * c); },
                 [](int, int, int) { return true; },
                 {}});
    Scene glued = scene_of("plate", mesh, 1e-9, build);
    glued.touch.push_back({std::array<double, 6>{-1, -1, kThick - 1e-9, 1, 1, 1}, "", 1});
    std::vector<Touch> touches;
    for (const double radius_m : {0.005, 0.007})
        for (const auto& [name, y] : {std::pair{"middle", 0.03}, {"8.5 mm from an edge", 0.0085}})
            touches.push_back(around(name, radius_m, {0.03, y, kThick}));
    const auto grid = [=](int finest) {
        return Box{{graded_planes(0.0, kWidth, 0.021, 0.039, finest / 2, finest / 6),
                    graded_planes(0.0, kWidth, 0.0, 0.039, finest, finest / 6),
                    graded_planes(0.0, kThick, 0.0, kThick, finest / 5, 0)},
                   false};
    };
    return {"plate 60 x 60 x 6 mm, cells of 2.5 mm", touches, [=](Element) { return glued; },
            [=](double poisson, const std::vector<Finger>& fingers) { return solve_box(grid, 20, poisson, fingers); }};
}

// ---- other bodies, by tetrahedra -----------------------------------------------------------------------------------

/// With one pressure a tetrahedron, on the mesh in eight and on the mesh itself.
Solved solve_mesh(Scene scene, double poisson, const std::vector<Finger>& fingers) {
    scene.material.poisson = poisson;
    const TetMesh mesh = make_mesh(scene.mesh);
    const auto on = [&](const TetMesh& tetrahedra) {
        const QuadraticMesh quadratic = make_quadratic(scene, tetrahedra);
        const Factor factor(assemble_quadratic(quadratic, scene.material, Volume::kOnAverage));
        std::vector<LoadShares> loads;
        for (const Footprint& footprint : footprints_of(fingers)) loads.push_back(shares_on(quadratic, footprint));
        return normals_of(compliances(factor, loads, quadratic.unknown), fingers);
    };
    return {on(in_eight(mesh)), on(mesh)};
}

Elsewhere on_mesh(const std::string& name, const Scene& scene, std::array<double, 2> radius_m) {
    const std::vector<Place> places = mesh_places(scene, make_mesh(scene.mesh), std::max(radius_m[0], radius_m[1]));
    std::vector<Touch> touches;
    for (const double radius : radius_m) touches.push_back({fmt::format("{} places", places.size()), radius, places});
    return {name, touches, [=](Element) { return scene; },
            [=](double poisson, const std::vector<Finger>& fingers) { return solve_mesh(scene, poisson, fingers); }};
}

/// 30 mm across, a grid of eight cells a side bent into shape, held up to 6 mm.
Elsewhere ball(const fs::path& build) {
    constexpr double kRadius = 0.015;
    const auto at = [](double a, double b, double c) {
        const Vector3d x = 2.0 * Vector3d(a, b, c) - Vector3d::Ones();
        return Vector3d(x.isZero() ? x : Vector3d(kRadius * x.cwiseAbs().maxCoeff() * x.normalized()));
    };
    const TetMesh mesh = mesh_of({{8, 8, 8}, at, [](int, int, int) { return true; }, {}});
    return on_mesh(fmt::format("ball of 30 mm, {} nodes", thousands(mesh.position_m.size())),
                   scene_of("ball", mesh, -0.009, build), {0.005, 0.007});
}

Elsewhere mouse() {
    Scene scene = read_scene("meshes/mouse.toml");
    return on_mesh(fmt::format("mouse, {} nodes", thousands(make_mesh(scene.mesh).position_m.size())), scene,
                   {0.007, 0.010});
}

// ---- the table -----------------------------------------------------------------------------------------------------

Number percent(double share) { return number(share, fmt::format("{:+.1f} %", 100.0 * share)); }

double mean(std::span<const double> values) {
    double sum = 0.0;
    for (const double value : values) sum += value / static_cast<double>(values.size());
    return sum;
}

/// A row for every touch and ratio.
void add_rows(const Elsewhere& body, Progress& progress, NumberTable& table) {
    const std::vector<Finger> fingers = fingers_of(body.touches);
    std::vector<Masked> masked;
    for (const Element element : kElements) masked.emplace_back(body.scene(element), element, fingers);
    for (const double ratio : kRatios) {
        progress.stage(fmt::format("{}, Poisson's ratio {}", body.name, ratio));
        const Solved solved = body.solve(ratio, fingers);
        std::vector<std::vector<double>> felt;
        for (Masked& one : masked) felt.push_back(one.at(ratio).normal_n_per_m);
        std::size_t first = 0;
        for (const Touch& touch : body.touches) {
            const auto part = [&](const std::vector<double>& all) {
                return std::span<const double>(all).subspan(first, touch.places.size());
            };
            const double itself = mean(part(solved.fine));
            auto& row = table.rows.emplace_back(
                std::vector<Cell>{body.name, fmt::format("{:g} mm", 1e3 * touch.radius_m), touch.place,
                                  fmt::format("{}", ratio), number(itself, fmt::format("{:.4g} N/m", itself)),
                                  percent(excess(part(solved.coarse), part(solved.fine)))});
            for (const auto& one : felt) row.push_back(percent(excess(part(one), part(solved.fine))));
            first += touch.places.size();
        }
    }
}

}  // namespace

NumberTable measure_elsewhere(const fs::path& build, Progress& progress) {
    NumberTable table{{"body", "finger's radius", "where", "Poisson's ratio", "the body itself", "on a coarser mesh"},
                      {}};
    for (const Element element : kElements) table.columns.emplace_back(word(element));
    for (const Elsewhere& body : {cube(), plate(build), ball(build), mouse()}) add_rows(body, progress, table);
    return table;
}

}  // namespace haptable
