// SPDX-License-Identifier: GPL-2.0-or-later
// K = sum over bricks of int 2 mu eps : eps + lambda D^T M^-1 D,   D = int p div u,   M = int p p^T,   p = (1, x, y, z)
#include "host/bench/error/bricks.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/inverse/factor.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using ElementMatrix = Eigen::Matrix<double, 81, 81>;

const std::array<double, 3> kGaussPoint{-std::sqrt(0.6), 0.0, std::sqrt(0.6)};
constexpr std::array<double, 3> kGaussWeight{5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};

/// The three quadratic shape functions of a line of -1..1 and their derivatives.
std::array<double, 3> shape(double s) { return {0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)}; }
std::array<double, 3> slope(double s) { return {s - 0.5, -2.0 * s, s + 0.5}; }

/// Gradients of the 27 shape functions at a point of the brick; node q is q % 3, q / 3 % 3, q / 9 along x, y, z.
Eigen::Matrix<double, 3, 27> gradients(const Vector3d& at, const Vector3d& half_m) {
    Eigen::Matrix<double, 3, 27> g;
    const auto x = shape(at[0]), y = shape(at[1]), z = shape(at[2]);
    const auto dx = slope(at[0]), dy = slope(at[1]), dz = slope(at[2]);
    for (std::size_t q = 0; q < 27; ++q) {
        const std::size_t i = q % 3, j = q / 3 % 3, k = q / 9;
        g.col(static_cast<Index>(q)) << dx[i] * y[j] * z[k] / half_m[0], x[i] * dy[j] * z[k] / half_m[1],
            x[i] * y[j] * dz[k] / half_m[2];
    }
    return g;
}

void add_shear(const Eigen::Matrix<double, 3, 27>& g, double weight, ElementMatrix& k) {
    for (Index a = 0; a < 27; ++a)
        for (Index b = 0; b < 27; ++b)
            k.block<3, 3>(3 * a, 3 * b) +=
                weight * (g.col(b) * g.col(a).transpose() + g.col(a).dot(g.col(b)) * Eigen::Matrix3d::Identity());
}

ElementMatrix brick_stiffness(const Vector3d& half_m, const Lame& material) {
    ElementMatrix k = ElementMatrix::Zero();
    Eigen::Matrix<double, 4, 81> d = Eigen::Matrix<double, 4, 81>::Zero();
    Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
    for (std::size_t q = 0; q < 27; ++q) {
        const std::array<std::size_t, 3> i{q % 3, q / 3 % 3, q / 9};
        const Vector3d at(kGaussPoint[i[0]], kGaussPoint[i[1]], kGaussPoint[i[2]]);
        const double weight = kGaussWeight[i[0]] * kGaussWeight[i[1]] * kGaussWeight[i[2]] * half_m.prod();
        const auto g = gradients(at, half_m);
        const Eigen::Vector4d p(1.0, at[0], at[1], at[2]);
        d += weight * p * Eigen::Map<const Eigen::Matrix<double, 1, 81>>(g.data());
        m += weight * p * p.transpose();
        add_shear(g, weight * material.mu_pa, k);
    }
    return k + material.lambda_pa * d.transpose() * m.inverse() * d;
}

/// Cells and nodes of the box; two nodes a cell along each axis, and one more.
class Grid {
public:
    explicit Grid(const GridPlanes& plane_m) : plane_m_(plane_m) {
        for (std::size_t a = 0; a < 3; ++a) cells_[a] = static_cast<int>(plane_m[a].size()) - 1;
    }
    int cells(std::size_t axis) const { return cells_[axis]; }
    int nodes(std::size_t axis) const { return 2 * cells_[axis] + 1; }
    std::int32_t node(int i, int j, int k) const { return i + nodes(0) * (j + nodes(1) * k); }
    std::int32_t held_count() const { return nodes(0) * nodes(1); }  // the lowest plane comes first
    std::int32_t node_count() const { return held_count() * nodes(2); }
    double at(std::size_t axis, int cell, double s) const {
        const auto& plane = plane_m_[axis];
        const double low = plane[static_cast<std::size_t>(cell)], high = plane[static_cast<std::size_t>(cell) + 1];
        return low + 0.5 * (s + 1.0) * (high - low);
    }
    double half(std::size_t axis, int cell) const { return at(axis, cell, 1.0) - at(axis, cell, 0.0); }

private:
    const GridPlanes& plane_m_;
    std::array<int, 3> cells_{};
};

Eigen::SparseMatrix<double> assemble_bricks(const Grid& grid, const Lame& material) {
    const Index size = Index{3} * (grid.node_count() - grid.held_count());
    Eigen::SparseMatrix<double> k(size, size);
    for (int z = 0; z < grid.cells(2); ++z) {  // a layer at a time, to hold few entries twice
        std::vector<Eigen::Triplet<double>> entries;
        for (int y = 0; y < grid.cells(1); ++y)
            for (int x = 0; x < grid.cells(0); ++x) {
                const ElementMatrix e = brick_stiffness({grid.half(0, x), grid.half(1, y), grid.half(2, z)}, material);
                std::array<Index, 27> first{};
                for (int q = 0; q < 27; ++q)
                    first[static_cast<std::size_t>(q)] =
                        Index{3} * (grid.node(2 * x + q % 3, 2 * y + q / 3 % 3, 2 * z + q / 9) - grid.held_count());
                for (Index r = 0; r < 81; ++r)
                    for (Index c = 0; c < 81; ++c) {
                        const Index row = first[static_cast<std::size_t>(r / 3)] + r % 3;
                        const Index column = first[static_cast<std::size_t>(c / 3)] + c % 3;
                        if (row >= 0 && column >= 0)
                            entries.emplace_back(static_cast<int>(row), static_cast<int>(column), e(r, c));
                    }
            }
        Eigen::SparseMatrix<double> layer(size, size);
        layer.setFromTriplets(entries.begin(), entries.end());
        k += layer;
    }
    return k;
}

