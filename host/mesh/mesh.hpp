// SPDX-License-Identifier: GPL-2.0-or-later
// A body of tetrahedra: nodes, elements, and the named groups of the file it came from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace haptable {

/// Four mesh nodes p0 p1 p2 p3 with det(p1-p0, p2-p0, p3-p0) > 0.
using Tet = std::array<std::int32_t, 4>;
/// The mesh nodes in the middle of its edges 01 12 20 03 13 23 (kTetEdges).
using MiddleNodes = std::array<std::int32_t, 6>;
/// Three mesh nodes, counter-clockwise seen from outside.
using Patch = std::array<std::int32_t, 3>;

/// Vectors of a mesh file's elements, by name: [T] each.
using CellVectors = std::map<std::string, std::vector<Eigen::Vector3d>>;

/// A named group of a mesh file (a Gmsh physical group; groups of one name are one group).
struct MeshGroup {
    std::vector<std::int32_t> node;  ///< mesh nodes of all its elements, ascending
    std::vector<Patch> triangle;     ///< its triangles, turned as in the file
    std::vector<std::int32_t> tet;   ///< its tetrahedra, ascending
};

/// N nodes, T tetrahedra. Every node belongs to a tetrahedron.
struct TetMesh {
    std::vector<Eigen::Vector3d> position_m;  ///< [N] rest positions
    std::vector<Tet> tet;                     ///< [T]
    std::vector<MiddleNodes> middle;          ///< [T]; empty where tetrahedra have their corners only
    std::map<std::string, MeshGroup> group;
    CellVectors vectors;  ///< those that were asked for
    /// [N] of a scan that was wrapped to be filled: how far each node of the surface is from it; 0 inside. Else empty.
    std::vector<double> scan_distance_m;
    Eigen::Vector3d origin_m =
        Eigen::Vector3d::Zero();            ///< of position_m, in the file's frame: not 0 where the body was moved
    std::vector<std::uint64_t> tet_number;  ///< [T] in the file, for errors; empty for a generated mesh
    std::size_t unused_nodes = 0;           ///< of the file, left out
    std::size_t turned = 0;                 ///< tetrahedra that stood the other way round
    std::vector<std::string> notes;         ///< what the reader mended or left out, one line each
};

/// Calls visit(node) for the corners of a tetrahedron, then for the nodes in the middle of its edges, where it has
/// them.
template <typename Visit>
void for_each_node(const TetMesh& mesh, std::size_t t, Visit visit) {
    for (std::int32_t node : mesh.tet[t]) visit(node);
    if (mesh.middle.empty()) return;
    for (std::int32_t node : mesh.middle[t]) visit(node);
}

/// Six times the signed volume: det(p1-p0, p2-p0, p3-p0), m^3.
double six_volumes(const std::vector<Eigen::Vector3d>& position_m, const Tet& tet);

}  // namespace haptable
