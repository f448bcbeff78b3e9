// SPDX-License-Identifier: GPL-2.0-or-later
// Distances over surfaces whose unfolding is known, and the masks made of them.
#include "host/body/mask.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

#include "host/body/geodesic.hpp"
#include "host/compliance/point_compliance.hpp"
#include "tests/host/body/cubes.hpp"
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

Shape grid(int cells, double side) {
    return grid(cells, side, [](double x, double y) { return Vector3d(x, y, 0.0); });
}

// A plane, folded along x = 0.6 by any angle: on a regular grid every way passes vertices, on a skewed one none does.
TEST(SurfaceDistance, OverAFoldItIsTheUnfoldedLine) {
    for (double skew : {0.0, 0.04})
        for (double angle : {0.0, 0.5, 1.5, 3.0}) {
            const Shape flat = grid(12, 1.2, [&](double x, double y) {
                return Vector3d(x + skew * std::sin(5 * y) * std::sin(5.0 / 3.0 * std::numbers::pi * x),
                                y + skew * std::sin(7 * x), 0.0);
            });
            Shape folded = flat;
            for (auto& p : folded.point)
                if (p.x() > 0.6)
                    p = Vector3d(0.6 + (p.x() - 0.6) * std::cos(angle), p.y(), (p.x() - 0.6) * std::sin(angle));
            const SurfaceGraph surface(folded.point, folded.patch);
            const auto expect_straight = [&](const SurfaceDistance::Distances& found, const Vector3d& from) {
                for (const auto& [node, d] : found)
                    EXPECT_WITHIN(std::abs(d - (flat.point[std::size_t(node)] - from).norm()), unfolded(1.2));
                const auto near = [&](const Vector3d& p) { return (p - from).norm() < 0.39; };
                EXPECT_EQ(std::ssize(found), std::count_if(flat.point.begin(), flat.point.end(), near));
            };
            SurfaceDistance search(surface);
            expect_straight(search.from_node(69, 0.39), flat.point[69]);
            expect_straight(search.from_edge(69, 70, 0.39), 0.5 * (flat.point[69] + flat.point[70]));
        }
}

/// Shortest ways over a closed surface or one with a border, by no cleverness: from every node every straight way over
/// every patch within reach, and then from node to node over any others.
class EveryWay {
public:
    EveryWay(const Shape& shape, double reach) : shape_(shape), reach_(reach) {
        const std::size_t nodes = shape.point.size();
        distance_.assign(nodes, std::vector<double>(nodes, HUGE_VAL));
        for (const auto& patch : shape.patch)
            for (std::size_t c = 0; c < 3; ++c) third_[{patch[c], patch[(c + 1) % 3]}] = patch[(c + 2) % 3];
        for (const auto& patch : shape.patch)
            for (std::size_t c = 0; c < 3; ++c) look_from(patch[c], patch[(c + 1) % 3], patch[(c + 2) % 3]);
        for (std::size_t over = 0; over < nodes; ++over)
            for (auto& row : distance_)
                for (std::size_t to = 0; to < nodes; ++to) row[to] = std::min(row[to], row[over] + distance_[over][to]);
    }
    double between(std::int32_t from, std::int32_t to) const { return distance_[std::size_t(from)][std::size_t(to)]; }

private:
    using Vector2d = Eigen::Vector2d;
    static double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
    double length(int a, int b) const { return (shape_.point[std::size_t(a)] - shape_.point[std::size_t(b)]).norm(); }
    /// The third corner on the right of a to b, at these places.
    static Vector2d corner(const Vector2d& a, const Vector2d& b, double from_a, double from_b) {
        const Vector2d along = (b - a).normalized();
        const double base = (b - a).norm(), x = (base * base + from_a * from_a - from_b * from_b) / (2.0 * base);
        return a + x * along + std::sqrt(std::max(0.0, from_a * from_a - x * x)) * Vector2d(along.y(), -along.x());
    }
    void look_from(int source, int a, int b) {
        source_ = source;
        const Vector2d at_a(length(source, a), 0.0);
        const Vector2d at_b = corner(at_a, Vector2d::Zero(), length(a, b), length(source, b));
        see(a, at_a.norm());
        see(b, at_b.norm());
        look_through(a, b, at_a, at_b, at_a, at_b);
    }
    void see(int node, double d) {
        double& known = distance_[std::size_t(source_)][std::size_t(node)];
        known = std::min(known, d);
    }
    /// Through the edge from a to b, between two directions.
    void look_through(int a, int b, const Vector2d& at_a, const Vector2d& at_b, const Vector2d& low,
                      const Vector2d& high) {
        const Vector2d along = (at_b - at_a).normalized();
        const double t = std::clamp(-at_a.dot(along), 0.0, (at_b - at_a).norm());
        const auto behind = third_.find({b, a});
        if (behind == third_.end() || (at_a + t * along).norm() > reach_) return;
        const int c = behind->second;
        const Vector2d at_c = corner(at_a, at_b, length(a, c), length(b, c));
        const double after_low = cross(low, at_c), before_high = cross(at_c, high), little = 1e-12 * at_c.norm();
        if (after_low >= -little && before_high >= -little) see(c, at_c.norm());
        if (after_low > little) look_through(a, c, at_a, at_c, low, before_high > 0.0 ? at_c : high);
        if (before_high > little) look_through(c, b, at_c, at_b, after_low > 0.0 ? at_c : low, high);
    }

