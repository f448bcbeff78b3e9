// SPDX-License-Identifier: GPL-2.0-or-later
// w_a = k(d_a) A_a / sum,   k = (1 - (d / R)^2)^2;   of quadratic tetrahedra w_a = int k(d) N_a dA / sum
#include "host/body/mask.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "host/base/index.hpp"
#include "host/base/shared_progress.hpp"
#include "host/body/face_pressure.hpp"
#include "host/body/geodesic.hpp"

namespace haptable {

namespace {

using Edge = std::array<std::int32_t, 2>;

/// A node's part of its patches: Voronoi regions, by halves and quarters in obtuse ones (Meyer et al. 2003). Equal for
/// all nodes of a regular grid however its diagonals run.
std::vector<double> node_areas(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch) {
    std::vector<double> area(position_m.size(), 0.0);
    for (const Patch& corner : patch) {
        std::array<Eigen::Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c) x[c] = position_m[at(corner[c])];
        const double twice = (x[1] - x[0]).cross(x[2] - x[0]).norm();
        if (!(twice > 0.0)) continue;
        std::array<double, 3> dot{};
        for (std::size_t c = 0; c < 3; ++c) dot[c] = (x[(c + 1) % 3] - x[c]).dot(x[(c + 2) % 3] - x[c]);
        const bool obtuse = std::any_of(dot.begin(), dot.end(), [](double d) { return d < 0.0; });
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t n = (c + 1) % 3, m = (c + 2) % 3;
            const double voronoi =
                ((x[n] - x[c]).squaredNorm() * dot[m] + (x[m] - x[c]).squaredNorm() * dot[n]) / (8.0 * twice);
            area[at(corner[c])] += obtuse ? (dot[c] < 0.0 ? 0.25 : 0.125) * twice : voronoi;
        }
    }
    return area;
}

/// One worker's masks, one after the other.
class Maker {
public:
    /// facets: of quadratic tetrahedra; else none
    Maker(const SurfaceGraph& surface, const Facets* facets, std::span<const double> area_m2, double radius_m)
        : distance_(surface), facets_(facets), area_m2_(area_m2), radius_m_(radius_m) {
        if (facets != nullptr) pressure_.emplace(*facets, surface);
    }

    NodeWeights at_node(std::int32_t node) {
        return distribute(find_near([&](double reach_m) { return distance_.from_node(node, reach_m); }),
                          std::array{node});
    }
    NodeWeights at_edge(const Edge& edge) {
        return distribute(find_near([&](double reach_m) { return distance_.from_edge(edge[0], edge[1], reach_m); }),
                          edge);
    }

private:
    /// Nodes within the radius; with facets all nodes of the faces that it touches, by a second search: faces may be
    /// much larger elsewhere.
    template <typename Search>
    SurfaceDistance::Distances find_near(const Search& search) const {
        if (facets_ == nullptr) return search(radius_m_);
        return search(facets_->reach_m(search(facets_->touched_m())));
    }
    /// Where nothing is within reach, the nodes of the feature itself.
    NodeWeights distribute(const SurfaceDistance::Distances& near, std::span<const std::int32_t> own) {
        NodeWeights mask = pressure_ ? pressure_->integrate(near, own.size()) : at_nodes(near);
        if (mask.node.size() < own.size()) {
            mask.node.assign(own.begin(), own.end());
            mask.weight.assign(own.size(), 1.0);
        }
        double sum = 0.0;
        for (double w : mask.weight) sum += w;
        for (double& w : mask.weight) w /= sum;
        return mask;
    }
    NodeWeights at_nodes(const SurfaceDistance::Distances& near) const {
        NodeWeights mask;
        for (const auto& [node, d] : near) {
            const double rest = std::max(0.0, 1.0 - d * d / (radius_m_ * radius_m_));
            const double w = rest * rest * area_m2_[at(node)];
            if (!(w > 0.0)) continue;
            mask.node.push_back(node);
            mask.weight.push_back(w);
        }
        return mask;
    }

    SurfaceDistance distance_;
    const Facets* facets_;
    std::optional<FacePressure> pressure_;
    std::span<const double> area_m2_;
    double radius_m_;
};

