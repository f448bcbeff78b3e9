// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/host/view/cube_tables.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/tables/npy.hpp"
#include "tests/sealed.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct CubeSurface {
    std::vector<Vector3d> position;
    std::vector<std::int32_t> patch;  // three nodes each
};

/// Six faces of (n - 1)^2 squares, each split into two triangles; all nodes of the lattice are kept, as in a mesh.
CubeSurface make_surface(const CubeOptions& options) {
    const int n = options.nodes_per_side;
    CubeSurface cube;
    for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) cube.position.push_back(Vector3d(x, y, z) * options.side_m / (n - 1));
    const int stride[3] = {1, n, n * n};
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {0, n - 1}) {
            const int u = stride[(axis + 1) % 3], v = stride[(axis + 2) % 3];
            for (int i = 0; i + 1 < n; ++i)
                for (int j = 0; j + 1 < n; ++j) {
                    const int a = side * stride[axis] + i * u + j * v;
                    std::int32_t corner[4] = {a, a + u, a + u + v, a + v};  // counter-clockwise from +axis
                    if (side == 0) std::swap(corner[1], corner[3]);
                    const int odd = (i + j) % 2;
                    for (const int k : {odd, odd + 1, odd + 2, odd, odd + 2, odd + 3})
                        cube.patch.push_back(corner[k % 4]);
                }
        }
    return cube;
}

constexpr const char* kOptions = R"({"name": "cube", "scene": "cube.toml",
 "contact": {"force": "interpolated", "god_object": "nearest", "rigid_stiffness": 1000.0, "friction": 0.0,
  "kinetic_friction": 0.0, "release_slew": 0.0, "coupling": "none", "fingers": 1},
 "device": {"max_force": 8.5, "mass": [0.075, 0.075, 0.075], "damping": 0.0, "friction": 0.0, "encoder_step": 0.0,
  "bandwidth": 0.0, "delay": 0.0, "max_speed": 0.0, "max_force_rate": 0.0, "mean_force": 0.0, "mean_force_time": 30.0,
  "motion_scale": 1.0, "force_scale": 1.0},
 "tables": {"precision": "float32", "display_precision": "float32"}})";

std::string summary(const CubeOptions& options) {
    return fmt::format(R"({{"name": "cube", "model_hash": "0123456789abcdef", "drawing": "{}"}})",
                       options.columns == "none" ? "none" : "columns");
}

std::vector<std::int32_t> free_surface_nodes(const CubeSurface& cube) {
    std::map<std::int32_t, int> nodes;
    for (const std::int32_t node : cube.patch) nodes[node] = 0;
    std::vector<std::int32_t> free;
    for (const auto& entry : nodes)
        if (cube.position[std::size_t(entry.first)].z() > 0.0) free.push_back(entry.first);
    return free;
}

std::vector<std::int32_t> touchable(const CubeSurface& cube, const CubeOptions& options) {
    std::vector<std::int32_t> patch;
    for (std::size_t p = 0; p < cube.patch.size(); p += 3) {
        bool inside = true;
        for (std::size_t c = 0; c < 3; ++c)
            inside = inside && cube.position[std::size_t(cube.patch[p + c])].z() >= options.touch_above_m;
        if (inside) patch.insert(patch.end(), {cube.patch[p], cube.patch[p + 1], cube.patch[p + 2]});
    }
    return patch;
}

}  // namespace

Matrix3d cube_compliance(const Vector3d& to, const Vector3d& from) {
    constexpr double kShear_pa = 2000.0, kPoisson = 0.4, kRound_m = 0.004, kDepth_m = 0.012;
    const Vector3d r = to - from;
    const double distance = std::sqrt(r.squaredNorm() + kRound_m * kRound_m);
    const double held = (1.0 - std::exp(-to.z() / kDepth_m)) * (1.0 - std::exp(-from.z() / kDepth_m));
    const Matrix3d kelvin = (3.0 - 4.0 * kPoisson) * Matrix3d::Identity() + r * r.transpose() / (distance * distance);
    return held / (16.0 * std::numbers::pi * kShear_pa * (1.0 - kPoisson) * distance) * kelvin;
}

void write_cube_tables(const std::filesystem::path& folder, const CubeOptions& options) {
    std::filesystem::create_directories(folder);
    const CubeSurface cube = make_surface(options);
    const std::vector<std::int32_t> free = free_surface_nodes(cube);
    const auto at = [&cube](std::int32_t node) { return cube.position[std::size_t(node)]; };
    std::vector<double> position, stiffness;
    for (const Vector3d& p : cube.position) position.insert(position.end(), p.data(), p.data() + 3);
    std::vector<float> columns;
    for (const std::int32_t i : free) {
        const Matrix3d s = cube_compliance(at(i), at(i)).inverse();  // symmetric: its storage order does not matter
        stiffness.insert(stiffness.end(), s.data(), s.data() + 9);
        for (const std::int32_t row : free) {
            const Matrix3d block = cube_compliance(at(row), at(i));
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) columns.push_back(float(block(a, b)));
        }
    }
    const std::vector<std::int32_t> patch = touchable(cube, options);
    const std::size_t n = free.size();
    write_npy<double>(folder / "position.npy", {cube.position.size(), 3}, position);
    write_npy<std::int32_t>(folder / "surface.npy", {cube.patch.size() / 3, 3}, cube.patch);
    write_npy<std::int32_t>(folder / "patch.npy", {patch.size() / 3, 3}, patch);
    write_npy<std::int32_t>(folder / "node_id.npy", {n}, free);
    write_npy<double>(folder / "stiffness.npy", {n, 3, 3}, stiffness);
    if (options.columns != "none") {
        write_npy<std::int32_t>(folder / "row_id.npy", {n}, free);
        write_npy<float>(folder / "columns.npy", {n, n, 3, 3}, columns);
    }
    write_file(folder / "options.json", kOptions);
    seal(folder, parse_json(summary(options)));
}

}  // namespace haptable::test
