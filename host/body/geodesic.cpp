// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/geodesic.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/index.hpp"

namespace haptable {

namespace {

using Eigen::Vector2d;

/// The other corners of a corner's patch, counter-clockwise.
std::int32_t next(std::int32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
std::int32_t previous(std::int32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Distance of point p from the segment between a and b.
double distance_to(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d ab = b - a;
    const double length2 = ab.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
    return (p - a - t * ab).norm();
}

/// Between the segments pq and ab.
double distance_between(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                        const Eigen::Vector3d& b) {
    const Eigen::Vector3d u = q - p, v = b - a, w = p - a;
    const double uu = u.squaredNorm(), uv = u.dot(v), vv = v.squaredNorm(), uw = u.dot(w), vw = v.dot(w);
    const double det = uu * vv - uv * uv, s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
    if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) return (w + s * u - t * v).norm();
    return std::min({distance_to(p, a, b), distance_to(q, a, b), distance_to(a, p, q), distance_to(b, p, q)});
}

// Views that are narrower are none, and a node so far beside a view is seen, both in radians: on a regular grid many
// nodes stand exactly behind another.
constexpr double kRoundingOfLength = 1e-9;
// Added to the view behind a saddle on either side, in radians: more costs windows, none is missed.
constexpr double kWider = 1e-6;

}  // namespace

SurfaceGraph::SurfaceGraph(std::span<const Eigen::Vector3d> position_m,
                           std::span<const std::array<std::int32_t, 3>> patch)
    : around_begin(position_m.size() + 1, 0), turn(position_m.size(), Turn::kNone), full_angle(position_m.size(), 0.0) {
    for (const auto& corners : patch) node.insert(node.end(), corners.begin(), corners.end());
    for (std::int32_t n : node) ++around_begin[at(n) + 1];
    for (std::size_t n = 1; n < around_begin.size(); ++n) around_begin[n] += around_begin[n - 1];
    around.resize(node.size());
    std::vector<std::int32_t> end(around_begin.begin(), around_begin.end() - 1);
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(node.size()); ++c) around[at(end[at(node[at(c)])]++)] = c;
    find_shapes(position_m);
    find_sides();
    find_turns();
    find_clear(position_m);
}

void SurfaceGraph::find_shapes(std::span<const Eigen::Vector3d> position_m) {
    const auto corners = static_cast<std::int32_t>(node.size());
    const auto position = [&](std::int32_t corner) -> const Eigen::Vector3d& {
        return position_m[at(node[at(corner)])];
    };
    for (std::int32_t c = 0; c < corners; ++c) length_m.push_back((position(next(c)) - position(previous(c))).norm());
    for (std::int32_t c = 0; c < corners; ++c) {
        const Eigen::Vector3d u = position(next(c)) - position(c), v = position(previous(c)) - position(c);
        const double twice_area = u.cross(v).norm(), ab = length_m[at(c)], lb = length_m[at(next(c))];
        angle.push_back(std::atan2(twice_area, u.dot(v)));
        full_angle[at(node[at(c)])] += angle.back();
        far_m.emplace_back(lb * std::cos(angle.back()), lb * std::sin(angle.back()));
        apex.emplace_back(v.dot(v - u) / (ab * ab), twice_area / (ab * ab));
    }
}

void SurfaceGraph::find_sides() {
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(node.size()); ++c) {
        const auto [low, high] = std::minmax(node[at(next(c))], node[at(previous(c))]);
        edge.push_back({low, high, c});
    }
    std::sort(edge.begin(), edge.end());
    across.assign(node.size(), -1);
    for (std::size_t first = 0, end = 0; first < edge.size(); first = end) {
        while (end < edge.size() && edge[end][0] == edge[first][0] && edge[end][1] == edge[first][1]) ++end;
        const std::int32_t c = edge[first][2], other = edge[end - 1][2];
        // Two that turn the same way are no part of one side of a body.
        if (end - first == 2 && node[at(next(c))] != node[at(next(other))]) {
            across[at(c)] = other;
            across[at(other)] = c;
        } else {
            turn[at(edge[first][0])] = turn[at(edge[first][1])] = Turn::kAny;
        }
    }
}

