// SPDX-License-Identifier: GPL-2.0-or-later
// theta_a = sum_e int_e N_a div u dV / sum_e int_e N_a dV
#include "host/fem/nodal_pressure.hpp"

#include <algorithm>
#include <map>

namespace haptable {

namespace {

/// [T] number of each tetrahedron's material: equal constants are one material, whatever named them.
std::vector<std::int32_t> number_materials(std::span<const Lame> material) {
    std::map<std::pair<double, double>, std::int32_t> known;
    std::vector<std::int32_t> number;
    for (const Lame& m : material)
        number.push_back(
            known.try_emplace({m.lambda_pa, m.mu_pa}, static_cast<std::int32_t>(known.size())).first->second);
    return number;
}

/// Integrals over an element at its corner a: int N_a dV, m^3, and int N_a grad N_b dV for all its nodes b, m^2.
struct Share {
    double volume_m3 = 0.0;
    Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 10> d_m2;
};

Share share_of(const ElementMesh& mesh, std::size_t t, std::int32_t node) {
    if (!mesh.is_quadratic()) {  // the same at every corner
        const TetGeometry g = tet_geometry(corners_of(mesh, t));
        return {g.volume_m3 / 4.0, g.volume_m3 / 4.0 * g.gradient_per_m};
    }
    const auto& corner = mesh.corner[t];
    const Eigen::Index a = std::find(corner.begin(), corner.end(), node) - corner.begin();
    const TenNodes node_m = ten_nodes_of(mesh, t);
    Share share{0.0, TenGradients::Zero()};
    for (const Eigen::Vector4d& point : tet_points()) {
        const auto [det, gradient] = tet_point(node_m, point);
        const double dv = det / 24.0 * point[a];
        share.volume_m3 += dv;
        share.d_m2 += dv * gradient;
    }
    return share;
}

}  // namespace

NodalCells::NodalCells(const ElementMesh& mesh) : mesh_(mesh) {
    Lists corners;
    for (const auto& tet : mesh.corner) corners.append(tet);
    const Lists at_node = corners.holders(mesh.position_m.size());
    const std::vector<std::int32_t> number = number_materials(mesh.material);
    const auto material = [&](std::int32_t t) { return number[static_cast<std::size_t>(t)]; };
    for (std::size_t a = 0; a < at_node.size(); ++a) {
        std::vector<std::int32_t> tets(at_node[a].begin(), at_node[a].end());
        std::stable_sort(tets.begin(), tets.end(),
                         [&](std::int32_t t, std::int32_t u) { return material(t) < material(u); });
        for (auto begin = tets.begin(), end = begin; begin != tets.end(); begin = end) {
            end = std::find_if(begin, tets.end(), [&](std::int32_t t) { return material(t) != material(*begin); });
            tets_at_.append({begin, end});
            node_.push_back(static_cast<std::int32_t>(a));
        }
    }
}

NodalCells::Average NodalCells::average(std::size_t cell) const {
    std::map<std::int32_t, Eigen::Vector3d> d_m2;
    Average average;
    for (std::int32_t t : tets_at_[cell]) {
        const Share share = share_of(mesh_, static_cast<std::size_t>(t), node_[cell]);
        const std::vector<std::int32_t> nodes = nodes_of(mesh_, static_cast<std::size_t>(t));
        average.volume_m3 += share.volume_m3;
        for (std::size_t b = 0; b < nodes.size(); ++b)
            d_m2.try_emplace(nodes[b], Eigen::Vector3d::Zero()).first->second +=
                share.d_m2.col(static_cast<Eigen::Index>(b));
    }
    average.d_m2.resize(3 * static_cast<Eigen::Index>(d_m2.size()));
    for (const auto& [node, d] : d_m2) {
        average.d_m2.segment<3>(3 * static_cast<Eigen::Index>(average.node.size())) = d;
        average.node.push_back(node);
    }
    return average;
}

}  // namespace haptable
