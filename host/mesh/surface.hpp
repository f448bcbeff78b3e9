// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <span>

#include "host/mesh/mesh.hpp"

namespace haptable {

/// A face of a tetrahedron with nodes in the middle of its edges: its corners, counter-clockwise from outside, then the
/// middles of 01 12 20.
using QuadraticFace = std::array<std::int32_t, 6>;

/// The boundary of a body of tetrahedra.
struct Surface {
    std::vector<Patch> patch;        ///< [q] counter-clockwise from outside, in the order of their tetrahedra
    std::vector<std::int32_t> node;  ///< mesh nodes on it, ascending
    /// [q / 4] where edges have nodes in their middle: patches 4 f .. 4 f + 3 are the quarters of face f, those at its
    /// corners and the one between its middles; else empty.
    std::vector<QuadraticFace> face;
    std::vector<std::array<std::int32_t, 2>> joint;  ///< the two tetrahedra that meet in each inner face
};

/// The faces that belong to exactly one tetrahedron. All tetrahedra must be positively oriented.
/// Throws Error that names the tetrahedra where a face belongs to more than two.
Surface find_surface(std::span<const Tet> tets);
/// The same with the mesh's middle nodes: four patches a face.
Surface find_surface(const TetMesh& mesh);
/// The quarters of a face, in the order of Surface::patch.
std::array<Patch, 4> quarters_of(const QuadraticFace& face);

/// What a patch that may be touched is a quarter of.
struct Quarter {
    QuadraticFace face{};
    int place = 0;          ///< in quarters_of(face)
    bool is_whole = false;  ///< all four may be touched
};

}  // namespace haptable