/// a + factor b.
NodeWeights sum_of(const NodeWeights& a, double factor, const NodeWeights& b) {
    NodeWeights sum;
    for (std::size_t i = 0, j = 0; i < a.node.size() || j < b.node.size();) {
        const bool from_a = j == b.node.size() || (i < a.node.size() && a.node[i] <= b.node[j]);
        const bool from_b = i == a.node.size() || (j < b.node.size() && b.node[j] <= a.node[i]);
        sum.node.push_back(from_a ? a.node[i] : b.node[j]);
        double weight = from_a ? a.weight[i++] : 0.0;
        if (from_b) weight += factor * b.weight[j++];
        sum.weight.push_back(weight);
    }
    return sum;
}

/// The control mask between those of a quadratic's ends v, w and middle m: 2 m - (v + w) / 2.
NodeWeights control_between(const NodeWeights& v, NodeWeights middle, const NodeWeights& w) {
    for (double& weight : middle.weight) weight *= 2.0;
    return sum_of(sum_of(middle, -0.5, v), -0.5, w);
}

std::size_t place_in(const auto& list, const auto& key) {
    return static_cast<std::size_t>(std::lower_bound(list.begin(), list.end(), key) - list.begin());
}

std::vector<std::array<std::size_t, 6>> controls_of(const Masks& masks, std::span<const Patch> patch) {
    std::vector<std::array<std::size_t, 6>> controls(patch.size());
    for (std::size_t p = 0; p < patch.size(); ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(patch[p][(c + 1) % 3], patch[p][(c + 2) % 3]);
            controls[p][c] = place_in(masks.vertex_id, patch[p][c]);
            controls[p][3 + c] = masks.vertex_id.size() + place_in(masks.edge_id, Edge{low, high});
        }
    return controls;
}

std::size_t most_nodes_of(const Masks& masks, std::size_t nodes) {
    std::size_t most = 0, round = 0;
    std::vector<std::size_t> seen(nodes, 0);
    for (const auto& controls : masks.control) {
        std::size_t count = 0;
        ++round;
        for (std::size_t control : controls)
            for (std::int32_t node : masks.weights(control).node)
                if (std::exchange(seen[at(node)], round) != round) ++count;
        most = std::max(most, count);
    }
    return most;
}

template <typename Key>
std::vector<Key> sorted(std::vector<Key> list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
}

}  // namespace

std::vector<std::int32_t> nodes_of(std::span<const Patch> patch) {
    std::vector<std::int32_t> nodes;
    for (const Patch& corner : patch) nodes.insert(nodes.end(), corner.begin(), corner.end());
    return sorted(std::move(nodes));
}

std::vector<Edge> sorted_edges(std::span<const Patch> patch) {
    std::vector<Edge> edges;
    for (const Patch& corner : patch)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(corner[c], corner[(c + 1) % 3]);
            edges.push_back({low, high});
        }
    return sorted(std::move(edges));
}

Masks make_masks(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch, double radius_m,
                 Workers& workers, Progress& progress, std::span<const Quarter> quarter) {
    Masks masks;
    masks.vertex_id = nodes_of(patch);
    masks.edge_id = sorted_edges(patch);
    masks.control = controls_of(masks, patch);
    const std::size_t vertices = masks.vertex_id.size(), places = vertices + masks.edge_id.size();
    const std::vector<double> area_m2 = node_areas(position_m, patch);
    const SurfaceGraph surface(position_m, patch);
    std::optional<Facets> facets;
    if (!quarter.empty()) facets.emplace(position_m, patch, quarter, radius_m);
    std::vector<Maker> maker(static_cast<std::size_t>(workers.count()),
                             Maker(surface, facets ? &*facets : nullptr, area_m2, radius_m));
    masks.vertex.resize(vertices);
    masks.edge.resize(places - vertices);
    std::atomic<std::size_t> widened = 0;
    SharedProgress share(progress, places);
    workers.for_each(vertices, [&](std::size_t v, int worker) {
        share.begin_one();
        masks.vertex[v] = maker[at(worker)].at_node(masks.vertex_id[v]);
        widened += masks.vertex[v].node.size() == 1 ? 1 : 0;
    });
    workers.for_each(places - vertices, [&](std::size_t e, int worker) {
        share.begin_one();
        const Edge& edge = masks.edge_id[e];
        NodeWeights middle = maker[at(worker)].at_edge(edge);
        widened += middle.node.size() == 2 ? 1 : 0;
        masks.edge[e] = control_between(masks.vertex[place_in(masks.vertex_id, edge[0])], std::move(middle),
                                        masks.vertex[place_in(masks.vertex_id, edge[1])]);
    });
    masks.widened = widened;
    masks.most_nodes = most_nodes_of(masks, position_m.size());
    return masks;
}

}  // namespace haptable
