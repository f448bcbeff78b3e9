// SPDX-License-Identifier: GPL-2.0-or-later
// W = sum_e int (mu |strain|^2 + 1/2 lambda_e tr(strain)^2) dV + 1/2 sum_a (lambda - lambda_e) V_a theta_a^2
// theta_a = int N_a div u dV / V_a,   V_a = int N_a dV
//
// A body of tetrahedra resists a change of shape element by element. To a change of volume it does so element by
// element only as far as lambda_e; the rest, which would lock near incompressibility, it averages at the nodes:
// average nodal pressure (Bonet and Burton 1998). Where materials meet, a node has one theta of each, so that their
// interface does not smear (after Joldes, Wittek and Miller 2009). Nodes that average are corners, N_a the linear shape
// functions: of quadratic tetrahedra these are the pressures of Taylor and Hood's element, with a lumped mass.
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/base/modes.hpp"
#include "host/fem/face_layer.hpp"
#include "host/fem/hooke.hpp"
#include "host/fem/lists.hpp"

namespace haptable {

/// N nodes, T tetrahedra.
struct ElementMesh {
    Element element = Element::kLinear;
    std::span<const Eigen::Vector3d> position_m;          ///< [N]
    std::span<const std::array<std::int32_t, 4>> corner;  ///< [T] mesh nodes, positively oriented
    std::span<const Lame> material;                       ///< [T]
    /// [T] of Element::kQuadratic: mesh nodes in the middle of edges 01 12 20 03 13 23
    std::span<const std::array<std::int32_t, 6>> middle = {};
    /// Laws that are not isotropic, and [T] which of them a tetrahedron has, or -1; empty where none has. Its Lame
    /// constants are then those of a like isotropic material: they say what it averages (own_law).
    std::span<const Hooke> law = {};
    std::span<const std::int32_t> law_of = {};
    std::span<const LayeredFace> face = {};  ///< of tetrahedra, with membranes and beds

    bool is_quadratic() const { return element == Element::kQuadratic; }
};

/// All nodes of tetrahedron t: 4, or 10.
std::vector<std::int32_t> nodes_of(const ElementMesh& mesh, std::size_t t);

/// The nodes of all small matrices: of the tetrahedra, then of the layered faces.
Lists node_lists(const ElementMesh& mesh);

/// The corners of tetrahedron t.
Corners corners_of(const ElementMesh& mesh, std::size_t t);

TenNodes ten_nodes_of(const ElementMesh& mesh, std::size_t t);

/// lambda_e, which an element keeps for itself; the rest it leaves to the nodes.
double own_lambda_pa(Element element, const Lame& material);

/// Law of tetrahedron t, where it has one: D - (lambda - lambda_e) 1 1^T, without what it leaves to the nodes. With the
/// bulk modulus kappa of Reuss's average, 1 / (1^T D^-1 1), it is positive definite as long as lambda - lambda_e <
/// kappa.
const Hooke* law_of(const ElementMesh& mesh, std::size_t t);
Hooke own_law(const ElementMesh& mesh, std::size_t t, const Hooke& law);

/// K = A + G^T G, n unknown nodes, m thetas. K is positive definite where the body is held; A and G are much sparser.
struct StiffnessParts {
    Eigen::SparseMatrix<double> a;                   ///< [3n, 3n] N/m, both triangles, symmetric to the last bit
    Eigen::SparseMatrix<double, Eigen::RowMajor> g;  ///< [m, 3n] (N/m)^1/2: sqrt((lambda - lambda_e) V_a) theta_a = G u
    std::vector<std::int32_t> node;                  ///< [m] mesh node of each theta
};

///   unknown        [N] place of a node among the unknowns, or -1 to leave its rows and columns out
///   unknown_count  n
StiffnessParts assemble_stiffness(const ElementMesh& mesh, std::span<const std::int32_t> unknown,
                                  std::int32_t unknown_count);

}  // namespace haptable
