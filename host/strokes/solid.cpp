// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/solid.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/error.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Point point_of(const Vector3d& x) { return {x.x(), x.y(), x.z()}; }

/// Every edge has an even number of triangles, so that one can say what is inside.
void require_closed(const std::vector<std::array<std::uint16_t, 3>>& triangles) {
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::size_t> edges;
    for (const auto& t : triangles)
        for (std::size_t c = 0; c < 3; ++c) ++edges[std::minmax(t[c], t[(c + 1) % 3])];
    for (const auto& [edge, count] : edges)
        if (count % 2 != 0) throw Error("the touchable surface is not closed: it has no inside to judge strokes by");
}

/// Whether the segment p -> q crosses a triangle, with exact predicates; nothing where it meets an edge, a corner or
/// the plane, which another q will not.
std::optional<bool> crosses(const Point& p, const Point& q, const Triangle& t) {
    const CGAL::Orientation start = CGAL::orientation(t[0], t[1], t[2], p),
                            end = CGAL::orientation(t[0], t[1], t[2], q);
    if (start == CGAL::COPLANAR || end == CGAL::COPLANAR) return std::nullopt;
    if (start == end) return false;
    int sum = 0;
    for (int c = 0; c < 3; ++c) {
        const CGAL::Orientation side = CGAL::orientation(p, q, t[c], t[(c + 1) % 3]);
        if (side == CGAL::COPLANAR) return std::nullopt;
        sum += side == CGAL::POSITIVE ? 1 : -1;
    }
    return std::abs(sum) == 3;
}

}  // namespace

struct Solid::Trees {
    std::vector<Triangle> triangle;
    Tree tree;

    std::size_t number(Tree::Primitive_id of) const { return static_cast<std::size_t>(of - triangle.begin()); }
    std::vector<Tree::Primitive_id> met(const Kernel::Segment_3& by) const {
        std::vector<Tree::Primitive_id> list;
        tree.all_intersected_primitives(by, std::back_inserter(list));
        return list;
    }
};

Solid::Solid(const std::vector<std::array<float, 3>>& point, const std::vector<Corners>& triangle)
    : trees_(std::make_shared<Trees>()), corners_(triangle), around_(point.size()) {
    Eigen::AlignedBox3d box;
    for (const auto& p : point) {
        box.extend(point_.emplace_back(Eigen::Map<const Eigen::Vector3f>(p.data()).cast<double>()));
        reach_m_ = std::max(reach_m_, point_.back().lpNorm<Eigen::Infinity>());
    }
    size_m_ = box.diagonal().norm();
    require_closed(triangle);
    for (std::size_t t = 0; t < triangle.size(); ++t) {
        const Corners& v = triangle[t];
        for (const std::uint16_t vertex : v) around_[vertex].push_back(t);
        trees_->triangle.emplace_back(point_of(point_[v[0]]), point_of(point_[v[1]]), point_of(point_[v[2]]));
    }
    trees_->tree.rebuild(trees_->triangle.begin(), trees_->triangle.end());
    trees_->tree.accelerate_distance_queries();
}

/// The parity of a segment to far outside. One that meets an edge tells nothing; the next one goes elsewhere.
bool Solid::holds(const Vector3d& x) const {
    constexpr int kTries = 16;
    const double far = 4.0 * (size_m_ + reach_m_ + x.norm());
    for (int tries = 0; tries < kTries; ++tries) {
        const Vector3d direction(std::cos(1.0 + 2.4 * tries), std::sin(1.0 + 2.4 * tries), 0.3 + 0.1 * tries);
        const Point p = point_of(x), q = point_of(x + far * direction);
        bool is_odd = false, is_told = true;
        for (const auto& triangle : trees_->met({p, q})) {
            const std::optional<bool> crossed = crosses(p, q, *triangle);
            is_told &= crossed.has_value();
            is_odd ^= crossed.value_or(false);
        }
        if (is_told) return is_odd;
    }
    return false;  // on the surface itself
}

double Solid::gap_m(const Vector3d& x) const { return std::sqrt(trees_->tree.squared_distance(point_of(x))); }

