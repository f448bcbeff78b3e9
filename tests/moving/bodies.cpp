// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "host/mesh/write_tetgen.hpp"
#include "tests/bodies.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

namespace {

using Eigen::Vector3d;

constexpr double kDensity = 1000.0, kYoung_pa = 1.5e4, kPoisson = 0.4;

bool never(const Vector3d& /*x*/) { return false; }
bool always(int, int, int) { return true; }

Cells bar(std::array<int, 3> count, const Vector3d& size) {
    return {count, [=](double a, double b, double c) { return Vector3d(size.cwiseProduct(Vector3d(a, b, c))); }, always,
            never};
}

/// Between -1 and 1, by the place to nine digits alone: grid points that fall together stay together.
double noise(const Vector3d& x, int axis) {
    std::seed_seq seed{std::lround(1e9 * x.x()), std::lround(1e9 * x.y()), std::lround(1e9 * x.z()), long{axis}};
    std::mt19937 random(seed);
    return std::uniform_real_distribution<double>(-1.0, 1.0)(random);
}

/// A block with its corners drawn in, bent and dented: smooth, without a symmetry.
Vector3d wavy(double a, double b, double c) {
    const Vector3d x = 2.0 * Vector3d(a, b, c) - Vector3d::Ones();
    const Vector3d round = (1.0 - 0.12 * x.squaredNorm()) * x;
    const Vector3d wave(0.2 * std::sin(2.0 * x.y() + 1.0), 0.1 * std::sin(2.2 * x.z()), 0.25 * std::cos(1.7 * x.x()));
    return Vector3d(0.024, 0.018, 0.014).cwiseProduct(round + wave);
}

/// Voxels of a ball whose radius has waves, each node moved by up to a seventh of a voxel.
constexpr int kVoxels = 8;
constexpr double kScan_m = 0.02;
Vector3d scanned(double a, double b, double c) {
    const Vector3d x = kScan_m * (2.0 * Vector3d(a, b, c) - Vector3d::Ones());
    return x + 2.0 * kScan_m / kVoxels / 7.0 * Vector3d(noise(x, 0), noise(x, 1), noise(x, 2));
}
bool is_scanned(int i, int j, int k) {
    const Vector3d x = (Vector3d(i, j, k) + Vector3d::Constant(0.5)) * 2.0 / kVoxels - Vector3d::Ones();
    return x.norm() < 0.92 + 0.08 * std::sin(5.0 * x.x()) * std::cos(4.0 * x.y());
}

}  // namespace

Shaped block() { return {"block", bar({3, 3, 3}, {0.03, 0.03, 0.03})}; }
Shaped plate() { return {"plate", bar({4, 4, 2}, {0.04, 0.04, 0.008})}; }
Shaped slab() { return {"slab", bar({4, 4, 2}, {0.04, 0.015, 0.04})}; }
Shaped sheet() { return {"sheet", bar({6, 1, 4}, {0.04, 0.003, 0.02})}; }
Shaped rod() { return {"rod", bar({8, 2, 2}, {0.06, 0.01, 0.01})}; }
Shaped ball() { return {"ball", sphere_cells(4, 0.018)}; }
Shaped ring() { return {"ring", torus_cells(12, 2, 0.02, 0.007)}; }
Shaped lump() { return {"lump", {{5, 4, 4}, wavy, always, never}}; }
Shaped noisy_scan() { return {"scan", {{kVoxels, kVoxels, kVoxels}, scanned, is_scanned, never}}; }

Scene scene_of(const Shaped& shaped, bool is_free, int modes, ForceLaw force, int fingers) {
    static const TemporaryFolder folder;  // of each body its mesh
    const TetMesh mesh = mesh_of(shaped.cells);
    Scene scene;
    scene.name = shaped.name;
    scene.file = shaped.name + ".toml";
    scene.mesh.file = write_tetgen(mesh.position_m, mesh.tet, folder.path() / shaped.name);
    scene.material = {kYoung_pa, kPoisson};
    const auto [low, high] = std::minmax_element(mesh.position_m.begin(), mesh.position_m.end(),
                                                 [](const auto& a, const auto& b) { return a.z() < b.z(); });
    if (is_free) {
        scene.free_body = FreeBody{};
        scene.free_body->density_kg_per_m3 = kDensity;
        scene.free_body->floor = FreeBody::Floor{low->z(), {0.0, 0.0, 1.0}, 0.5};
    } else {
        const double to = low->z() + (high->z() - low->z()) / 6.0;
        scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, to}, "", 1});
    }
    if (modes > 0) scene.body_modes = BodyModes{modes, 0.05, is_free ? 0.0 : kDensity, 0.0, 1};
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.01;
    scene.contact.fingers = fingers;
    scene.device.max_force_n = 1e6;
    return scene;
}

}  // namespace haptable::test
