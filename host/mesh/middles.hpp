// SPDX-License-Identifier: GPL-2.0-or-later
// Nodes in the middle of edges: what makes a mesh quadratic.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "host/mesh/mesh.hpp"

namespace haptable {

/// The node in the middle of each edge.
class Middles {
public:
    /// New nodes go behind those of position_m, which must outlive this.
    explicit Middles(std::vector<Eigen::Vector3d>& position_m) : position_m_(position_m) {}

    /// That of the edge between nodes a and b, made, on the straight line, when first asked for.
    std::int32_t of(std::int32_t a, std::int32_t b);
    /// The same; -1 where it was not made.
    std::int32_t find(std::int32_t a, std::int32_t b) const;

private:
    std::vector<Eigen::Vector3d>& position_m_;
    std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> node_;
};

/// Gives every tetrahedron of a mesh of corners nodes in the middle of its edges, straight, behind all others. Groups
/// get those of their triangles' and tetrahedra's edges; of nodes alone, those of edges of the surface between them:
/// what was held stays held. Throws Error where there are more nodes than can be numbered.
void add_middles(TetMesh& mesh);

/// Turns a tetrahedron round: its corners 2 and 3 change places.
void turn(Tet& tet, MiddleNodes& middle);

}  // namespace haptable
