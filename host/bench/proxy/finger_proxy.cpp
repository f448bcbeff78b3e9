// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/proxy/finger_proxy.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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
void FingerProxy::meet_triangle(const PatchTree::Triangle& triangle, const Vector3d& way,
                                std::optional<Hit>& first) const {
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

/// What the sphere meets first on its way to the goal.
std::optional<FingerProxy::Hit> FingerProxy::meet(const Vector3d& goal_m) const {
    const Vector3d way = goal_m - at_m_;
    std::optional<Hit> first;
    tree_.visit(at_m_, goal_m, radius_m_,
                [&](const PatchTree::Triangle& triangle) { meet_triangle(triangle, way, first); });
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
