// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/proxy/finger_proxy.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace haptable {

namespace {

using Eigen::Vector3d;

/// When a point that moves by `way` is first within `radius` of the origin's line along `axis` (a unit vector), or of
/// the origin itself where `axis` is zero; `from`: where it begins. None where it moves away, or never is.
std::optional<double> reaches(const Vector3d& from, const Vector3d& way, const Vector3d& axis, double radius) {
    const Vector3d x = from - from.dot(axis) * axis, v = way - way.dot(axis) * axis;
    const double a = v.squaredNorm(), b = x.dot(v), c = x.squaredNorm() - radius * radius;
    if (b >= 0.0) return std::nullopt;
    if (c <= 0.0) return 0.0;
    const double root = b * b - a * c;
    if (root < 0.0) return std::nullopt;
    const double t = (-b - std::sqrt(root)) / a;
    return t <= 1.0 ? std::optional(t) : std::nullopt;
}

}  // namespace

FingerProxy::FingerProxy(std::vector<Vector3d> point_m, const std::vector<Patch>& patch, double radius_m)
    : radius_m_(radius_m), gap_m_(0.01 * radius_m) {
    for (const Patch& p : patch) {
        Triangle t;
        for (std::size_t c = 0; c < 3; ++c) t.corner[c] = point_m[static_cast<std::size_t>(p[c])];
        t.normal = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).normalized();
        triangle_.push_back(t);
    }
    std::vector<std::int32_t> order(patch.size());
    std::iota(order.begin(), order.end(), 0);
    build(order, 0, order.size());
}

/// Halves of as many patches, by their middle along the longest axis.
void FingerProxy::build(std::vector<std::int32_t>& patch, std::size_t begin, std::size_t end) {
    const auto of = [&](std::int32_t p) -> const Triangle& { return triangle_[static_cast<std::size_t>(p)]; };
    Eigen::AlignedBox3d bounds;
    for (std::size_t i = begin; i < end; ++i)
        for (const Vector3d& corner : of(patch[i]).corner) bounds.extend(corner);
    const std::size_t index = box_.size();
    box_.push_back({bounds.min(), bounds.max(), 0, end - begin == 1 ? patch[begin] : -1});
    if (end - begin > 1) {
        Eigen::Index axis = 0;
        bounds.sizes().maxCoeff(&axis);
        const std::size_t middle = begin + (end - begin) / 2;
        const auto place = [&](std::int32_t p) {
            return of(p).corner[0][axis] + of(p).corner[1][axis] + of(p).corner[2][axis];
        };
        const auto first = patch.begin();
        std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                         first + static_cast<std::ptrdiff_t>(end),
                         [&](std::int32_t a, std::int32_t b) { return place(a) < place(b); });
        build(patch, begin, middle);
        build(patch, middle, end);
    }
    box_[index].skip = static_cast<std::uint32_t>(box_.size());
}

void FingerProxy::meet_corner(const Vector3d& corner, const Vector3d& way, std::optional<Hit>& first) const {
    const auto t = reaches(at_m_ - corner, way, Vector3d::Zero(), radius_m_);
    if (!t || (first && *t >= first->fraction)) return;
    const Vector3d at = at_m_ + *t * way;
    first = Hit{*t, at, (at - corner).normalized()};
}

void FingerProxy::meet_edge(const Vector3d& a, const Vector3d& b, const Vector3d& way,
                            std::optional<Hit>& first) const {
    const double length = (b - a).norm();
    const Vector3d axis = (b - a) / length;
    const auto t = reaches(at_m_ - a, way, axis, radius_m_);
    if (!t || (first && *t >= first->fraction)) return;
    const Vector3d at = at_m_ + *t * way;
    const double along = (at - a).dot(axis);
    if (along < 0.0 || along > length) return;
    first = Hit{*t, at, (at - a - along * axis).normalized()};
}

/// From outside of the patch's plane alone: over its inside its plane is met, elsewhere its edges and corners are.
void FingerProxy::meet_triangle(const Triangle& triangle, const Vector3d& way, std::optional<Hit>& first) const {
    const auto& [a, b, c] = triangle.corner;
    const double from = triangle.normal.dot(at_m_ - a), fall = -triangle.normal.dot(way);
    if (fall <= 0.0 || from < 0.0 || from - fall > radius_m_) return;
    const double t = std::max(0.0, (from - radius_m_) / fall);
    if (first && t >= first->fraction) return;
    const Vector3d at = at_m_ + t * way;
    const bool over_ab = (b - a).cross(at - a).dot(triangle.normal) >= 0.0;
    const bool over_bc = (c - b).cross(at - b).dot(triangle.normal) >= 0.0;
    const bool over_ca = (a - c).cross(at - c).dot(triangle.normal) >= 0.0;
    if (over_ab && over_bc && over_ca) {
        first = Hit{t, at, triangle.normal};
        return;
    }
    if (!over_ab) meet_edge(a, b, way, first);
    if (!over_bc) meet_edge(b, c, way, first);
    if (!over_ca) meet_edge(c, a, way, first);
    for (const Vector3d& corner : triangle.corner) meet_corner(corner, way, first);
}

/// What the sphere meets first on its way to the goal: boxes that overlap that of its motion are opened.
std::optional<FingerProxy::Hit> FingerProxy::meet(const Vector3d& goal_m) const {
    const Vector3d low = at_m_.cwiseMin(goal_m).array() - radius_m_;
    const Vector3d high = at_m_.cwiseMax(goal_m).array() + radius_m_;
    const Vector3d way = goal_m - at_m_;
    std::optional<Hit> first;
    for (std::size_t i = 0; i < box_.size();) {
        const Box& box = box_[i];
        if ((box.low.array() > high.array()).any() || (box.high.array() < low.array()).any()) {
            i = box.skip;
            continue;
        }
        if (box.patch >= 0) meet_triangle(triangle_[static_cast<std::size_t>(box.patch)], way, first);
        ++i;
    }
    return first;
}

const Vector3d& FingerProxy::to(const Vector3d& finger_m) {
    std::array<Hit, 3> plane;
    Vector3d goal = finger_m;
    for (std::size_t planes = 0; planes < 3; ++planes) {
        const auto hit = meet(goal);
        if (!hit) {
            at_m_ = goal;
            return at_m_;
        }
        plane[planes] = *hit;
        at_m_ = hit->at_m + gap_m_ * hit->normal;
        const Vector3d beyond = finger_m - at_m_;
        const Vector3d& n = hit->normal;
        goal = at_m_ + beyond - beyond.dot(n) * n;  // on this plane, where the one before does not forbid that
        if (planes == 1 && (goal - at_m_).dot(plane[0].normal) < 0.0) {
            const Vector3d line = plane[0].normal.cross(n);
            const double length2 = line.squaredNorm();
            if (length2 < 1e-12) return at_m_;
            goal = at_m_ + beyond.dot(line) / length2 * line;
        }
    }
    return at_m_;
}

}  // namespace haptable
