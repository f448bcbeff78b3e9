// SPDX-License-Identifier: GPL-2.0-or-later
// w_a = int k(d) N_a dA,   k = (1 - (d / R)^2)^2,   d^2 = sum_a N_a d_a^2
//
// A pressure on the faces of quadratic tetrahedra as forces on their nodes. On corners alone, or by a node's part of
// the surface, a force would be no pressure: of an even one a corner's share is 0 and a middle's a third of the face.
#pragma once

#include <Eigen/Core>
#include <map>
#include <span>
#include <vector>

#include "host/body/geodesic.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

struct NodeWeights;

/// The patches and where on them a pressure is integrated.
class Facets {
public:
    /// position_m [N], patch and quarter [p]. A patch whose face may be touched in part only has the linear shape
    /// functions of its own nodes: the face's other nodes have no tables.
    Facets(std::span<const Eigen::Vector3d> position_m, std::span<const Patch> patch, std::span<const Quarter> quarter,
           double radius_m);

    /// Every patch that the pressure touches has a node within it: where its rim crosses an edge between two nodes that
    /// lie outside, one is less than half an edge from the middle of what is inside.
    double touched_m() const { return touched_m_; }
    /// Within it are all nodes of the faces at these nodes.
    double reach_m(const SurfaceDistance::Distances& near) const;
    double radius_m() const { return radius_m_; }
    std::span<const std::int32_t> nodes(std::size_t p) const;

    /// Adds a patch's share to `weight`, m^2, by its nodes. squared_m2: of the nodes' distances.
    /// Returns false where no point of it is within the radius.
    bool add(std::size_t p, std::span<const double> squared_m2, std::span<double> weight) const;

private:
    /// Shape functions at points of equal weight: [points, nodes].
    using Rule = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    struct Facet {
        QuadraticFace node{};
        std::size_t nodes = 6;
        double area_m2 = 0.0;
        const Rule* rule = nullptr;
    };
    static constexpr int kLinear = -1;  // instead of a quarter's place
    static Rule make_rule(int place, int cuts);

    std::vector<Facet> facet_;
    std::map<std::pair<int, int>, Rule> rule_;  // by quarter and cuts of an edge
    std::vector<double> extent_m_;  // [N] over a node's faces: no node of theirs is farther along their edges
    double radius_m_, touched_m_;
};

/// One worker's pressures, one after the other.
class FacePressure {
public:
    FacePressure(const Facets& facets, const SurfaceGraph& surface);

    /// near: of all nodes of the faces that the pressure touches. Empty where no more than `own` nodes are within the
    /// radius: there the mesh is too coarse for it.
    NodeWeights integrate(const SurfaceDistance::Distances& near, std::size_t own);

private:
    void find_facets(const SurfaceDistance::Distances& near);

    const Facets* facets_;
    const SurfaceGraph* surface_;
    std::vector<double> squared_m2_, weight_;  // [N] infinite, 0
    std::vector<char> seen_, loaded_;          // [p], [N]
    std::vector<std::size_t> facet_;
};

}  // namespace haptable
