// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/hard/cases.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/hard/cells.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/write_tetgen.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using IsHeld = std::function<bool(const Vector3d&)>;

constexpr Material kSoft{1e4, 0.3};

/// A scene of a mesh, its nodes with `held` fixed, written below `folder`.
Scene scene_of(const std::string& name, const TetMesh& mesh, const IsHeld& held, const fs::path& folder) {
    Scene scene;
    scene.file = name + ".toml";
    scene.name = name;
    scene.mesh.file = write_tetgen(mesh.position_m, mesh.tet, folder / name);
    scene.material = kSoft;
    Eigen::AlignedBox3d box;
    for (const Vector3d& x : mesh.position_m) box.extend(x);
    // More than the coordinates' rounding, less than the thinnest sliver.
    const double e = 1e-9 * box.diagonal().norm() + 0x1p-50 * box.center().norm();
    for (const Vector3d& x : mesh.position_m)
        if (held(x))
            scene.fixed.push_back(
                {std::array{x.x() - e, x.y() - e, x.z() - e, x.x() + e, x.y() + e, x.z() + e}, "", 1});
    return scene;
}

Cells bar(std::array<int, 3> count, const Vector3d& side_m, const Eigen::Matrix3d& turned = Eigen::Matrix3d::Identity(),
          const Vector3d& at_m = Vector3d::Zero()) {
    return {
        count,
        [=](double a, double b, double c) { return Vector3d(at_m + turned * side_m.cwiseProduct(Vector3d(a, b, c))); },
        [](int, int, int) { return true; }, [](const Vector3d&) { return false; }};
}

/// About no axis of the coordinates: entries of blocks in float then are of the stiffest direction's size.
Eigen::Matrix3d askew() { return Eigen::AngleAxisd(0.7, Vector3d(0.36, 0.48, 0.8)).toRotationMatrix(); }

HardCase needle(const std::string& name, double slenderness, bool turned, const fs::path& folder) {
    const Vector3d side(0.1 / slenderness, 0.1 / slenderness, 0.1);
    const Eigen::Matrix3d turn = turned ? askew() : Eigen::Matrix3d::Identity();
    return {name,
            scene_of(
                turned ? "needle-askew" : "needle", mesh_of(bar({1, 1, 30}, side, turn)),
                [=](const Vector3d& x) { return (turn.transpose() * x).z() < 1e-6; }, folder),
            ""};
}

HardCase steel(HardCase hard) {
    hard.scene.material.young_pa = 200e9;
    return hard;
}

HardCase plate(const std::string& name, bool turned, const fs::path& folder) {
    const Vector3d side(0.1, 0.1, 0.001);
    const Eigen::Matrix3d turn = turned ? askew() : Eigen::Matrix3d::Identity();
    return {name,
            scene_of(
                turned ? "plate-askew" : "plate", mesh_of(bar({6, 6, 1}, side, turn)),
                [=](const Vector3d& x) {
                    const Vector3d y = turn.transpose() * x;
                    return std::min({y.x(), y.y(), 0.1 - y.x(), 0.1 - y.y()}) < 1e-6;
                },
                folder),
            ""};
}

HardCase cube(const std::string& name, const Scene& scene) { return {name, scene, ""}; }

Scene two_materials(bool stiff_above) {
    Scene scene = hard_cube(0.03, {stiff_above ? 1e3 : 1e9, 0.3});
    scene.regions.push_back({{std::array{-1.0, -1.0, 0.015, 1.0, 1.0, 1.0}, "", 1}, {stiff_above ? 1e9 : 1e3, 0.3}});
    return scene;
}

HardCase held(const std::string& name, const std::string& file, const IsHeld& held, const fs::path& folder,
              const std::string& refusal = "") {
    return {name, scene_of(file, make_cube(5, 0.03), held, folder), refusal};
}

HardCase far(const std::string& name, double diagonals, const fs::path& folder) {
    const double side = 0.03;
    const Vector3d at = Vector3d(0.6, -0.64, 0.48) * (diagonals * side * std::sqrt(3.0));
    return {name,
            scene_of(
                fmt::format("far{:.0f}", diagonals),
                mesh_of(bar({4, 4, 4}, Vector3d::Constant(side), Eigen::Matrix3d::Identity(), at)),
                [=](const Vector3d& x) { return x.z() < at.z() + 1e-3 * side; }, folder),
            ""};
}

