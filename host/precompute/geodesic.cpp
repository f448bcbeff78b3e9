// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/geodesic.hpp"

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

/// Where the ray from the origin along `way` meets the line through a and b.
Vector2d meet(const Vector2d& way, const Vector2d& a, const Vector2d& b) {
    const double turn = cross(way, b - a);
    if (turn == 0.0) return a;
    return way * (cross(a, b - a) / turn);
}

/// From the origin to the segment.
double distance_to(const Vector2d& p, const Vector2d& q) {
    const double length2 = (q - p).squaredNorm();
    const double t = length2 > 0.0 ? std::clamp(-p.dot(q - p) / length2, 0.0, 1.0) : 0.0;
    return (p + t * (q - p)).norm();
}

}  // namespace

SurfaceGraph::SurfaceGraph(std::span<const Eigen::Vector3d> position_m,
                           std::span<const std::array<std::int32_t, 3>> patch)
    : around_begin(position_m.size() + 1, 0), turns(position_m.size(), 0) {
    for (const auto& corners : patch) node.insert(node.end(), corners.begin(), corners.end());
    const auto corners = static_cast<std::int32_t>(node.size());
    const auto position = [&](std::int32_t corner) -> const Eigen::Vector3d& {
        return position_m[at(node[at(corner)])];
    };
    for (std::int32_t c = 0; c < corners; ++c) length_m.push_back((position(next(c)) - position(previous(c))).norm());
    for (std::int32_t c = 0; c < corners; ++c) {
        const double la = length_m[at(previous(c))], lb = length_m[at(next(c))], ab = length_m[at(c)];
        const double angle = std::acos(std::clamp((la * la + lb * lb - ab * ab) / (2.0 * la * lb), -1.0, 1.0));
        far_m.emplace_back(lb * std::cos(angle), lb * std::sin(angle));
    }
    for (std::int32_t n : node) ++around_begin[at(n) + 1];
    for (std::size_t n = 1; n < around_begin.size(); ++n) around_begin[n] += around_begin[n - 1];
    around.resize(node.size());
    std::vector<std::int32_t> end(around_begin.begin(), around_begin.end() - 1);
    for (std::int32_t c = 0; c < corners; ++c) around[at(end[at(node[at(c)])]++)] = c;
    find_sides();
    find_turning_nodes(position_m);
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
        if (end - first == 2) {
            across[at(edge[first][2])] = edge[first + 1][2];
            across[at(edge[first + 1][2])] = edge[first][2];
        } else {
            for (std::size_t s = first; s < end; ++s) turns[at(edge[s][0])] = turns[at(edge[s][1])] = 1;
        }
    }
}