/// A shortest way bends only at nodes with more than a full turn around them, and at borders.
void SurfaceGraph::find_turns() {
    for (std::size_t n = 0; n < turn.size(); ++n) {
        if (turn[n] == Turn::kAny || around_begin[n] == around_begin[n + 1]) continue;
        const std::int32_t first = around[at(around_begin[n])];
        std::int32_t in_fan = 1;
        for (std::int32_t c = counter_clockwise(first); c != first; c = counter_clockwise(c)) ++in_fan;
        if (in_fan != around_begin[n + 1] - around_begin[n])
            turn[n] = Turn::kAny;
        else if (full_angle[n] > 2.0 * std::numbers::pi * (1.0 + 1e-9))
            turn[n] = Turn::kSaddle;
    }
}

std::int32_t SurfaceGraph::counter_clockwise(std::int32_t corner) const {
    const std::int32_t behind = across[at(next(corner))];
    return behind < 0 ? -1 : next(behind);
}

std::int32_t SurfaceGraph::clockwise(std::int32_t corner) const {
    const std::int32_t behind = across[at(previous(corner))];
    return behind < 0 ? -1 : previous(behind);
}

/// A way from an edge to a node that is not its own comes to an edge opposite to one of its ends, in a patch that it
/// gets to past that end without turning back, which is within half a turn.
void SurfaceGraph::find_clear(std::span<const Eigen::Vector3d> position_m) {
    const auto position = [&](std::int32_t corner) -> const Eigen::Vector3d& {
        return position_m[at(node[at(corner)])];
    };
    clear_m.resize(node.size());
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(node.size()); ++c) {
        const Eigen::Vector3d &a = position(previous(c)), &b = position(next(c));
        double clear = distance_to(position(c), a, b);
        const auto look_around = [&](std::int32_t end, auto step) {
            double turned = angle[at(end)];
            for (std::int32_t k = (this->*step)(end); k >= 0 && turned < std::numbers::pi; k = (this->*step)(k)) {
                clear = std::min(clear, distance_between(position(next(k)), position(previous(k)), a, b));
                turned += angle[at(k)];
            }
        };
        look_around(previous(c), &SurfaceGraph::clockwise);
        look_around(next(c), &SurfaceGraph::counter_clockwise);
        clear_m[at(c)] = clear * (1.0 - kRoundingOfLength);
    }
}

std::span<const std::array<std::int32_t, 3>> SurfaceGraph::sides(std::int32_t a, std::int32_t b) const {
    const auto [low, high] = std::minmax(a, b);
    const auto first = std::lower_bound(edge.begin(), edge.end(), std::array{low, high, std::int32_t{0}});
    auto end = first;
    while (end != edge.end() && (*end)[0] == low && (*end)[1] == high) ++end;
    return {first, end};
}

SurfaceDistance::SurfaceDistance(const SurfaceGraph& surface)
    : surface_(surface), best_(surface.turn.size(), HUGE_VAL), arrival_(surface.turn.size()) {}

void SurfaceDistance::begin(double reach_m) {
    reach_m_ = reach_m;
    for (std::int32_t node : reached_) best_[at(node)] = HUGE_VAL;
    reached_.clear();
    queue_.clear();
    window_.clear();
}

/// A way to a node. Returns whether it is the shortest so far and may bend there.
bool SurfaceDistance::reach(std::int32_t node, double distance) {
    double& best = best_[at(node)];
    if (!(distance < std::min(best, reach_m_))) return false;
    if (best == HUGE_VAL) reached_.push_back(node);
    best = distance;
    if (surface_.turn[at(node)] == SurfaceGraph::Turn::kNone) return false;
    queue_.push_back({distance, node});
    std::push_heap(queue_.begin(), queue_.end());
    return true;
}

