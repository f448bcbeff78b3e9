// SPDX-License-Identifier: GPL-2.0-or-later
// The stiffness of linear tetrahedra: small strain, isotropic.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace haptable {

/// A linear, isotropic material by its Lame constants: stress = lambda tr(strain) I + 2 mu strain.
struct Lame {
    double lambda_pa = 0.0;
    double mu_pa = 0.0;

    /// From Young's modulus > 0 and Poisson's ratio in (-1, 0.5).
    static Lame from_young(double young_pa, double poisson);
};

/// Corners of one tetrahedron, m, with det(p1-p0, p2-p0, p3-p0) > 0.
using Corners = std::array<Eigen::Vector3d, 4>;

/// Volume (m^3) and gradients of the four linear shape functions (column a: grad N_a, 1/m).
struct TetGeometry {
    double volume_m3 = 0.0;
    Eigen::Matrix<double, 3, 4> gradient_per_m;
};
TetGeometry tet_geometry(const Corners& corner_m);

/// The element's stiffness, N/m: 3 rows a corner. Symmetric to the last bit.
Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Lame& material);

/// Assembles K (N/m), both triangles stored, symmetric to the last bit.
///   position_m     [N] nodes
///   tets           [T] mesh nodes, positively oriented
///   material       [T] of each tetrahedron
///   unknown        [N] place of a node among the unknowns, or -1 to leave its rows and columns out
///   unknown_count  nodes in K: it has three rows each
Eigen::SparseMatrix<double> assemble_stiffness(std::span<const Eigen::Vector3d> position_m,
                                               std::span<const std::array<std::int32_t, 4>> tets,
                                               std::span<const Lame> material, std::span<const std::int32_t> unknown,
                                               std::int32_t unknown_count);

}  // namespace haptable