/// A shortest way bends only at nodes with more than a full turn around them, and at borders.
void SurfaceGraph::find_turning_nodes(std::span<const Eigen::Vector3d> position_m) {
    for (std::size_t n = 0; n < position_m.size(); ++n) {
        double angle = 0.0;
        for (std::int32_t k = around_begin[n]; k < around_begin[n + 1]; ++k) {
            const std::int32_t c = around[at(k)];
            const Eigen::Vector3d u = position_m[at(node[at(next(c))])] - position_m[n];
            const Eigen::Vector3d v = position_m[at(node[at(previous(c))])] - position_m[n];
            angle += std::atan2(u.cross(v).norm(), u.dot(v));
        }
        if (angle > 2.0 * std::numbers::pi * (1.0 + 1e-9)) turns[n] = 1;
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
    : surface_(surface), best_(surface.turns.size(), HUGE_VAL) {}

void SurfaceDistance::begin(double reach_m) {
    reach_m_ = reach_m;
    for (std::int32_t node : reached_) best_[at(node)] = HUGE_VAL;
    reached_.clear();
    queue_.clear();
    window_.clear();
}

void SurfaceDistance::push(const Event& event) {
    queue_.push_back(event);
    std::push_heap(queue_.begin(), queue_.end());
}

/// A way to a node, where it is the shortest so far.
void SurfaceDistance::reach(std::int32_t node, double distance) {
    double& best = best_[at(node)];
    if (!(distance < std::min(best, reach_m_))) return;
    if (best == HUGE_VAL) reached_.push_back(node);
    best = distance;
    push({distance, node, -1});
}

/// Everything that is seen from a node that is `distance` from the source.
void SurfaceDistance::spread(std::int32_t node, double distance) {
    for (std::int32_t k = surface_.around_begin[at(node)]; k < surface_.around_begin[at(node) + 1]; ++k) {
        const std::int32_t corner = surface_.around[at(k)];
        const std::int32_t a = surface_.node[at(next(corner))], b = surface_.node[at(previous(corner))];
        const double la = surface_.length_m[at(previous(corner))];
        const double lb = surface_.length_m[at(next(corner))];
        reach(a, distance + la);
        reach(b, distance + lb);
        const Vector2d at_a(la, 0.0), at_b = surface_.far_m[at(corner)];
        add({corner, a, b, at_a, at_b, at_a, at_b, distance});
    }
}

/// Puts a window into the queue unless nothing new can be seen through it.
void SurfaceDistance::add(const Window& w) {
    const Vector2d p = meet(w.ray_a, w.at_a, w.at_b), q = meet(w.ray_b, w.at_a, w.at_b);
    const double nearest = w.base + distance_to(p, q);
    if (!(nearest < reach_m_)) return;
    // Xin and Wang: a way over an end of the edge that is shorter.
    const double slack = 1.0 - 1e-12;
    if (best_[at(w.a)] + (q - w.at_a).norm() < (w.base + q.norm()) * slack) return;
    if (best_[at(w.b)] + (p - w.at_b).norm() < (w.base + p.norm()) * slack) return;
    window_.push_back(w);
    push({nearest, -1, static_cast<std::int32_t>(window_.size() - 1)});
}

/// Unfolds the patch behind the window's edge: its third node, and the windows on its two other edges.
void SurfaceDistance::look_through(const Window& w) {
    const std::int32_t behind = surface_.across[at(w.corner)];
    if (behind < 0) return;
    const bool a_first = surface_.node[at(next(behind))] == w.a;
    const std::int32_t corner_a = a_first ? next(behind) : previous(behind);
    const std::int32_t corner_b = a_first ? previous(behind) : next(behind);
    const std::int32_t c = surface_.node[at(behind)];
    const double ab = surface_.length_m[at(behind)];
    const double ac = surface_.length_m[at(corner_b)], bc = surface_.length_m[at(corner_a)];
    const double along = (ac * ac - bc * bc + ab * ab) / (2.0 * ab);
    const double height = std::sqrt(std::max(0.0, ac * ac - along * along));
    const Vector2d e = (w.at_b - w.at_a) / ab;
    const Vector2d at_c = w.at_a + along * e + height * Vector2d(e.y(), -e.x());
    const double from_a = cross(w.ray_a, at_c), to_b = cross(at_c, w.ray_b), far = at_c.norm();
    // A node on the view's border is seen: on a regular grid many stand exactly behind another.
    const double rounding = 1e-9 * far;
    if (from_a >= -rounding * w.ray_a.norm() && to_b >= -rounding * w.ray_b.norm()) reach(c, w.base + far);
    const bool beyond_a = from_a > 0.0, before_b = to_b > 0.0;
    if (beyond_a) add({corner_b, w.a, c, w.at_a, at_c, w.ray_a, before_b ? at_c : w.ray_b, w.base});
    if (before_b) add({corner_a, c, w.b, at_c, w.at_b, beyond_a ? at_c : w.ray_a, w.ray_b, w.base});
}

SurfaceDistance::Distances SurfaceDistance::run() {
    while (!queue_.empty()) {
        const Event event = queue_.front();
        std::pop_heap(queue_.begin(), queue_.end());
        queue_.pop_back();
        if (event.node < 0)
            look_through(Window(window_[at(event.window)]));  // a copy: more windows come
        else if (event.distance <= best_[at(event.node)] && surface_.turns[at(event.node)] != 0)
            spread(event.node, event.distance);
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
    for (std::int32_t end : {a, b}) reach(end, half);
    for (const auto& side : sides) {
        const std::int32_t corner = side[2], c = surface_.node[at(corner)];
        const bool a_first = surface_.node[at(next(corner))] == a;
        const std::int32_t corner_a = a_first ? next(corner) : previous(corner);
        const std::int32_t corner_b = a_first ? previous(corner) : next(corner);
        const double ac = surface_.length_m[at(corner_b)], bc = surface_.length_m[at(corner_a)];
        const double x = (ac * ac - bc * bc) / (4.0 * half);  // from the middle towards b
        const Vector2d at_a(-half, 0.0), at_b(half, 0.0);
        const Vector2d at_c(x, -std::sqrt(std::max(0.0, ac * ac - (x + half) * (x + half))));
        reach(c, at_c.norm());
        add({corner_b, a, c, at_a, at_c, at_a, at_c, 0.0});
        add({corner_a, c, b, at_c, at_b, at_c, at_b, 0.0});
    }
    return run();
}

}  // namespace haptable
