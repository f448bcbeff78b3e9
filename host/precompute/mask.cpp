// SPDX-License-Identifier: GPL-2.0-or-later
// w_a = k(d_a) A_a / sum,   k = (1 - (d / R)^2)^2
#include "host/precompute/mask.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

namespace haptable {

namespace {

using Edge = std::array<std::int32_t, 2>;
using Patch = std::array<std::int32_t, 3>;
using Distances = SurfaceDistance::Distances;

/// A node's part of its patches: Voronoi regions, by halves and quarters in obtuse ones (Meyer et al. 2003). Equal for
/// all nodes of a regular grid however its diagonals run.
std::map<std::int32_t, double> node_areas(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch) {
    std::map<std::int32_t, double> area;
    for (const Patch& corner : patch) {
        std::array<Eigen::Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c) x[c] = position_m[static_cast<std::size_t>(corner[c])];
        const double twice = (x[1] - x[0]).cross(x[2] - x[0]).norm();
        if (!(twice > 0.0)) continue;
        std::array<double, 3> dot{};
        for (std::size_t c = 0; c < 3; ++c) dot[c] = (x[(c + 1) % 3] - x[c]).dot(x[(c + 2) % 3] - x[c]);
        const bool obtuse = std::any_of(dot.begin(), dot.end(), [](double d) { return d < 0.0; });
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t n = (c + 1) % 3, m = (c + 2) % 3;
            const double voronoi =
                ((x[n] - x[c]).squaredNorm() * dot[m] + (x[m] - x[c]).squaredNorm() * dot[n]) / (8.0 * twice);
            area[corner[c]] += obtuse ? (dot[c] < 0.0 ? 0.25 : 0.125) * twice : voronoi;
        }
    }
    return area;
}

class Maker {
public:
    Maker(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch, double radius_m)
        : distance_(position_m, patch), area_(node_areas(position_m, patch)), radius_m_(radius_m) {}

    using Sparse = std::map<std::int32_t, double>;
    Sparse at_node(std::int32_t node) const { return distribute(distance_.from_node(node, radius_m_), {node}); }
    Sparse at_edge(const Edge& edge) const {
        return distribute(distance_.from_edge(edge[0], edge[1], radius_m_), {edge[0], edge[1]});
    }

private:
    /// Where nothing is within reach, the nodes of the feature itself.
    Sparse distribute(const Distances& near, const std::vector<std::int32_t>& own) const {
        Sparse weight;
        double sum = 0.0;
        for (const auto& [node, d] : near) {
            const double rest = std::max(0.0, 1.0 - d * d / (radius_m_ * radius_m_));
            const double w = rest * rest * area_.at(node);
            if (w > 0.0) weight[node] = w;
            sum += w;
        }
        if (weight.size() < own.size()) weight.clear();
        if (weight.empty())
            for (std::int32_t node : own) sum = static_cast<double>(own.size()), weight[node] = 1.0;
        for (auto& [node, w] : weight) w /= sum;
        return weight;
    }

    SurfaceDistance distance_;
    std::map<std::int32_t, double> area_;
    double radius_m_;
};

NodeWeights to_weights(const Maker::Sparse& sparse) {
    NodeWeights weights;
    for (const auto& [node, weight] : sparse) {
        weights.node.push_back(node);
        weights.weight.push_back(weight);
    }
    return weights;
}

/// The control mask between those of a quadratic's ends v, w and middle m: 2 m - (v + w) / 2.
Maker::Sparse control(const Maker::Sparse& v, const Maker::Sparse& middle, const Maker::Sparse& w) {
    Maker::Sparse sum;
    for (const auto& [node, weight] : middle) sum[node] += 2.0 * weight;
    for (const auto* end : {&v, &w})
        for (const auto& [node, weight] : *end) sum[node] -= 0.5 * weight;
    return sum;
}

std::size_t most_nodes_of(const Masks& masks, std::span<const Patch> patch) {
    std::size_t most = 0;
    const auto at = [](const auto& list, const auto& key) {
        return static_cast<std::size_t>(std::lower_bound(list.begin(), list.end(), key) - list.begin());
    };
    for (const Patch& corner : patch) {
        std::set<std::int32_t> under;
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(corner[(c + 1) % 3], corner[(c + 2) % 3]);
            for (const NodeWeights* w :
                 {&masks.vertex[at(masks.vertex_id, corner[c])], &masks.edge[at(masks.edge_id, Edge{low, high})]})
                under.insert(w->node.begin(), w->node.end());
        }
        most = std::max(most, under.size());
    }
    return most;
}

}  // namespace

std::vector<std::int32_t> nodes_of(std::span<const Patch> patch) {
    std::set<std::int32_t> nodes;
    for (const Patch& corner : patch) nodes.insert(corner.begin(), corner.end());
    return {nodes.begin(), nodes.end()};
}

std::vector<Edge> edges_of(std::span<const Patch> patch) {
    std::set<Edge> edges;
    for (const Patch& corner : patch)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [low, high] = std::minmax(corner[c], corner[(c + 1) % 3]);
            edges.insert(Edge{low, high});
        }
    return {edges.begin(), edges.end()};
}

Masks make_masks(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch, double radius_m) {
    Masks masks;
    masks.vertex_id = nodes_of(patch);
    masks.edge_id = edges_of(patch);
    const Maker maker(position_m, patch, radius_m);
    std::map<std::int32_t, Maker::Sparse> vertex;
    for (std::int32_t node : masks.vertex_id) {
        const Maker::Sparse& w = vertex[node] = maker.at_node(node);
        masks.widened += w.size() == 1;
        masks.vertex.push_back(to_weights(w));
    }
    for (const Edge& edge : masks.edge_id) {
        const Maker::Sparse middle = maker.at_edge(edge);
        masks.widened += middle.size() == 2;
        masks.edge.push_back(to_weights(control(vertex[edge[0]], middle, vertex[edge[1]])));
    }
    masks.most_nodes = most_nodes_of(masks, patch);
    return masks;
}

}  // namespace haptable
