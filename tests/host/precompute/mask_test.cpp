// SPDX-License-Identifier: GPL-2.0-or-later
// Distances over surfaces whose unfolding is known, and the masks made of them.
#include "host/precompute/mask.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numeric>

#include "host/precompute/geodesic.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

Shape grid(int cells, double side, const std::function<Vector3d(double, double)>& at) {
    Shape shape{"grid", {}, {}};
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) shape.point.push_back(at(side * i / cells, side * j / cells));
    const auto node = [&](int i, int j) { return i + j * (cells + 1); };
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            shape.patch.push_back({node(i, j), node(i + 1, j), node(i + 1, j + 1)});
            shape.patch.push_back({node(i, j), node(i + 1, j + 1), node(i, j + 1)});
        }
    return shape;
}

/// A window is unfolded over up to 12 patches, some 20 operations each; side: of the surface, m.
Bound unfolded(double side) { return {.count = 12 * 20, .size = side}; }

/// Distances from a node, by node.
std::map<std::int32_t, double> near_node(const Shape& shape, std::int32_t node, double reach_m) {
    const SurfaceGraph surface(shape.point, shape.patch);
    std::map<std::int32_t, double> near;
    for (const auto& [other, d] : SurfaceDistance(surface).from_node(node, reach_m)) near[other] = d;
    return near;
}

TEST(SurfaceDistance, OnAPlaneItIsTheStraightLine) {
    // Not a regular grid: seen past no vertex exactly; and a regular one, where every way passes vertices.
    for (double skew : {0.0, 0.13}) {
        const Shape shape = grid(12, 1.2, [&](double x, double y) {
            return Vector3d(x + skew * std::sin(5 * y) * 0.3, y + skew * std::sin(7 * x) * 0.3, 0.5);
        });
        const std::int32_t source = 6 + 6 * 13;
        const auto near = near_node(shape, source, 0.45);
        int expected = 0;
        for (std::size_t i = 0; i < shape.point.size(); ++i) {
            const double d = (shape.point[i] - shape.point[std::size_t(source)]).norm();
            if (d >= 0.45 - 1e-9) continue;
            ++expected;
            ASSERT_TRUE(near.contains(std::int32_t(i))) << i;
            EXPECT_WITHIN(std::abs(near.at(std::int32_t(i)) - d), unfolded(1.2)) << i;
        }
        EXPECT_EQ(near.size(), std::size_t(expected));
        const Vector3d middle = 0.5 * (shape.point[84] + shape.point[85]);
        const SurfaceGraph surface(shape.point, shape.patch);
        for (const auto& [node, d] : SurfaceDistance(surface).from_edge(84, 85, 0.4))
            EXPECT_WITHIN(std::abs(d - (shape.point[std::size_t(node)] - middle).norm()), unfolded(1.2));
    }
}

TEST(SurfaceDistance, OverAFoldItIsTheUnfoldedLine) {
    // A plane that is folded along x = 0.6 by any angle has the distances of the plane.
    const Shape flat = grid(12, 1.2, [](double x, double y) { return Vector3d(x, y, 0); });
    for (double angle : {0.5, 1.5, 3.0}) {
        Shape folded = flat;
        for (auto& p : folded.point)
            if (p.x() > 0.6)
                p = Vector3d(0.6 + (p.x() - 0.6) * std::cos(angle), p.y(), (p.x() - 0.6) * std::sin(angle));
        const auto a = near_node(flat, 4 + 5 * 13, 0.47);
        const auto b = near_node(folded, 4 + 5 * 13, 0.47);
        ASSERT_EQ(a.size(), b.size());
        for (const auto& [node, d] : a) EXPECT_WITHIN(std::abs(b.at(node) - d), unfolded(1.2));
    }
}

TEST(SurfaceDistance, ItBendsAroundAReentrantCorner) {
    // The plane without a quadrant: the way round the corner has two straight parts.
    Shape shape = grid(10, 1.0, [](double x, double y) { return Vector3d(x, y, 0); });
    std::erase_if(shape.patch, [&](const auto& p) {
        return std::all_of(p.begin(), p.end(), [&](int i) {
            return shape.point[std::size_t(i)].x() > 0.499 && shape.point[std::size_t(i)].y() > 0.499;
        });
    });
    const std::int32_t from = 8 + 3 * 11, to = 3 + 8 * 11;  // (0.8, 0.3) and (0.3, 0.8)
    const auto near = near_node(shape, from, 2.0);
    EXPECT_WITHIN(std::abs(near.at(to) - 2.0 * std::hypot(0.3, 0.2)), unfolded(1.0));
}

TEST(SurfaceDistance, NotThroughAThinWall) {
    const Shape plate = box_shape(10, Vector3d(0.1, 0.1, 0.001));
    std::int32_t middle = -1;
    for (std::size_t i = 0; i < plate.point.size(); ++i)
        if ((plate.point[i] - Vector3d(0.05, 0.05, 0.001)).norm() < 1e-9) middle = std::int32_t(i);
    ASSERT_GE(middle, 0);
    for (const auto& [node, d] : near_node(plate, middle, 0.045))
        EXPECT_GT(plate.point[std::size_t(node)].z(), 0.0005) << "the lower side is 101 mm away";
}

TEST(Masks, WeightsSumToOneAndAFineMaskIsItsVertex) {
    const Shape shape = box_shape(6, Vector3d(0.03, 0.03, 0.03));
    Workers alone(1);
    Progress progress(true);
    for (double radius : {0.0001, 0.002, 0.006, 0.012}) {
        const Masks masks = make_masks(shape.point, shape.patch, radius, alone, progress);
        for (const auto* list : {&masks.vertex, &masks.edge})
            for (const NodeWeights& w : *list)
                EXPECT_WITHIN(std::abs(std::accumulate(w.weight.begin(), w.weight.end(), 0.0) - 1.0),
                              .count = 4.0 * static_cast<double>(w.weight.size()));
        const std::size_t places = masks.vertex.size() + masks.edge.size();
        EXPECT_EQ(masks.widened == places, radius < 0.0026) << radius;
        if (radius > 0.0026) continue;
        // Coarser than the mask: w is alpha, that is 2 alpha_v alpha_w (1/2 v + 1/2 w) on edges.
        for (const NodeWeights& w : masks.edge) {
            ASSERT_EQ(w.node.size(), 2U);
            EXPECT_WITHIN(std::abs(w.weight[0] - 0.5), .count = 4);
        }
    }
}

}  // namespace
}  // namespace haptable::test
