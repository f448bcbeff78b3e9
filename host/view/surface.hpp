// SPDX-License-Identifier: GPL-2.0-or-later
// The surface that is drawn: rest shape, deformed shape, and smooth normals that keep the sharp edges sharp.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "host/tables/tables.hpp"

namespace haptable {

/// Edges of the rest shape whose faces meet at a larger angle than this are creases: the shading breaks there.
inline constexpr double kCreaseDegrees = 42.0;

/// All surface patches of the tables, over the mesh nodes that lie on them. m surface nodes, q patches.
class DrawnSurface {
public:
    explicit DrawnSurface(const Tables& tables);

    std::size_t nodes() const { return node_id.size(); }
    std::size_t patches() const { return patch.size(); }

    /// Rest positions plus the displacements [r,3] of equation 8. A node without a row is fixed and stays.
    void deform(std::span<const float> displacement_m);

    /// The angle-weighted normals of the deformed shape, one for each smooth group of faces at a node.
    void update_normals();

    /// Brings the deformed shape and its normals to where the body is.
    void move(const Eigen::Isometry3d& pose);

    std::vector<std::int32_t> node_id;                ///< [m] mesh node, ascending
    std::vector<std::int32_t> row;                    ///< [m] row of columns.npy, -1 at a fixed node
    std::vector<Eigen::Vector3f> rest_m;              ///< [m]
    std::vector<Eigen::Vector3f> displacement_m;      ///< [m]
    std::vector<Eigen::Vector3f> normal;              ///< [s] unit; s >= m smooth groups
    std::vector<Eigen::Vector3i> patch;               ///< [q] surface nodes, counter-clockwise from outside
    std::vector<Eigen::Vector3i> normal_of;           ///< [q] the normal of each corner
    std::vector<Eigen::Vector3i> neighbour;           ///< [q] patch across the edge opposite to a corner
    std::vector<std::array<std::uint8_t, 3>> crease;  ///< [q] 1 where that edge is a crease or has no neighbour
    std::vector<std::uint8_t> touchable;              ///< [q] 1 for a patch that the finger may meet
    std::vector<std::uint8_t> held;                   ///< [q] 1 for a patch whose nodes are all fixed
    /// A patch shows its inside: it is turned over, or so much is displaced that a part may have come through another.
    bool is_inside_out = false;

private:
    void number_nodes(const Tables& tables);
    void find_neighbours();
    void find_creases();
    void group_normals();
    void mark_patches(const Tables& tables);

    std::vector<Eigen::Vector3f> rest_face_;  ///< [q] unit
    float thinnest_m_ = 0.0F;                 ///< the least side of the rest shape's box
};

}  // namespace haptable
