// SPDX-License-Identifier: GPL-2.0-or-later
// W = int lambda/2 tr(e)^2 + mu |e|^2 + normal/2 (n . u)^2 + tangential/2 |P u|^2 dA
// e = P (grad_s u + grad_s u^T) / 2 P,   P = I - n n^T
//
// What lies on the faces of a body: a membrane in plane stress, which stretches with the face and does not bend, and a
// bed of springs to the ground (Winkler 1867). Both add up where they share a face.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace haptable {

/// By area of the rest surface.
struct Layer {
    double lambda_n_per_m = 0.0, mu_n_per_m = 0.0;            ///< of the membrane: t E nu / (1 - nu^2), t G
    double normal_n_per_m3 = 0.0, tangential_n_per_m3 = 0.0;  ///< of the bed

    /// Plane stress.
    static Layer membrane(double thickness_m, double young_pa, double poisson);
    static Layer bed(double normal_n_per_m3, double tangential_n_per_m3);
    Layer& operator+=(const Layer& other);
    bool has_membrane() const { return mu_n_per_m > 0.0; }
    bool has_bed() const { return normal_n_per_m3 > 0.0 || tangential_n_per_m3 > 0.0; }
};

/// A face of a tetrahedron that has one: its corners, counter-clockwise from outside, and the middles of 01 12 20.
struct LayeredFace {
    std::array<std::int32_t, 6> node{};  ///< mesh nodes
    std::size_t nodes = 3;               ///< or 6
    Layer layer;
};
std::span<const std::int32_t> nodes_of(const LayeredFace& face);

/// The face's stiffness, N/m: three rows a node. Symmetric to the last bit. position_m: [N]
Eigen::MatrixXd layer_stiffness(std::span<const Eigen::Vector3d> position_m, const LayeredFace& face);

/// Its geometric stiffness under the tension that displacements put into its membrane: int (g_a . s g_b) dA I.
///   u  [3, N] m
Eigen::MatrixXd layer_geometric_stiffness(std::span<const Eigen::Vector3d> position_m, const LayeredFace& face,
                                          const Eigen::Matrix3Xd& u);

double area_of(std::span<const Eigen::Vector3d> position_m, const LayeredFace& face);  ///< m^2

}  // namespace haptable
