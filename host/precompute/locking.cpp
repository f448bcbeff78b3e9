// SPDX-License-Identifier: GPL-2.0-or-later
// 1 / e = 1 / e_inf + 1 / e_1,   e_inf = 0.93 (h / R)^0.73,   e_1 = 0.0155 lambda / mu (h / R)^1.63
#include "host/precompute/locking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

// Below it what linear tetrahedra are too stiff by is their coarseness, not locking.
constexpr double kLeastPoisson = 0.4;
// A hand tells stiffnesses apart that differ by 8 to 22 % (Jones and Hunter 1990).
constexpr double kFelt = 0.05;

double most_poisson(const Scene& scene) {
    double most = scene.material.poisson;
    for (const Region& region : scene.regions) most = std::max(most, region.material.poisson);
    return most;
}

double volume_m3(const TetMesh& mesh) {
    double six = 0.0;
    for (const Tet& tet : mesh.tet) six += six_volumes(mesh.position_m, tet);
    return six / 6.0;
}

/// Edge of a grid's cell that is cut into five tetrahedra, where the mesh is as fine.
double mean_edge_m(const TetMesh& mesh) {
    return std::cbrt(5.0 * volume_m3(mesh) / static_cast<double>(mesh.tet.size()));
}

double pad_radius_m(const Scene& scene, const TetMesh& mesh) {
    return scene.contact.mask_radius_m > 0.0 ? scene.contact.mask_radius_m : std::cbrt(volume_m3(mesh)) / 6.0;
}

}  // namespace

double expected_locking(double poisson, double edge_m, double radius_m) {
    if (poisson < kLeastPoisson) return 0.0;
    const double lambda_by_mu = 2.0 * poisson / (1.0 - 2.0 * poisson), h = edge_m / radius_m;
    return 1.0 / (1.0 / (0.93 * std::pow(h, 0.73)) + 1.0 / (0.0155 * lambda_by_mu * std::pow(h, 1.63)));
}

double expected_locking(const Scene& scene, const TetMesh& mesh) {
    if (scene.mesh.element != Element::kLinear) return 0.0;
    return expected_locking(most_poisson(scene), mean_edge_m(mesh), pad_radius_m(scene, mesh));
}

std::vector<std::string> locking_warnings(const Scene& scene, const TetMesh& mesh) {
    const double locking = expected_locking(scene, mesh);
    if (locking < kFelt) return {};
    return {
        fmt::format("{}: linear tetrahedra lock at Poisson's ratio {}: on this mesh a finger's pad of {:.2g} m is "
                    "expected to feel the body about {:.0f} % too stiff; write element = \"{}\" in [mesh]",
                    scene.file.string(), most_poisson(scene), pad_radius_m(scene, mesh), 100.0 * locking,
                    word(Element::kAverageNodalPressure))};
}

}  // namespace haptable
