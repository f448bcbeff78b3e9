// SPDX-License-Identifier: GPL-2.0-or-later
// The masks' compliance against w^T L w with a dense L, and the same bits for any number of threads.
#include "host/compliance/point_compliance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

/// A box whose bottom is held, masks over it, and any L: symmetric, but not that of a body.
struct Masked {
    Masked(int cells, double radius_m, int threads)
        : shape(box_shape(cells, Vector3d(0.03, 0.03, 0.03))), unknown(shape.point.size(), -1), workers(threads) {
        for (std::size_t i = 0; i < unknown.size(); ++i)
            if (shape.point[i].z() > 1e-9) unknown[i] = free++;
        Progress quiet(true);
        masks = make_masks(shape.point, shape.patch, radius_m, workers, quiet);
        pairs = mask_pairs(masks, unknown, workers);
        std::vector<Matrix3d> l_ij;
        for (const NodePair& p : pairs) l_ij.push_back(block(p.row, p.column));
        c = compute_mask_compliance(masks, shape.point, unknown, pairs, l_ij, workers, quiet);
    }
    /// L_ij: any number for any two rows, L_ji = L_ij^T.
    static Matrix3d block(int i, int j) {
        Matrix3d l;
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) {
                const auto [low, high] = std::minmax({3 * i + a, 3 * j + b});
                l(a, b) = std::sin(1.0 + 12.9898 * low + 78.233 * high);
            }
        return l;
    }

    Shape shape;
    std::vector<std::int32_t> unknown;
    int free = 0;
    Workers workers;
    Masks masks;
    std::vector<NodePair> pairs;
    MaskCompliance c;
};

double binomial(const std::array<int, 3>& n) {
    return std::tgamma(n[0] + n[1] + n[2] + 1) /
           (std::tgamma(n[0] + 1) * std::tgamma(n[1] + 1) * std::tgamma(n[2] + 1));
}

double bernstein(const std::array<int, 3>& n, const Vector3d& alpha) {
    return binomial(n) * std::pow(alpha[0], n[0]) * std::pow(alpha[1], n[1]) * std::pow(alpha[2], n[2]);
}

/// The weights of a place on a patch, [free]; or the sum of their terms' magnitudes.
Eigen::VectorXd weights_at(const Masked& body, std::size_t patch, const Vector3d& alpha, bool magnitudes) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(body.free);
    for (std::size_t k = 0; k < 6; ++k) {
        std::array<int, 3> n{};
        if (k < 3) n[k] = 2;
        for (std::size_t a = 0; k >= 3 && a < 3; ++a) n[a] = a == k - 3 ? 0 : 1;
        const NodeWeights& mask = body.masks.weights(body.masks.control[patch][k]);
        for (std::size_t i = 0; i < mask.node.size(); ++i)
            if (const int u = body.unknown[std::size_t(mask.node[i])]; u >= 0)
                w[u] += bernstein(n, alpha) * (magnitudes ? std::abs(mask.weight[i]) : mask.weight[i]);
    }
    return w;
}

/// The polynomial of the tables there.
Matrix3d polynomial_at(const Masked& body, std::size_t patch, const Vector3d& alpha) {
    const auto& control = body.masks.control[patch];
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3, d = (a + 2) % 3;
        std::array<int, 3> n{};
        n[a] = 4;
        sum += bernstein(n, alpha) * body.c.vertex[control[a]];
        n = {1, 1, 1};
        n[a] = 2;
        sum += bernstein(n, alpha) * body.c.patch[patch][a];
        const bool turned = control[b] > control[d];  // the edge's blocks stand from its lower vertex
        for (int from_high = 1; from_high <= 3; ++from_high) {
            n = {};
            n[turned ? d : b] = 4 - from_high;
            n[turned ? b : d] = from_high;
            const auto& blocks = body.c.edge[control[3 + a] - body.masks.vertex.size()];
            sum += bernstein(n, alpha) * blocks[std::size_t(from_high - 1)];
        }
    }
    return sum;
}

TEST(MaskCompliance, IsThatOfADenseL) {
    // 2 mm reaches no other node: many masks at the bottom have fixed nodes only, and no compliance.
    for (double radius : {0.002, 0.008}) {
        const Masked body(10, radius, 1);
        MatrixXd l(3 * body.free, 3 * body.free);
        for (int i = 0; i < body.free; ++i)
            for (int j = 0; j < body.free; ++j) l.block<3, 3>(3 * i, 3 * j) = Masked::block(i, j);
        for (std::size_t p = 0; p < body.shape.patch.size(); p += 7)
            for (const Vector3d& alpha :
                 {Vector3d(1, 0, 0), Vector3d(0, 0.5, 0.5), Vector3d(0.2, 0.5, 0.3), Vector3d(0.6, 0.1, 0.3)}) {
                const Eigen::VectorXd w = weights_at(body, p, alpha, false);
                Matrix3d expected = Matrix3d::Zero();
                int under = 1;
                for (int i = 0; i < body.free; ++i) under += w[i] != 0.0 ? 1 : 0;
                for (int i = 0; i < body.free; ++i)
                    for (int j = 0; j < body.free && w[i] != 0.0; ++j)
                        expected += w[i] * w[j] * l.block<3, 3>(3 * i, 3 * j);
                // Two sums over the nodes under the place and one over 15 blocks; no |L_ij| is above 1.
                const double size = std::pow(weights_at(body, p, alpha, true).sum(), 2);
                EXPECT_WITHIN((polynomial_at(body, p, alpha) - expected).cwiseAbs().maxCoeff(),
                              .count = 4.0 * std::sqrt(2.0 * under + 15.0), .size = size)
                    << "patch " << p << ", radius " << radius;
            }
    }
}

TEST(MaskCompliance, PairsAreThoseUnderOnePatch) {
    const Masked body(6, 0.008, 1);
    std::set<std::pair<int, int>> expected, found;
    for (const auto& controls : body.masks.control)
        for (std::size_t j : controls)
            for (std::size_t k : controls)
                for (std::int32_t a : body.masks.weights(j).node)
                    for (std::int32_t b : body.masks.weights(k).node)
                        if (const auto [low, high] =
                                std::minmax(body.unknown[std::size_t(a)], body.unknown[std::size_t(b)]);
                            low >= 0)
                            expected.insert({low, high});
    for (const NodePair& p : body.pairs) EXPECT_TRUE(found.insert({p.row, p.column}).second);
    EXPECT_EQ(found, expected);
    EXPECT_TRUE(std::is_sorted(body.pairs.begin(), body.pairs.end(), [](const NodePair& a, const NodePair& b) {
        return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    }));
}

}  // namespace
}  // namespace haptable::test
