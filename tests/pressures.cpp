// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/pressures.hpp"

#include <map>

#include "host/fem/stiffness.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {

namespace {

using ByRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// theta = d . u / volume of the tetrahedra of one material at one node.
struct Cell {
    std::map<std::int32_t, Eigen::Vector3d> d_m2;  // by mesh node
    double volume_m3 = 0.0;
};

Corners corners_of(const Body& body, const Tet& tet) {
    Corners corner_m;
    for (std::size_t c = 0; c < 4; ++c) corner_m[c] = body.mesh.position_m[static_cast<std::size_t>(tet[c])];
    return corner_m;
}

}  // namespace

Stiffness pressure_stiffness(const Body& body, double poisson, double ratio) {
    std::vector<Lame> own;                                  // lambda_e = 0
    std::map<std::pair<std::int32_t, double>, Cell> cells;  // by node and lambda
    for (const Tet& tet : body.mesh.tet) {
        const Corners corner_m = corners_of(body, tet);
        const bool is_low = (corner_m[0] + corner_m[1] + corner_m[2] + corner_m[3]).z() / 4.0 < 0.015;
        const Lame lame = Lame::from_young(1e4 * (is_low ? ratio : 1.0), poisson);
        const TetGeometry geometry = tet_geometry(corner_m);
        own.push_back({0.0, lame.mu_pa});
        for (std::int32_t node : tet) {
            Cell& cell = cells[{node, lame.lambda_pa}];
            cell.volume_m3 += geometry.volume_m3 / 4.0;
            for (std::size_t c = 0; c < 4; ++c)
                cell.d_m2.try_emplace(tet[c], Eigen::Vector3d::Zero()).first->second +=
                    geometry.volume_m3 / 4.0 * geometry.gradient_per_m.col(static_cast<Eigen::Index>(c));
        }
    }
    const auto unknown = [&](std::int32_t node) { return body.unknown[static_cast<std::size_t>(node)]; };
    Triplets entry;
    std::vector<std::int32_t> node;
    for (const auto& [key, cell] : cells) {
        const double scale = std::sqrt(key.second / cell.volume_m3);
        for (const auto& [other, d] : cell.d_m2)
            for (int c = 0; c < 3 && unknown(other) >= 0; ++c)
                entry.emplace_back(static_cast<int>(node.size()), 3 * unknown(other) + c, scale * d[c]);
        node.push_back(unknown(key.first));
    }
    const auto count = static_cast<std::int32_t>(body.free_node.size());
    ByRows g(static_cast<Eigen::Index>(node.size()), 3 * static_cast<Eigen::Index>(count));
    g.setFromTriplets(entry.begin(), entry.end());
    const ElementMesh mesh{Element::kLinear, body.mesh.position_m, body.mesh.tet, own};
    return {assemble_stiffness(mesh, body.unknown, count).a, g, std::move(node)};
}

Stiffness pressure_cube(int nodes_per_side, double poisson, double ratio) {
    const Scene scene = cube_scene(nodes_per_side, poisson);
    return pressure_stiffness(make_body(scene, make_mesh(scene.mesh)), poisson, ratio);
}

Stiffness random_stiffness(Eigen::Index nodes, double weight, std::mt19937& random) {
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    std::uniform_int_distribution<int> any(0, static_cast<int>(3 * nodes) - 1);
    Triplets entry;
    for (int row = 0; row < 3 * nodes; ++row) {
        for (int c = 0; c < 3; ++c) entry.emplace_back(row, row / 3 * 3 + c, row % 3 == c ? 2.0 : 0.5 * number(random));
        for (int e = 0; e < 2; ++e) entry.emplace_back(row, any(random), 0.5 * number(random));
    }
    Stiffness::Sparse root(3 * nodes, 3 * nodes);
    root.setFromTriplets(entry.begin(), entry.end());
    entry.clear();
    std::vector<std::int32_t> node;
    for (std::int32_t i = 0; i < nodes; ++i) node.insert(node.end(), i % 5 == 0 ? 2 : 1, i);
    node.insert(node.end(), 3, -1);
    std::shuffle(node.begin(), node.end(), random);
    for (int p = 0; p < static_cast<int>(node.size()); ++p)
        for (int e = 0; e < 4; ++e) entry.emplace_back(p, any(random), weight * number(random));
    ByRows g(static_cast<Eigen::Index>(node.size()), 3 * nodes);
    g.setFromTriplets(entry.begin(), entry.end());
    return {Stiffness::Sparse(root * root.transpose()), g, std::move(node)};
}

}  // namespace haptable::test