/// Everything that is seen from a node that is `distance` from the source.
void SurfaceDistance::spread(std::int32_t node, double distance) {
    for (std::int32_t k = surface_.around_begin[at(node)]; k < surface_.around_begin[at(node) + 1]; ++k)
        see(surface_.around[at(k)], distance, 0.0, surface_.angle[at(surface_.around[at(k)])]);
}

/// What is seen from a saddle by a way that leaves half a turn on either side: on it, it was not the shortest.
void SurfaceDistance::spread_behind(std::int32_t node, double distance) {
    const double from = std::numbers::pi - kWider, to = surface_.full_angle[at(node)] - from;
    double begin = arrival_[at(node)].rest;
    for (std::int32_t corner = arrival_[at(node)].corner; begin < to;) {
        corner = surface_.counter_clockwise(corner);
        const double angle = surface_.angle[at(corner)];
        if (begin + angle > from) see(corner, distance, std::max(0.0, from - begin), std::min(angle, to - begin));
        begin += angle;
    }
}

/// What is seen from a corner's node between two directions in its patch, angles from the edge to the next corner.
void SurfaceDistance::see(std::int32_t corner, double distance, double from, double to) {
    const std::int32_t corner_a = next(corner), corner_b = previous(corner);
    const double la = surface_.length_m[at(corner_b)], lb = surface_.length_m[at(corner_a)];
    const bool whole = to >= surface_.angle[at(corner)];
    if (from <= 0.0 && reach(surface_.node[at(corner_a)], distance + la))
        arrival_[at(surface_.node[at(corner_a)])] = {corner_a, 0.0};
    if (whole && reach(surface_.node[at(corner_b)], distance + lb))
        arrival_[at(surface_.node[at(corner_b)])] = {corner_b, surface_.angle[at(corner_b)]};
    const Vector2d& at_b = surface_.far_m[at(corner)];
    const Vector2d ray_a = from <= 0.0 ? Vector2d(1.0, 0.0) : Vector2d(std::cos(from), std::sin(from));
    const Vector2d ray_b = whole ? Vector2d(at_b / lb) : Vector2d(std::cos(to), std::sin(to));
    add({{la, 0.0}, at_b, ray_a, ray_b, distance, corner});
}

/// Keeps a window unless nothing new can be seen through it.
void SurfaceDistance::add(const Window& w) {
    // The rays meet the edge in p = s_p ray_a and q = s_q ray_b.
    const Vector2d edge = w.at_b - w.at_a;
    const double twice_area = cross(w.at_a, edge), turn_a = cross(w.ray_a, edge), turn_b = cross(w.ray_b, edge);
    if (!(turn_a > 0.0 && turn_b > 0.0)) return;  // seen edge-on
    const double over_a = 1.0 / turn_a, over_b = 1.0 / turn_b, length = surface_.length_m[at(w.corner)];
    const double s_p = twice_area * over_a, s_q = twice_area * over_b;
    double nearest = twice_area / length;
    if (w.ray_a.dot(edge) >= 0.0)
        nearest = s_p;
    else if (w.ray_b.dot(edge) <= 0.0)
        nearest = s_q;
    const std::int32_t behind = surface_.across[at(w.corner)];
    if (behind < 0 || !(w.base + nearest + surface_.clear_m[at(behind)] < reach_m_)) return;
    // Xin and Wang: a way over an end of the edge that is shorter, to the far end of what is seen, and so to all of it.
    const double shorter = 1.0 - 1e-12;
    const double a_q = cross(w.at_a, w.ray_b) * over_b * length, p_b = cross(w.ray_a, w.at_b) * over_a * length;
    if (best_[at(surface_.node[at(next(w.corner))])] + a_q < (w.base + s_q) * shorter) return;
    if (best_[at(surface_.node[at(previous(w.corner))])] + p_b < (w.base + s_p) * shorter) return;
    window_.push_back(w);
}

