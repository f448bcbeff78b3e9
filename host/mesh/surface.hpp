// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <span>

#include "host/mesh/mesh.hpp"

namespace haptable {

/// The boundary of a body of tetrahedra.
struct Surface {
    std::vector<Patch> patch;        ///< [q] counter-clockwise from outside, in the order of their tetrahedra
    std::vector<std::int32_t> node;  ///< mesh nodes on it, ascending
    std::vector<std::array<std::int32_t, 2>> joint;  ///< the two tetrahedra that meet in each inner face
};

/// The faces that belong to exactly one tetrahedron. All tetrahedra must be positively oriented.
/// Throws Error that names the tetrahedra where a face belongs to more than two.
Surface find_surface(std::span<const Tet> tets);

}  // namespace haptable