    const Shape& shape_;
    double reach_;
    int source_ = 0;
    std::map<std::pair<int, int>, int> third_;  // behind a directed edge
    std::vector<std::vector<double>> distance_;
};

/// The surface with a node more, in the middle of an edge; its number is the number of nodes before.
Shape split_edge(Shape shape, int a, int b) {
    const auto middle = int(shape.point.size());
    shape.point.push_back(0.5 * (shape.point[std::size_t(a)] + shape.point[std::size_t(b)]));
    const auto patches = shape.patch;
    shape.patch.clear();
    for (const auto& patch : patches) {
        shape.patch.push_back(patch);
        for (std::size_t c = 0; c < 3; ++c) {
            const int from = patch[c], to = patch[(c + 1) % 3];
            if (!(from == a && to == b) && !(from == b && to == a)) continue;
            shape.patch.back() = {from, middle, patch[(c + 2) % 3]};
            shape.patch.push_back({middle, to, patch[(c + 2) % 3]});
        }
    }
    return shape;
}

TEST(SurfaceDistance, OverHillsAndSaddlesItIsTheShortestOfAllWays) {
    // An open surface with hills, pits and saddles; and a closed lump that ways go round on both sides.
    const Shape hills = grid(8, 0.8, [](double x, double y) {
        return Vector3d(x + 0.02 * std::sin(31 * y), y + 0.02 * std::sin(27 * x),
                        0.12 * std::sin(9 * x + 2 * y) * std::cos(8 * y));
    });
    Shape lump = box_shape(3, Vector3d(0.3, 0.2, 0.2));
    for (Vector3d& p : lump.point)
        p += 0.02 * Vector3d(std::sin(41 * p.y() + 7 * p.z()), std::sin(37 * p.z() + 1), std::sin(43 * p.x() + 2));
    // A plane without a quadrant, where ways bend; and a thin plate, through which there is none.
    Shape corner = grid(8, 0.8);
    std::erase_if(corner.patch, [&](const auto& p) {
        return std::all_of(p.begin(), p.end(), [&](int i) { return i % 9 >= 4 && i / 9 >= 4; });
    });
    const Shape plate = box_shape(4, Vector3d(0.4, 0.4, 0.004));
    for (const auto& [shape, reach, more_saddles_than] :
         {std::tuple(hills, 0.45, 5), {lump, 0.4, 5}, {corner, 0.77, -1}, {plate, 0.23, -1}}) {
        const SurfaceGraph surface(shape.point, shape.patch);
        EXPECT_GT(std::count(surface.turn.begin(), surface.turn.end(), SurfaceGraph::Turn::kSaddle), more_saddles_than);
        const EveryWay every(shape, reach);
        SurfaceDistance search(surface);
        const auto nodes = std::int32_t(shape.point.size());
        // Not where a way is as long as the reach, to rounding.
        const auto compare = [&](const SurfaceDistance::Distances& found, const EveryWay& ways, std::int32_t from) {
            std::map<std::int32_t, double> near;
            for (const auto& [node, d] : found) near[node] = d;
            for (std::int32_t to = 0; to < nodes; ++to) {
                const double expected = to == from ? 0.0 : ways.between(from, to);
                if (std::abs(expected - reach) < 1e-9) continue;
                ASSERT_EQ(near.contains(to), expected < reach) << from << " to " << to << ": " << expected;
                if (!near.contains(to)) continue;
                EXPECT_WITHIN(std::abs(near.at(to) - expected), unfolded(0.8)) << from << " to " << to;
            }
        };
        for (std::int32_t from = 0; from < nodes; ++from) compare(search.from_node(from, reach), every, from);
        for (std::size_t p = 0; p < shape.patch.size(); p += 17) {
            const std::int32_t a = shape.patch[p][0], b = shape.patch[p][1];
            const Shape split = split_edge(shape, a, b);
            compare(search.from_edge(a, b, reach), EveryWay(split, reach), nodes);
        }
    }
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
                              .count = 4.0 * double(w.weight.size()));
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

