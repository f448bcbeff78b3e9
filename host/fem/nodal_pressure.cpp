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
        const TetGeometry g = tet_geometry(corners_of(mesh_, static_cast<std::size_t>(t)));
        average.volume_m3 += g.volume_m3 / 4.0;  // int N_a dV over the element
        for (std::size_t b = 0; b < 4; ++b)
            d_m2.try_emplace(mesh_.corner[static_cast<std::size_t>(t)][b], Eigen::Vector3d::Zero()).first->second +=
                g.volume_m3 / 4.0 * g.gradient_per_m.col(static_cast<Eigen::Index>(b));
    }
    average.d_m2.resize(3 * static_cast<Eigen::Index>(d_m2.size()));
    for (const auto& [node, d] : d_m2) {
        average.d_m2.segment<3>(3 * static_cast<Eigen::Index>(average.node.size())) = d;
        average.node.push_back(node);
    }
    return average;
}

}  // namespace haptable
