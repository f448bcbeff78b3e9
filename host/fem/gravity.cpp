// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/gravity.hpp"

#include <algorithm>

#include "host/fem/assembly.hpp"
#include "host/fem/element_points.hpp"
#include "host/fem/nodal_pressure.hpp"
#include "host/mesh/quadratic_tet.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;

/// [T] pressures at the corners, Pa, of the changes of volume that are averaged there.
std::vector<Eigen::Vector4d> nodal_pressures(const ElementMesh& mesh, const Eigen::Matrix3Xd& u) {
    std::vector<Eigen::Vector4d> pressure_pa(mesh.corner.size(), Eigen::Vector4d::Zero());
    if (mesh.element == Element::kLinear) return pressure_pa;
    const NodalCells cells(mesh);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const NodalCells::Average average = cells.average(cell);
        double theta = 0.0;
        for (std::size_t b = 0; b < average.node.size(); ++b)
            theta += average.d_m2.segment<3>(3 * static_cast<Index>(b)).dot(u.col(average.node[b]));
        const Lame& material = cells.material(cell);
        const double averaged_pa = material.lambda_pa - own_lambda_pa(mesh.element, material);
        for (std::int32_t t : cells.tets(cell)) {
            const auto& corner = mesh.corner[static_cast<std::size_t>(t)];
            const auto place = std::find(corner.begin(), corner.end(), cells.node(cell)) - corner.begin();
            pressure_pa[static_cast<std::size_t>(t)][place] = averaged_pa * theta / average.volume_m3;
        }
    }
    return pressure_pa;
}

Hooke own_law_of(const ElementMesh& mesh, std::size_t t) {
    if (const Hooke* law = law_of(mesh, t)) return own_law(mesh, t, *law);
    return isotropic_hooke({own_lambda_pa(mesh.element, mesh.material[t]), mesh.material[t].mu_pa});
}

void fill_tet(const ElementMesh& mesh, std::size_t t, const Eigen::Matrix3Xd& u, const Eigen::Vector4d& pressure_pa,
              Eigen::MatrixXd& k) {
    const std::vector<std::int32_t> nodes = nodes_of(mesh, t);
    const auto count = static_cast<Index>(nodes.size());
    const Hooke law = own_law_of(mesh, t);
    const Eigen::Matrix3Xd moves = moves_of(nodes, u);
    k.setZero(3 * count, 3 * count);
    for (const ElementPoint& p : points_of(mesh, t)) {
        const Matrix3d stress =
            stress_of(law * strain_of(gradient_of(moves, p))) + p.of_corner.dot(pressure_pa) * Matrix3d::Identity();
        for (Index a = 0; a < count; ++a)
            for (Index b = 0; b <= a; ++b)
                k.block<3, 3>(3 * a, 3 * b).diagonal().array() +=
                    p.volume_m3 * p.gradient_per_m.col(a).dot(stress * p.gradient_per_m.col(b));
    }
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
}

}  // namespace

Eigen::Matrix3Xd weight_of(const ElementMesh& mesh, std::span<const double> density_kg_per_m3,
                           const Eigen::Vector3d& acceleration_m_per_s2) {
    Eigen::Matrix3Xd force = Eigen::Matrix3Xd::Zero(3, static_cast<Index>(mesh.position_m.size()));
    for (std::size_t t = 0; t < mesh.corner.size(); ++t) {
        const std::vector<std::int32_t> nodes = nodes_of(mesh, t);
        for (const ElementPoint& p : points_of(mesh, t)) {
            const Eigen::VectorXd value =
                mesh.is_quadratic() ? Eigen::VectorXd(ten_values(p.of_corner)) : Eigen::VectorXd(p.of_corner);
            for (std::size_t a = 0; a < nodes.size(); ++a)
                force.col(nodes[a]) +=
                    p.volume_m3 * density_kg_per_m3[t] * value[static_cast<Index>(a)] * acceleration_m_per_s2;
        }
    }
    return force;
}

Eigen::SparseMatrix<double> geometric_stiffness(const ElementMesh& mesh, const Eigen::Matrix3Xd& u,
                                                std::span<const std::int32_t> unknown, std::int32_t unknown_count) {
    const std::vector<Eigen::Vector4d> pressure_pa = nodal_pressures(mesh, u);
    const auto fill = [&](std::size_t i, Eigen::MatrixXd& k) {
        if (i < mesh.corner.size())
            fill_tet(mesh, i, u, pressure_pa[i], k);
        else
            k = layer_geometric_stiffness(mesh.position_m, mesh.face[i - mesh.corner.size()], u);
    };
    return assemble(node_lists(mesh), fill, unknown, unknown_count);
}

}  // namespace haptable