bool Solid::sees(const Vector3d& from, const Vector3d& to) const {
    if (from == to) return true;  // no segment to CGAL
    return !trees_->tree.do_intersect(Kernel::Segment_3(point_of(from), point_of(to)));
}

std::vector<Solid::Entry> Solid::entries(const Vector3d& from, const Vector3d& to, double near_m) const {
    if (from == to) return {};
    std::vector<Entry> list;
    for (const auto& crossed : trees_->met({point_of(from), point_of(to)})) {
        const std::size_t triangle = trees_->number(crossed);
        const Vector3d &a = point_[corners_[triangle][0]], n = normal(triangle);
        const double start = n.dot(from - a), end = n.dot(to - a);
        const bool is_along = std::max(std::abs(start), std::abs(end)) <= near_m;
        if (end >= start && !is_along) continue;
        const double fraction = is_along ? 0.0 : std::clamp(start / (start - end), 0.0, 1.0);
        list.push_back({triangle, from + fraction * (to - from)});
    }
    return list;
}

Solid::Entry Solid::nearest(const Vector3d& x) const {
    const auto [point, triangle] = trees_->tree.closest_point_and_primitive(point_of(x));
    return {trees_->number(triangle), {point.x(), point.y(), point.z()}};
}

Vector3d Solid::normal(std::size_t triangle) const {
    const Corners& v = corners_[triangle];
    return (point_[v[1]] - point_[v[0]]).cross(point_[v[2]] - point_[v[0]]).normalized();
}

/// Which corner of a triangle a vertex is; 3: none.
std::size_t Solid::corner(std::size_t triangle, std::uint16_t vertex) const {
    const Corners& v = corners_[triangle];
    return static_cast<std::size_t>(std::find(v.begin(), v.end(), vertex) - v.begin());
}

double Solid::angle(std::size_t triangle, std::uint16_t vertex) const {
    const Corners& v = corners_[triangle];
    const std::size_t c = corner(triangle, vertex);
    const Vector3d a = point_[v[(c + 1) % 3]] - point_[vertex], b = point_[v[(c + 2) % 3]] - point_[vertex];
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// From triangle to triangle over the edges at a vertex, one comes to all of them.
bool Solid::is_one_ring(std::uint16_t vertex) const {
    const std::vector<std::size_t>& all = around_[vertex];
    std::vector<std::size_t> ring{all.front()};
    for (std::size_t k = 0; k < ring.size(); ++k)
        for (std::size_t t : all)
            for (std::uint16_t other : corners_[ring[k]])
                if (other != vertex && corner(t, other) < 3 && std::find(ring.begin(), ring.end(), t) == ring.end())
                    ring.push_back(t);
    return ring.size() == all.size();
}

std::optional<Vector3d> Solid::outward(std::size_t triangle, const Vector3d& alpha) const {
    std::vector<std::uint16_t> on;  // the vertices that the point lies between
    for (std::size_t c = 0; c < 3; ++c)
        if (alpha[static_cast<Eigen::Index>(c)] > 0.0) on.push_back(corners_[triangle][c]);
    if (on.size() == 3) return normal(triangle);
    Vector3d sum = Vector3d::Zero();
    std::size_t count = 0;
    for (std::size_t t : around_[on.front()]) {
        if (corner(t, on.back()) == 3) continue;
        sum += (on.size() == 1 ? angle(t, on.front()) : 1.0) * normal(t);
        ++count;
    }
    if (on.size() == 2 ? count != 2 : !is_one_ring(on.front())) return std::nullopt;
    return sum.normalized();
}

void Whereabouts::measure(const Vector3d& x) {
    at_ = x;
    gap_m_ = solid_->gap_m(x);
    inside_ = solid_->holds(x);
}

bool Whereabouts::is_inside(const Vector3d& x) {
    if ((x - at_).norm() >= gap_m_) measure(x);
    return inside_;
}

bool Whereabouts::is_beyond(const Vector3d& x, double gap_m) {
    const double motion_m = (x - at_).norm();
    if (gap_m_ - motion_m > gap_m) return true;
    if (gap_m_ >= 0.0 && gap_m_ + motion_m <= gap_m) return false;
    measure(x);
    return gap_m_ > gap_m;
}

}  // namespace haptable
