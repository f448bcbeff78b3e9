// SPDX-License-Identifier: GPL-2.0-or-later
// A body of linear tetrahedra: nodes, elements, and the named groups of the file it came from.
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
/// Three mesh nodes, counter-clockwise seen from outside.
using Patch = std::array<std::int32_t, 3>;

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
    std::map<std::string, MeshGroup> group;
    Eigen::Vector3d origin_m =
        Eigen::Vector3d::Zero();            ///< of position_m, in the file's frame: not 0 where the body was moved
    std::vector<std::uint64_t> tet_number;  ///< [T] in the file, for errors; empty for a generated mesh
    std::size_t unused_nodes = 0;           ///< of the file, left out
    std::size_t turned = 0;                 ///< tetrahedra that stood the other way round
    std::vector<std::string> notes;         ///< what the reader mended or left out, one line each
};

/// Six times the signed volume: det(p1-p0, p2-p0, p3-p0), m^3.
double six_volumes(const std::vector<Eigen::Vector3d>& position_m, const Tet& tet);

}  // namespace haptable