/// Unfolds the patch behind the window's edge, of that corner: its third node, and the windows on its two other edges.
void SurfaceDistance::look_through(const Window& w, std::int32_t behind) {
    const std::int32_t corner_a = previous(behind), corner_b = next(behind), c = surface_.node[at(behind)];
    const Vector2d edge = w.at_b - w.at_a, apex = surface_.apex[at(behind)];
    const Vector2d at_c = w.at_a + apex.x() * edge + apex.y() * Vector2d(edge.y(), -edge.x());
    const double rounding = kRoundingOfLength * at_c.lpNorm<1>();
    const double from_a = cross(w.ray_a, at_c), to_b = cross(at_c, w.ray_b);
    Vector2d ray_c = at_c;
    if (from_a >= -rounding && to_b >= -rounding) {
        const double far = at_c.norm();
        ray_c *= 1.0 / far;
        if (reach(c, w.base + far)) {
            const Vector2d to_a = w.at_a - at_c;
            arrival_[at(c)] = {behind, std::max(0.0, std::atan2(cross(to_a, at_c), -to_a.dot(at_c)))};
        }
    }
    const bool beyond_a = from_a > rounding, before_b = to_b > rounding;
    if (beyond_a) add({w.at_a, at_c, w.ray_a, before_b ? ray_c : w.ray_b, w.base, corner_b});
    if (before_b) add({at_c, w.at_b, beyond_a ? ray_c : w.ray_a, w.ray_b, w.base, corner_a});
}

/// Everything that one source sees: the nearer patches before those behind them.
void SurfaceDistance::look_through_all() {
    for (std::size_t w = 0; w < window_.size(); ++w) {
        const Window window = window_[w];  // a copy: more windows come
        look_through(window, surface_.across[at(window.corner)]);
    }
    window_.clear();
}

/// The source has been spread. Nodes at which ways bend see on in the order of their distance: when it is a node's
/// turn, all that could come before has been looked through.
SurfaceDistance::Distances SurfaceDistance::run() {
    look_through_all();
    while (!queue_.empty()) {
        const Event event = queue_.front();
        std::pop_heap(queue_.begin(), queue_.end());
        queue_.pop_back();
        if (event.distance > best_[at(event.node)]) continue;
        if (surface_.turn[at(event.node)] == SurfaceGraph::Turn::kSaddle)
            spread_behind(event.node, event.distance);
        else
            spread(event.node, event.distance);
        look_through_all();
    }
    std::sort(reached_.begin(), reached_.end());
    Distances distances;
    for (std::int32_t node : reached_) distances.push_back({node, best_[at(node)]});
    return distances;
}

SurfaceDistance::Distances SurfaceDistance::from_node(std::int32_t node, double reach_m) {
    begin(reach_m);
    best_[at(node)] = 0.0;
    reached_.push_back(node);
    spread(node, 0.0);
    return run();
}

SurfaceDistance::Distances SurfaceDistance::from_edge(std::int32_t a, std::int32_t b, double reach_m) {
    begin(reach_m);
    const auto sides = surface_.sides(a, b);
    const double half = 0.5 * surface_.length_m[at(sides[0][2])];
    for (const auto& side : sides) {
        // The source in the middle of the edge looks into the patch like a window's.
        const std::int32_t behind = side[2], corner_a = previous(behind), corner_b = next(behind);
        if (reach(surface_.node[at(corner_a)], half)) arrival_[at(surface_.node[at(corner_a)])] = {corner_a, 0.0};
        if (reach(surface_.node[at(corner_b)], half))
            arrival_[at(surface_.node[at(corner_b)])] = {corner_b, surface_.angle[at(corner_b)]};
        look_through({{-half, 0.0}, {half, 0.0}, {-1.0, 0.0}, {1.0, 0.0}, 0.0, -1}, behind);
    }
    return run();
}

}  // namespace haptable
