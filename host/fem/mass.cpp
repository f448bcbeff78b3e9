// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/mass.hpp"

#include "host/fem/assembly.hpp"
#include "host/mesh/quadratic_tet.hpp"

namespace haptable {

namespace {

using Eigen::Index;

/// int N_a N_b dV / V of four nodes.
double shared_of_four(Index a, Index b) { return a == b ? 0.1 : 0.05; }

/// A point of integration and its share of the volume.
struct Point {
    Eigen::Vector4d at;
    double share;
};

/// Exact for polynomials of degree 5 (Walkington 2000): shape functions of ten nodes are of degree 2.
std::vector<Point> points_of_degree_5() {
    std::vector<Point> points;
    for (const auto& [inner, share] :
         {std::pair{0.31088591926330060980, 0.11268792571801585080}, {0.09273525031089122640, 0.07349304311636194934}})
        for (Index c = 0; c < 4; ++c) {
            Eigen::Vector4d at = Eigen::Vector4d::Constant(inner);
            at[c] = 1.0 - 3.0 * inner;
            points.push_back({at, share});
        }
    constexpr double kInner = 0.04550370412564964949, kShare = 0.04254602077708146686;
    for (const auto& edge : kTetEdges) {
        Eigen::Vector4d at = Eigen::Vector4d::Constant(kInner);
        for (const std::size_t c : edge) at[static_cast<Index>(c)] = 0.5 - kInner;
        points.push_back({at, kShare});
    }
    return points;
}

/// int N_a N_b dV of one element, m^3.
Eigen::MatrixXd shared_volume(const ElementMesh& mesh, std::size_t t) {
    static const std::vector<Point> points = points_of_degree_5();
    if (!mesh.is_quadratic()) {
        const double volume_m3 = tet_geometry(corners_of(mesh, t)).volume_m3;
        Eigen::MatrixXd shared(4, 4);
        for (Index a = 0; a < 4; ++a)
            for (Index b = 0; b < 4; ++b) shared(a, b) = volume_m3 * shared_of_four(a, b);
        return shared;
    }
    Eigen::MatrixXd shared = Eigen::MatrixXd::Zero(10, 10);
    for (const Point& p : points) {
        const Eigen::Vector<double, 10> value = ten_values(p.at);
        shared += tet_point(ten_nodes_of(mesh, t), p.at).det_m3 / 6.0 * p.share * value * value.transpose();
    }
    return shared;
}

}  // namespace

Eigen::SparseMatrix<double> mass_matrix(const ElementMesh& mesh, std::span<const double> density_kg_per_m3,
                                        std::span<const std::int32_t> unknown, std::int32_t unknown_count) {
    const Lists nodes = node_lists(mesh);
    const auto fill = [&](std::size_t i, Eigen::MatrixXd& m) {
        const auto count = static_cast<Index>(nodes[i].size());
        m.setZero(3 * count, 3 * count);
        if (i >= mesh.corner.size()) return;  // a membrane weighs nothing
        const Eigen::MatrixXd shared = density_kg_per_m3[i] * shared_volume(mesh, i);
        for (Index a = 0; a < count; ++a)
            for (Index b = 0; b < count; ++b) m.block<3, 3>(3 * a, 3 * b).diagonal().setConstant(shared(a, b));
    };
    return assemble(nodes, fill, unknown, unknown_count);
}

}  // namespace haptable