bool is_corner(const Vector3d& x, double a, double b) { return (x - Vector3d(a, b, 0.0)).norm() < 1e-6; }

}  // namespace

Scene hard_cube(double side_m, const Material& material, Element element) {
    Scene scene;
    scene.file = "hard-cube.toml";
    scene.name = "hard-cube";
    scene.mesh.generate = "cube";
    scene.mesh.side_m = side_m;
    scene.mesh.element = element;
    scene.material = material;
    scene.fixed.push_back({std::array<double, 6>{-1e4, -1e4, -1e4, 1e4, 1e4, 1e-9 * side_m}, "", 1});
    return scene;
}

std::vector<HardCase> hard_cases(const fs::path& folder) {
    const IsHeld below = [](const Vector3d& x) { return x.z() < 1e-9; };
    const IsHeld three = [](const Vector3d& x) {
        return is_corner(x, 0, 0) || is_corner(x, 0.03, 0) || is_corner(x, 0, 0.03);
    };
    const IsHeld all_but_one = [](const Vector3d& x) { return (x - Vector3d::Constant(0.03)).norm() > 1e-6; };
    const IsHeld one = [](const Vector3d& x) { return is_corner(x, 0, 0); };
    const IsHeld low = [](const Vector3d& x) { return x.z() < -0.012; };
    std::vector<HardCase> cases{
        cube("Poisson's ratio 0", hard_cube(0.03, {1e4, 0.0})),
        cube("Poisson's ratio 0, average nodal pressure", hard_cube(0.03, {1e4, 0.0}, Element::kAverageNodalPressure)),
        cube("Poisson's ratio 0.4999", hard_cube(0.03, {1e4, 0.4999})),
        cube("Poisson's ratio 0.4999, average nodal pressure",
             hard_cube(0.03, {1e4, 0.4999}, Element::kAverageNodalPressure)),
        cube("1 Pa", hard_cube(0.03, {1.0, 0.3})),
        cube("200 GPa", hard_cube(0.03, {200e9, 0.3})),
        cube("1e9 Pa over 1e3 Pa", two_materials(true)),
        cube("1e3 Pa over 1e9 Pa", two_materials(false)),
        {"slivers of radius ratio 1e-6", scene_of("slivers", sliver_mesh(4, 1e-6), below, folder), ""},
        needle("needle 1:100", 100, false, folder),
        needle("needle 1:100, askew", 100, true, folder),
        steel(needle("needle 1:100 of steel, askew", 100, true, folder)),
        plate("plate 1:100", false, folder),
        plate("plate 1:100, askew", true, folder),
        cube("1 um", hard_cube(1e-6, kSoft)),
        cube("100 m", hard_cube(100.0, kSoft)),
        held("held at three nodes", "three", three, folder),
        held("held at all nodes but one", "but-one", all_but_one, folder),
        held("held at one node", "one", one, folder, "under-constrained"),
        held(
            "free", "free", [](const Vector3d&) { return false; }, folder, "under-constrained"),
        {"80 tetrahedra at a node", scene_of("hub", hub_mesh(), low, folder), ""},
        {"32 patches at a node", scene_of("cone32", cone_mesh(32), below, folder), ""},
        {"60 patches at a node", scene_of("cone60", cone_mesh(60), below, folder), "60 touchable patches meet"},
        far("900 diagonals from the origin", 900, folder),
        far("1e6 diagonals from the origin", 1e6, folder),
    };
    for (HardCase& each : cases) {
        each.scene.tables.columns = ColumnRows::kNone;
        each.scene.device.max_force_n = 1e14;  // no force is cut: it is the body's that is judged
    }
    return cases;
}

HardCase hard_case(const std::string& name, const fs::path& folder) {
    for (HardCase& each : hard_cases(folder))
        if (each.name == name) return each;
    throw Error(fmt::format("there is no hard case \"{}\"", name));
}

}  // namespace haptable
