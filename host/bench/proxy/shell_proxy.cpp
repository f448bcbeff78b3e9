// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/proxy/shell_proxy.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kHysteresis = 0.6;  // of the dynamic cone, below which a proxy that slips holds again

/// How much of the motion a point makes until it comes from outside to within `radius` of the line of x = 0, where both
/// are given without their part along that line (x: where it begins). None where it begins within, or never comes.
std::optional<double> enters(const Vector3d& x, const Vector3d& way, double radius) {
    const double a = way.squaredNorm(), b = x.dot(way), c = x.squaredNorm() - radius * radius;
    const double root = b * b - a * c;
    if (c < 0.0 || b >= 0.0 || root < 0.0) return std::nullopt;
    const double t = (-b - std::sqrt(root)) / a;
    return t <= 1.0 ? std::optional(t) : std::nullopt;
}

}  // namespace

void ShellProxy::begin(const Vector3d& finger_m) {
    at_m_ = finger_m;
    planes_ = 0;
    slips_ = true;
}

void ShellProxy::meet_shell(const PatchTree::Triangle& triangle, const Vector3d& goal_m, Hit& first) const {
    const auto& [a, b, c] = triangle.corner;
    const Vector3d way = goal_m - at_m_;
    const double length = way.norm();
    const auto keep = [&](double t, const Vector3d& normal) {
        if (t * length <= first.distance_m) first = {t * length, at_m_ + t * way, normal};
    };
    const Vector3d normal = (b - a).cross(c - a).normalized();
    for (const double side : {1.0, -1.0}) {
        const Vector3d up = side * normal, from = at_m_ - a - radius_m_ * up;
        const double height = up.dot(from), fall = -up.dot(way);
        if (fall <= 0.0 || height < 0.0 || height > fall) continue;
        const double t = height / fall;
        const Vector3d e = b - a, f = c - a, p = from + t * way;
        const double ee = e.dot(e), ef = e.dot(f), ff = f.dot(f), pe = p.dot(e), pf = p.dot(f);
        const double whole = ee * ff - ef * ef, s = (ff * pe - ef * pf) / whole, r = (ee * pf - ef * pe) / whole;
        if (s >= 0.0 && r >= 0.0 && s + r <= 1.0) keep(t, up);
    }
    for (const Vector3d& corner : triangle.corner)
        if (const auto t = enters(at_m_ - corner, way, radius_m_)) keep(*t, (at_m_ + *t * way - corner).normalized());
    for (std::size_t i = 0; i < 3; ++i) {
        const Vector3d &p = triangle.corner[i], along = triangle.corner[(i + 1) % 3] - p;
        const Vector3d axis = along.normalized(), from = at_m_ - p;
        const auto t = enters(from - from.dot(axis) * axis, way - way.dot(axis) * axis, radius_m_);
        if (!t) continue;
        const Vector3d at = from + *t * way;
        const double place = at.dot(axis);
        if (place >= 0.0 && place <= along.norm()) keep(*t, (at - place * axis).normalized());
    }
}

ShellProxy::Hit ShellProxy::meet(const Vector3d& goal_m) const {
    Hit first;
    tree_.visit(at_m_, goal_m, radius_m_, [&](const PatchTree::Triangle& t) { meet_shell(t, goal_m, first); });
    return first;
}

/// The finger; on the first plane; on the line of the two.
Vector3d ShellProxy::goal(const Vector3d& finger_m) const {
    const Vector3d beyond = finger_m - at_m_;
    if (planes_ == 0) return finger_m;
    if (planes_ == 1) return finger_m - beyond.dot(normal_[0]) * normal_[0];
    const Vector3d line = normal_[0].cross(normal_[1]);
    return line.isZero(0.0) ? at_m_ : Vector3d(at_m_ + beyond.dot(line) / line.squaredNorm() * line);
}

/// As far as it goes, with the gap left to what it met.
void ShellProxy::stop_at(const Hit& hit, const Vector3d& way) {
    const double back_m = std::min(gap_m_ / std::abs(way.dot(hit.normal)), std::max(hit.distance_m, gap_m_));
    at_m_ = hit.at_m - back_m * way;
    if (planes_ < 2) normal_[planes_] = hit.normal;
    planes_ = (planes_ + 1) % 3;
}

/// To a goal that nothing is before: on planes as far as friction lets it.
void ShellProxy::glide(const Vector3d& goal_m, const Vector3d& finger_m) {
    const double way_m = (goal_m - at_m_).norm();
    double held_m = 0.0;
    if (planes_ == 0) {
        slips_ = true;
    } else if (static_friction_ > 0.0) {
        const Vector3d normal = planes_ == 1 ? normal_[0] : Vector3d(0.5 * (normal_[0] + normal_[1]));
        const double angle = std::acos(std::clamp((at_m_ - finger_m).normalized().dot(normal), -1.0, 1.0));
        slips_ = slips_ ? angle >= kHysteresis * std::atan(dynamic_friction_) : angle > std::atan(static_friction_);
        held_m = std::abs((at_m_ - finger_m).dot(normal)) * (slips_ ? dynamic_friction_ : static_friction_);
    }
    if (way_m > held_m) at_m_ = goal_m + held_m / way_m * (at_m_ - goal_m);
    planes_ = 0;
}

const Vector3d& ShellProxy::to(const Vector3d& finger_m) {
    const Vector3d goal_m = goal(finger_m), beyond = goal_m - at_m_;
    const double way_m = beyond.norm();
    if (way_m < gap_m_) {
        planes_ = 0;
        return at_m_;
    }
    const Vector3d way = beyond / way_m;
    const Hit hit = meet(goal_m + gap_m_ * way);
    if (hit.distance_m <= way_m)
        stop_at(hit, way);
    else
        glide(goal_m, finger_m);
    return at_m_;
}

}  // namespace haptable
