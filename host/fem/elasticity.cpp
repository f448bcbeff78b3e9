// SPDX-License-Identifier: GPL-2.0-or-later
// K_ab = V (lambda g_a g_b^T + mu g_b g_a^T + mu (g_a . g_b) I),   g_a = grad N_a
//
// The 3x3 blocks of the linear tetrahedron's stiffness: the strain is constant in the element, so the integral of
// B_a^T D B_b is its volume V times one product. Written with the gradients it needs neither B nor D.
#include "host/fem/elasticity.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace haptable {

namespace {

using Tets = std::span<const std::array<std::int32_t, 4>>;

/// The graph of the unknown nodes: which share an element. Compressed columns, ascending, the node itself included.
struct NodeGraph {
    std::vector<std::size_t> begin;       // [n + 1]
    std::vector<std::int32_t> neighbour;  // [begin[n]]

    std::span<const std::int32_t> column(std::int32_t a) const {
        const auto at = static_cast<std::size_t>(a);
        return std::span(neighbour).subspan(begin[at], begin[at + 1] - begin[at]);
    }
    /// Place of node b in the column of node a.
    std::ptrdiff_t place(std::int32_t a, std::int32_t b) const {
        const auto nodes = column(a);
        return std::lower_bound(nodes.begin(), nodes.end(), b) - nodes.begin();
    }
};

NodeGraph node_graph(Tets tets, std::span<const std::int32_t> unknown, std::int32_t unknown_count) {
    std::vector<std::vector<std::int32_t>> touching(static_cast<std::size_t>(unknown_count));
    for (const auto& tet : tets)
        for (std::int32_t p : tet)
            for (std::int32_t q : tet) {
                const std::int32_t a = unknown[static_cast<std::size_t>(p)];
                const std::int32_t b = unknown[static_cast<std::size_t>(q)];
                if (a >= 0 && b >= 0) touching[static_cast<std::size_t>(a)].push_back(b);
            }
    NodeGraph graph;
    graph.begin.push_back(0);
    for (auto& list : touching) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        graph.neighbour.insert(graph.neighbour.end(), list.begin(), list.end());
        graph.begin.push_back(graph.neighbour.size());
        std::vector<std::int32_t>().swap(list);
    }
    return graph;
}

/// K with its pattern from the graph and all values 0.
Eigen::SparseMatrix<double> empty_matrix(const NodeGraph& graph, std::int32_t unknown_count) {
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(unknown_count);
    Eigen::SparseMatrix<double> k(size, size);
    k.resizeNonZeros(9 * static_cast<Eigen::Index>(graph.neighbour.size()));
    std::fill_n(k.valuePtr(), k.data().size(), 0.0);
    int* begin = k.outerIndexPtr();
    int next = 0;
    for (std::int32_t a = 0; a < unknown_count; ++a)
        for (int column = 0; column < 3; ++column) {
            *begin++ = next;
            for (std::int32_t b : graph.column(a))
                for (int row = 0; row < 3; ++row) k.innerIndexPtr()[next++] = 3 * b + row;
        }
    *begin = next;
    return k;
}

using ElementMatrix = Eigen::Matrix<double, 12, 12>;

/// Adds an element's blocks at the unknowns `place` of its corners; -1: that corner has no rows in K.
void add_element(const NodeGraph& graph, const std::array<std::int32_t, 4>& place, const ElementMatrix& element,
                 Eigen::SparseMatrix<double>& k) {
    for (Eigen::Index b = 0; b < 4; ++b)
        for (Eigen::Index a = 0; a < 4; ++a) {
            const std::int32_t row = place[static_cast<std::size_t>(a)];
            const std::int32_t column = place[static_cast<std::size_t>(b)];
            if (row < 0 || column < 0) continue;
            const std::ptrdiff_t offset = 3 * graph.place(column, row);
            const int* begin = k.outerIndexPtr() + 3 * static_cast<std::ptrdiff_t>(column);
            for (Eigen::Index j = 0; j < 3; ++j)
                Eigen::Map<Eigen::Vector3d>(k.valuePtr() + begin[j] + offset) += element.block<3, 1>(3 * a, 3 * b + j);
        }
}

}  // namespace

Lame Lame::from_young(double young_pa, double poisson) {
    return {young_pa * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)), young_pa / (2.0 * (1.0 + poisson))};
}

TetGeometry tet_geometry(const Corners& corner_m) {
    // Differences first: a body far from the origin keeps its digits.
    const Eigen::Vector3d e1 = corner_m[1] - corner_m[0];
    const Eigen::Vector3d e2 = corner_m[2] - corner_m[0];
    const Eigen::Vector3d e3 = corner_m[3] - corner_m[0];
    const double det = e1.dot(e2.cross(e3));
    TetGeometry geometry;
    geometry.volume_m3 = det / 6.0;
    geometry.gradient_per_m.col(1) = e2.cross(e3) / det;
    geometry.gradient_per_m.col(2) = e3.cross(e1) / det;
    geometry.gradient_per_m.col(3) = e1.cross(e2) / det;
    geometry.gradient_per_m.col(0) = -geometry.gradient_per_m.rightCols<3>().rowwise().sum();
    return geometry;
}

Eigen::Matrix<double, 12, 12> element_stiffness(const TetGeometry& geometry, const Lame& material) {
    const double lambda = geometry.volume_m3 * material.lambda_pa;
    const double mu = geometry.volume_m3 * material.mu_pa;
    Eigen::Matrix<double, 12, 12> k;
    for (Eigen::Index a = 0; a < 4; ++a)
        for (Eigen::Index b = 0; b < 4; ++b) {
            const Eigen::Matrix3d outer = geometry.gradient_per_m.col(a) * geometry.gradient_per_m.col(b).transpose();
            k.block<3, 3>(3 * a, 3 * b) =
                lambda * outer + (mu * outer.transpose() + mu * outer.trace() * Eigen::Matrix3d::Identity());
        }
    return k;
}

Eigen::SparseMatrix<double> assemble_stiffness(std::span<const Eigen::Vector3d> position_m, Tets tets,
                                               std::span<const Lame> material, std::span<const std::int32_t> unknown,
                                               std::int32_t unknown_count) {
    const NodeGraph graph = node_graph(tets, unknown, unknown_count);
    Eigen::SparseMatrix<double> k = empty_matrix(graph, unknown_count);
    for (std::size_t t = 0; t < tets.size(); ++t) {
        Corners corner_m;
        std::array<std::int32_t, 4> place{};
        for (std::size_t c = 0; c < 4; ++c) {
            corner_m[c] = position_m[static_cast<std::size_t>(tets[t][c])];
            place[c] = unknown[static_cast<std::size_t>(tets[t][c])];
        }
        add_element(graph, place, element_stiffness(tet_geometry(corner_m), material[t]), k);
    }
    return k;
}

}  // namespace haptable
