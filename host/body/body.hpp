// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene says about its mesh: which nodes are fixed, which are unknowns, which patches may be touched.
#pragma once

#include <Eigen/Geometry>

#include "host/fem/face_layer.hpp"
#include "host/mesh/fill.hpp"
#include "host/mesh/mesh.hpp"
#include "host/mesh/surface.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

/// N mesh nodes, q surface patches, n touchable free surface nodes, p touchable patches. Node lists are ascending.
struct Body {
    TetMesh mesh;
    Surface surface;
    std::vector<std::int32_t> unknown;            ///< [N] place of a node among the free ones, or -1: it is fixed
    std::vector<std::int32_t> free_node;          ///< mesh nodes that may move
    std::vector<std::int32_t> free_surface_node;  ///< those of them on the surface
    std::vector<std::int32_t> region;             ///< [T] the scene's region of each tetrahedron, or -1
    /// [T] directions 1 2 3 of each tetrahedron's material, by columns: of an orthotropic one. Empty where none is.
    std::vector<Eigen::Matrix3d> axes;
    std::vector<LayeredFace> layered;      ///< faces of the surface with membranes and beds, in its order
    std::vector<Patch> touch_patch;        ///< [p] in the surface's order
    std::vector<Quarter> touch_quarter;    ///< [p] of quadratic tetrahedra; else empty
    std::vector<std::int32_t> touch_node;  ///< [n] free nodes of touchable patches: the tables' order

    bool is_fixed(std::int32_t node) const { return unknown[static_cast<std::size_t>(node)] < 0; }
    std::size_t fixed_count() const { return unknown.size() - free_node.size(); }
};

/// "[xmin, ymin, zmin, xmax, ymax, zmax] m", as a scene writes a box.
std::string describe(const Eigen::AlignedBox3d& box_m);

/// Where [[fixed]] holds 30 % of the nodes or more: mostly a box that was meant for another place or unit.
std::vector<std::string> holding_warnings(const Scene& scene, const Body& body);

/// The mesh that the scene names or describes.
TetMesh make_mesh(const MeshSource& source, const WatchFill& watch = {});

/// Applies the scene's [[region]], [[fixed]] and [[touch]] to a mesh. Throws Error with the scene's line where a box or
/// group holds nothing, where two regions share a tetrahedron, and where nothing is left to touch.
Body make_body(const Scene& scene, TetMesh mesh);

}  // namespace haptable
