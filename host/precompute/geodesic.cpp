// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/geodesic.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <queue>

namespace haptable {

namespace {

using Eigen::Vector2d;

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

/// What a source sees through an edge: the source unfolded to the origin, the edge's ends a and b with b
/// counter-clockwise of a, and the rays that bound the view.
struct SurfaceDistance::Window {
    std::int32_t from_patch, a, b;
    Vector2d at_a, at_b;
    Vector2d ray_a, ray_b;
    double base;     // from the true source to the origin
    double nearest;  // of what is seen of the edge, with the base
};

struct SurfaceDistance::Search {
    struct Event {
        double distance;
        std::int32_t node;  // -1: the window
        Window window;
        bool operator<(const Event& other) const { return distance > other.distance; }
    };
    double reach;
    Distances best;
    std::priority_queue<Event> queue;

    double at(std::int32_t node) const {
        const auto found = best.find(node);
        return found == best.end() ? HUGE_VAL : found->second;
    }
};

SurfaceDistance::SurfaceDistance(std::span<const Eigen::Vector3d> position_m,
                                 std::span<const std::array<std::int32_t, 3>> patch)
    : position_m_(position_m), patch_(patch) {
    for (std::size_t p = 0; p < patch.size(); ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t node = patch[p][c];
            side_[edge_of(patch[p][(c + 1) % 3], patch[p][(c + 2) % 3])].push_back(
                {static_cast<std::int32_t>(p), node});
            around_[node].push_back(static_cast<std::int32_t>(p));
        }
    find_turning_nodes();
}

double SurfaceDistance::length(std::int32_t a, std::int32_t b) const {
    return (position_m_[static_cast<std::size_t>(a)] - position_m_[static_cast<std::size_t>(b)]).norm();
}

/// A shortest way bends only at nodes with more than a full turn around them, and at borders.
void SurfaceDistance::find_turning_nodes() {
    for (const auto& [node, patches] : around_) {
        double angle = 0.0;
        for (std::int32_t p : patches) {
            const auto& corner = patch_[static_cast<std::size_t>(p)];
            const std::size_t c = corner[0] == node ? 0 : corner[1] == node ? 1 : 2;
            const Eigen::Vector3d& x = position_m_[static_cast<std::size_t>(node)];
            const Eigen::Vector3d u = position_m_[static_cast<std::size_t>(corner[(c + 1) % 3])] - x;
            const Eigen::Vector3d v = position_m_[static_cast<std::size_t>(corner[(c + 2) % 3])] - x;
            angle += std::atan2(u.cross(v).norm(), u.dot(v));
        }
        turns_[node] = angle > 2.0 * std::numbers::pi * (1.0 + 1e-9);
    }
    for (const auto& [edge, sides] : side_)
        if (sides.size() != 2) turns_[edge[0]] = turns_[edge[1]] = true;
}

/// Everything that is seen from a node that is `distance` from the source.
void SurfaceDistance::spread(std::int32_t node, double distance, Search& search) const {
    for (std::int32_t p : around_.at(node)) {
        const auto& corner = patch_[static_cast<std::size_t>(p)];
        const std::size_t c = corner[0] == node ? 0 : corner[1] == node ? 1 : 2;
        const std::int32_t a = corner[(c + 1) % 3], b = corner[(c + 2) % 3];
        const double la = length(node, a), lb = length(node, b), ab = length(a, b);
        const double angle = std::acos(std::clamp((la * la + lb * lb - ab * ab) / (2.0 * la * lb), -1.0, 1.0));
        const Vector2d at_a(la, 0.0), at_b(lb * std::cos(angle), lb * std::sin(angle));
        for (const auto& [end, l] : {std::pair{a, la}, std::pair{b, lb}})
            if (distance + l < std::min(search.at(end), search.reach)) {
                search.best[end] = distance + l;
                search.queue.push({distance + l, end, {}});
            }
        add({p, a, b, at_a, at_b, at_a, at_b, distance, 0.0}, search);
    }
}

/// Puts a window into the queue unless nothing new can be seen through it.
void SurfaceDistance::add(const Window& window, Search& search) const {
    Window w = window;
    const Vector2d p = meet(w.ray_a, w.at_a, w.at_b), q = meet(w.ray_b, w.at_a, w.at_b);
    w.nearest = w.base + distance_to(p, q);
    if (!(w.nearest < search.reach)) return;
    // Xin and Wang: a way over an end of the edge that is shorter.
    const double slack = 1.0 - 1e-12;
    if (search.at(w.a) + (q - w.at_a).norm() < (w.base + q.norm()) * slack) return;
    if (search.at(w.b) + (p - w.at_b).norm() < (w.base + p.norm()) * slack) return;
    search.queue.push({w.nearest, -1, w});
}

/// Unfolds the patch behind the window's edge: its third node, and the windows on its two other edges.
void SurfaceDistance::look_through(const Window& w, Search& search) const {
    const std::vector<Side>& sides = side_.at(edge_of(w.a, w.b));
    if (sides.size() != 2) return;
    const Side& next = sides[0].patch == w.from_patch ? sides[1] : sides[0];
    const std::int32_t c = next.opposite;
    const double ab = length(w.a, w.b), ac = length(w.a, c), bc = length(w.b, c);
    const double along = (ac * ac - bc * bc + ab * ab) / (2.0 * ab);
    const double height = std::sqrt(std::max(0.0, ac * ac - along * along));
    const Vector2d e = (w.at_b - w.at_a) / ab;
    const Vector2d at_c = w.at_a + along * e + height * Vector2d(e.y(), -e.x());
    const bool beyond_a = cross(w.ray_a, at_c) > 0.0, before_b = cross(at_c, w.ray_b) > 0.0;
    // A node on the view's border is seen: on a regular grid many stand exactly behind another.
    const double rounding = 1e-9 * at_c.norm();
    const bool seen =
        cross(w.ray_a, at_c) >= -rounding * w.ray_a.norm() && cross(at_c, w.ray_b) >= -rounding * w.ray_b.norm();
    if (seen && w.base + at_c.norm() < std::min(search.at(c), search.reach)) {
        search.best[c] = w.base + at_c.norm();
        search.queue.push({search.best[c], c, {}});
    }
    if (beyond_a) add({next.patch, w.a, c, w.at_a, at_c, w.ray_a, before_b ? at_c : w.ray_b, w.base, 0.0}, search);
    if (before_b) add({next.patch, c, w.b, at_c, w.at_b, beyond_a ? at_c : w.ray_a, w.ray_b, w.base, 0.0}, search);
}

SurfaceDistance::Distances SurfaceDistance::run(Search& search) const {
    while (!search.queue.empty()) {
        const Search::Event event = search.queue.top();
        search.queue.pop();
        if (event.node < 0)
            look_through(event.window, search);
        else if (event.distance <= search.at(event.node) && turns_.at(event.node))
            spread(event.node, event.distance, search);
    }
    return std::move(search.best);
}

SurfaceDistance::Distances SurfaceDistance::from_node(std::int32_t node, double reach_m) const {
    Search search{reach_m, {}, {}};
    search.best[node] = 0.0;
    spread(node, 0.0, search);
    return run(search);
}

SurfaceDistance::Distances SurfaceDistance::from_edge(std::int32_t a, std::int32_t b, double reach_m) const {
    Search search{reach_m, {}, {}};
    const double half = 0.5 * length(a, b);
    for (std::int32_t end : {a, b})
        if (half < reach_m) {
            search.best[end] = half;
            search.queue.push({half, end, {}});
        }
    for (const Side& side : side_.at(edge_of(a, b))) {
        const std::int32_t c = side.opposite;
        const double ac = length(a, c), bc = length(b, c);
        const double x = (ac * ac - bc * bc) / (4.0 * half);  // from the middle towards b
        const Vector2d at_a(-half, 0.0), at_b(half, 0.0);
        const Vector2d at_c(x, -std::sqrt(std::max(0.0, ac * ac - (x + half) * (x + half))));
        if (at_c.norm() < std::min(search.at(c), reach_m)) {
            search.best[c] = at_c.norm();
            search.queue.push({search.best[c], c, {}});
        }
        add({side.patch, a, c, at_a, at_c, at_a, at_c, 0.0, 0.0}, search);
        add({side.patch, c, b, at_c, at_b, at_c, at_b, 0.0, 0.0}, search);
    }
    return run(search);
}

}  // namespace haptable