// Which blocks of L they ask for. That their compliance is w^T L w, tests/firmware/compliance_test.cpp shows.
TEST(MaskPairs, AreThoseUnderOnePatchEachOnceAndAscending) {
    const Shape shape = box_shape(6, Eigen::Vector3d(0.03, 0.03, 0.03));  // its bottom is held
    std::vector<std::int32_t> unknown(shape.point.size(), -1);
    std::int32_t free = 0;
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (shape.point[i].z() > 1e-9) unknown[i] = free++;
    Workers workers(1);
    Progress quiet(true);
    const Masks masks = make_masks(shape.point, shape.patch, 0.008, workers, quiet);
    const std::vector<NodePair> pairs = mask_pairs(masks, unknown, workers);
    std::set<std::pair<int, int>> expected, found;
    for (const auto& controls : masks.control)
        for (std::size_t j : controls)
            for (std::size_t k : controls)
                for (std::int32_t a : masks.weights(j).node)
                    for (std::int32_t b : masks.weights(k).node)
                        if (const auto [low, high] = std::minmax(unknown[std::size_t(a)], unknown[std::size_t(b)]);
                            low >= 0)
                            expected.insert({low, high});
    for (const NodePair& p : pairs) EXPECT_TRUE(found.insert({p.row, p.column}).second);
    EXPECT_EQ(found, expected);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end(), [](const NodePair& a, const NodePair& b) {
        return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    }));
}

/// The top of a cube of quadratic tetrahedra, 1.2 m wide; up to that x it may be touched.
Body quadratic_top(int cells, double up_to_x = 2.0) {
    Scene scene = cube_of("cube", cells + 1, {1e4, 0.3}, Element::kQuadratic);
    scene.mesh.side_m = 1.2;
    scene.touch = {box(-1, -1, 1.2 - 1e-9, up_to_x, 2, 2)};
    return make_body(scene, make_mesh(scene.mesh));
}
Masks masks_on(const Body& body, double radius) {
    Workers alone(1);
    Progress progress(true);
    return make_masks(body.mesh.position_m, body.touch_patch, radius, alone, progress, body.touch_quarter);
}

/// Of a polynomial over the nodes under a mask.
double moment(const NodeWeights& w, const std::vector<Vector3d>& point,
              const std::function<double(const Vector3d&)>& f) {
    double sum = 0.0;
    for (std::size_t k = 0; k < w.node.size(); ++k) sum += w.weight[k] * f(point[std::size_t(w.node[k])]);
    return sum;
}

