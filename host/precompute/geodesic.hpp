// SPDX-License-Identifier: GPL-2.0-or-later
// Distances over a triangle surface, exact: straight lines in the unfolded triangles, round the vertices that they can
// only pass by (saddles and borders). After Chen and Han 1990 with the filter of Xin and Wang 2009.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace haptable {

class SurfaceDistance {
public:
    /// position_m [N], patch [p] nodes of the surface, counter-clockwise from outside.
    SurfaceDistance(std::span<const Eigen::Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> patch);

    using Distances = std::map<std::int32_t, double>;  ///< node -> m, for the nodes that are reached
    /// Nodes within reach_m of a node, over the surface.
    Distances from_node(std::int32_t node, double reach_m) const;
    /// Nodes within reach_m of the middle of an edge.
    Distances from_edge(std::int32_t a, std::int32_t b, double reach_m) const;

private:
    struct Search;
    struct Window;
    struct Side {
        std::int32_t patch, opposite;  // the patch and its node that is not on the edge
    };
    using Edge = std::array<std::int32_t, 2>;  // lower node first

    static Edge edge_of(std::int32_t a, std::int32_t b) { return a < b ? Edge{a, b} : Edge{b, a}; }
    double length(std::int32_t a, std::int32_t b) const;
    void find_turning_nodes();
    void spread(std::int32_t node, double distance, Search& search) const;
    void look_through(const Window& window, Search& search) const;
    void add(const Window& window, Search& search) const;
    Distances run(Search& search) const;

    std::span<const Eigen::Vector3d> position_m_;
    std::span<const std::array<std::int32_t, 3>> patch_;
    std::map<Edge, std::vector<Side>> side_;
    std::map<std::int32_t, std::vector<std::int32_t>> around_;  // node -> its patches
    std::map<std::int32_t, bool> turns_;                        // node -> a shortest way may bend there
};

}  // namespace haptable