/// The pressure on the highest plane against the shape functions of its nodes: a cell in pieces, for its rim.
LoadShares shares_on_top(const Grid& grid, double top_m, const Footprint& footprint) {
    constexpr int kPieces = 12;
    LoadShares shares;
    for (int y = 0; y < grid.cells(1); ++y)
        for (int x = 0; x < grid.cells(0); ++x)
            for (int piece = 0; piece < 9 * kPieces * kPieces; ++piece) {
                const std::size_t a = static_cast<std::size_t>(piece) % 3, b = static_cast<std::size_t>(piece) / 3 % 3;
                const int column = piece / 9 % kPieces, row = piece / 9 / kPieces;
                const double s = -1.0 + (2.0 * column + 1.0 + kGaussPoint[a]) / kPieces;
                const double t = -1.0 + (2.0 * row + 1.0 + kGaussPoint[b]) / kPieces;
                const double p = footprint.pressure({grid.at(0, x, s), grid.at(1, y, t), top_m}) * kGaussWeight[a] *
                                 kGaussWeight[b] * grid.half(0, x) * grid.half(1, y);
                if (p == 0.0) continue;
                const auto along_x = shape(s), along_y = shape(t);
                for (std::size_t q = 0; q < 9; ++q)
                    shares[grid.node(2 * x + static_cast<int>(q % 3), 2 * y + static_cast<int>(q / 3),
                                     grid.nodes(2) - 1)] += p * along_x[q % 3] * along_y[q / 3];
            }
    return normed(shares);
}

/// On the planes of least x and y nothing moves through the plane.
void mirror(const Grid& grid, Eigen::SparseMatrix<double>& k) {
    std::vector<char> held(static_cast<std::size_t>(k.rows()), 0);
    const auto hold_at = [&](std::int32_t node, int axis) {
        held[3 * static_cast<std::size_t>(node - grid.held_count()) + static_cast<std::size_t>(axis)] = 1;
    };
    for (int z = 1; z < grid.nodes(2); ++z) {
        for (int y = 0; y < grid.nodes(1); ++y) hold_at(grid.node(0, y, z), 0);
        for (int x = 0; x < grid.nodes(0); ++x) hold_at(grid.node(x, 0, z), 1);
    }
    hold(held, k);
}

/// Ratio of a geometric series of `cells` sizes that begins after `first` and sums up to `length`.
double growth(double length, double first, int cells) {
    double least = 1e-3, most = 1e3;
    for (int step = 0; step < 100; ++step) {
        const double ratio = std::sqrt(least * most);
        double sum = 0.0, size = first;
        for (int cell = 0; cell < cells; ++cell) sum += size *= ratio;
        (sum < length ? least : most) = ratio;
    }
    return least;
}

}  // namespace

std::vector<double> graded_planes(double low, double high, double from, double to, int inner, int outer) {
    std::vector<double> below, planes;
    const double cell = (to - from) / inner;
    const auto outwards = [&](double begin, double length, double sign, std::vector<double>& out) {
        if (!(length > 1e-9 * (high - low))) return;
        const double ratio = growth(length, cell, outer);
        double size = cell, at = begin;
        for (int k = 0; k < outer; ++k) out.push_back(at += sign * (size *= ratio));
        out.back() = begin + sign * length;
    };
    outwards(from, from - low, -1.0, below);
    planes.assign(below.rbegin(), below.rend());
    for (int k = 0; k <= inner; ++k) planes.push_back(from + (to - from) * k / inner);
    outwards(to, high - to, 1.0, planes);
    return planes;
}

void hold(const std::vector<char>& held, Eigen::SparseMatrix<double>& k) {
    for (Index column = 0; column < k.outerSize(); ++column)
        for (Eigen::SparseMatrix<double>::InnerIterator entry(k, column); entry; ++entry)
            if (held[static_cast<std::size_t>(entry.row())] || held[static_cast<std::size_t>(column)])
                entry.valueRef() = entry.row() == column ? 1.0 : 0.0;
}

std::vector<Eigen::Matrix3d> brick_compliances(const Box& box, const Lame& material,
                                               std::span<const Footprint> footprints) {
    const Grid grid(box.plane_m);
    Eigen::SparseMatrix<double> k = assemble_bricks(grid, material);
    if (box.quarter) mirror(grid, k);
    const Factor factor(k);
    if (!(factor.weakest_pivot().ratio > 0.0)) throw Error("the bench's box of bricks is not held");
    std::vector<std::int32_t> unknown;
    for (std::int32_t node = 0; node < grid.node_count(); ++node)
        unknown.push_back(std::max(-1, node - grid.held_count()));
    std::vector<LoadShares> loads;
    for (const Footprint& footprint : footprints)
        loads.push_back(shares_on_top(grid, box.plane_m[2].back(), footprint));
    auto c = compliances(factor, loads, unknown);
    // A quarter gives under 1 N on it as the whole under 4 N.
    if (box.quarter)
        for (auto& one : c) one /= 4.0;
    return c;
}

}  // namespace haptable