// The shape functions hold quadratic functions exactly, so the nodal forces of a pressure have its moments up to the
// second: 1, where it stands, and of k = (1 - (r / R)^2)^2 the mean square r^2 = R^2 / 4.
TEST(Masks, OnQuadraticFacesTheyHaveThePressuresMoments) {
    const Body body = quadratic_top(8);
    const std::vector<Vector3d>& point = body.mesh.position_m;
    for (double radius : {0.2, 0.37}) {
        const Masks masks = masks_on(body, radius);
        int checked = 0;
        for (std::size_t v = 0; v < masks.vertex_id.size(); ++v) {
            const Vector3d at = point[std::size_t(masks.vertex_id[v])];
            if (std::min({at.x(), at.y(), 1.2 - at.x(), 1.2 - at.y()}) < radius) continue;
            ++checked;
            const NodeWeights& w = masks.vertex[v];
            EXPECT_WITHIN(std::abs(moment(w, point, [](const Vector3d&) { return 1.0; }) - 1.0), .count = 64);
            // The rim is cut by triangles of an eighth of the radius: their third order.
            const Bound rim{.count = 0.25, .epsilon = 1.0 / 512.0};
            EXPECT_WITHIN(std::abs(moment(w, point, [](const Vector3d& x) { return x.x(); }) - at.x()) / radius, rim);
            EXPECT_WITHIN(std::abs(moment(w, point, [&](const Vector3d& x) { return (x - at).squaredNorm(); }) /
                                       (radius * radius / 4.0) -
                                   1.0),
                          rim);
        }
        EXPECT_GT(checked, 10);
    }
}

TEST(Masks, OnQuadraticFacesAWidePressureRestsOnTheMiddles) {
    const int nodes = 13;  // a side, of the corners, which come first
    const Masks masks = masks_on(quadratic_top(nodes - 1), 0.5);
    const int middle = 6 + 6 * nodes + (nodes - 1) * nodes * nodes;
    const auto at = std::find(masks.vertex_id.begin(), masks.vertex_id.end(), middle) - masks.vertex_id.begin();
    const NodeWeights& w = masks.vertex.at(std::size_t(at));
    double corners = 0.0, middles = 0.0;
    for (std::size_t k = 0; k < w.node.size(); ++k)
        (w.node[k] < nodes * nodes * nodes ? corners : middles) += w.weight[k];
    // Of an even pressure corners have nothing; of this one what its curvature over a face of 0.1 m gives them.
    EXPECT_WITHIN(std::abs(corners), .count = 1.0, .epsilon = 0.1 * 0.1 / (0.5 * 0.5));
    EXPECT_WITHIN(std::abs(corners + middles - 1.0), .count = 64);
}

// Faces beyond x = 0.7 are left out, and of those that reach beyond it quarters.
TEST(Masks, OnQuadraticFacesThatMayBeTouchedInPartTheLoadStaysOnTouchableNodes) {
    const Body body = quadratic_top(6, 0.71);
    const auto parts = std::count_if(body.touch_quarter.begin(), body.touch_quarter.end(),
                                     [](const Quarter& q) { return !q.is_whole; });
    EXPECT_GT(parts, 0);
    const Masks masks = masks_on(body, 0.25);
    for (const auto* list : {&masks.vertex, &masks.edge})
        for (const NodeWeights& w : *list) {
            EXPECT_WITHIN(std::abs(std::accumulate(w.weight.begin(), w.weight.end(), 0.0) - 1.0), .count = 64);
            EXPECT_TRUE(std::includes(body.touch_node.begin(), body.touch_node.end(), w.node.begin(), w.node.end()));
        }
    EXPECT_EQ(masks.widened, 0U);
    const Masks fine = masks_on(body, 0.01);
    EXPECT_EQ(fine.widened, fine.vertex.size() + fine.edge.size()) << "finer than the mesh: the patch's own nodes";
}

}  // namespace
}  // namespace haptable::test
