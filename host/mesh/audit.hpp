// SPDX-License-Identifier: GPL-2.0-or-later
// What a mesh is and what is wrong with it, before anything is computed from it.
#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/mesh/surface.hpp"

namespace haptable {

/// A tetrahedron by its shape.
struct ShapedTet {
    std::int32_t tet = 0;
    std::uint64_t number = 0;  ///< in the mesh's file
    double ratio = 0.0;        ///< 3 r / R
    Tet node{};
};

struct Audit {
    std::size_t nodes = 0, tets = 0, surface_nodes = 0, patches = 0;
    std::size_t unused_nodes = 0;  ///< of the file, left out
    std::size_t turned = 0;        ///< tetrahedra that stood the other way round
    std::size_t folded = 0;        ///< tetrahedra on the wrong side of a neighbour: no turning mends them
    std::size_t bodies = 0;        ///< parts that share no node
    std::size_t shells = 0;        ///< parts of the surface that share no edge
    std::size_t cavities = 0;      ///< shells that enclose emptiness
    std::int64_t euler = 0;        ///< nodes - edges + patches of the surface: 2 for a ball, 0 for a torus
    std::size_t hinge_edges = 0;   ///< surface edges with more than two patches
    std::size_t hinge_nodes = 0;   ///< surface nodes whose patches form more than one ring
    std::size_t coincident = 0;    ///< nodes at the place of another one
    double worst_ratio = 0.0;      ///< radius ratio 3 r / R: 1 for the regular tetrahedron
    double median_ratio = 0.0;
    std::vector<ShapedTet> worst;                         ///< the worst kListed, the worst first
    std::vector<std::array<std::int32_t, 2>> hinge_edge;  ///< the first kListedHinges
    std::vector<std::int32_t> hinge_node;                 ///< the first kListedHinges
    std::size_t slivers = 0;                              ///< tetrahedra with a radius ratio below 0.1
    double least_angle_deg = 0.0;                         ///< dihedral
    double greatest_angle_deg = 0.0;
    std::size_t middle_nodes = 0;     ///< in the middle of edges
    std::size_t curved = 0;           ///< tetrahedra with one of them off the straight line
    double worst_jacobian_ratio = 1;  ///< det dx/dt, least over greatest of an element's points of integration
    double volume_m3 = 0.0;
    Eigen::AlignedBox3d box_m;
};

inline constexpr std::size_t kListed = 5, kListedHinges = 500;

/// Tetrahedra, ascending, that lie on the same side of a shared face as their neighbours: of those that meet so, the
/// fewer. All positively oriented.
std::vector<std::int32_t> find_folded(const std::vector<Tet>& tets);

/// [N] which body each node belongs to: parts of the mesh that share no node.
std::vector<std::size_t> number_bodies(const TetMesh& mesh);

/// surface: as find_surface gives it, which throws Error where a face belongs to more than two tetrahedra.
Audit audit_mesh(const TetMesh& mesh, const Surface& surface);
inline Audit audit_mesh(const TetMesh& mesh) { return audit_mesh(mesh, find_surface(mesh)); }

/// "12 m long: is mesh.scale right? In millimetres it would be 0.012 m: write scale = 0.001 in [mesh]", of a body whose
/// longest side is size_m at scale_m metres per unit of its file; empty where a finger could touch it.
std::string doubt_scale(double size_m, double scale_m);

/// What does not stop the work, one line each. scale_m: of mesh.scale.
std::vector<std::string> warnings_of(const Audit& audit, double scale_m);

std::string to_table(const Audit& audit);
nlohmann::ordered_json to_json(const Audit& audit);

}  // namespace haptable
