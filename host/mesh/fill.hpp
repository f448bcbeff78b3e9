// SPDX-License-Identifier: GPL-2.0-or-later
// A closed surface becomes a body of tetrahedra.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "host/mesh/raw_mesh.hpp"

namespace haptable {

/// How fine the body is to be: one of the two is greater than 0.
struct FillTarget {
    double edge_length = 0.0;    ///< where the surface is smooth, in units of the file; creases have shorter ones
    std::size_t node_count = 0;  ///< nodes of the body, to 5 % where its shape allows it
    std::optional<bool> wrap{};  ///< false: never, true: always; none: where the surface cannot be filled as it is
    bool given() const { return edge_length > 0.0 || node_count > 0; }
};

/// Called now and then while a surface is filled, with nodes so far and about how many there will be.
using WatchFill = std::function<void(std::size_t nodes, std::size_t expected)>;

/// Meshes the inside of raw.triangle by Delaunay refinement (CGAL's Mesh_3; Jamin, Alliez, Yvinec and Boissonnat 2015);
/// the surface is meshed anew, within a tenth of an edge of the given one, and keeps its creases of more than 75
/// degrees. Where that misses the count of nodes or the volume, or pinches the body, as the noise of a scan makes it,
/// it is filled without creases too, and the better one is taken, with a note. Same input, same mesh. Triangles that
/// are turned inside out are turned, with a note.
/// A surface that is open, not manifold, intersects itself or cannot be filled for its creases is wrapped first: by a
/// watertight surface that a ball makes that rolls over it (CGAL's Alpha_wrap_3), pulled in by the gap to it. Holes are
/// closed, inner cavities are lost, a note says how far the body is from the surface, and RawMesh::scan_distance where.
/// Throws Error where it may not be wrapped, which counts the bad edges and says where the first is, where its
/// triangles bound no body, and where the filling has a cavity that the surface does not have.
RawMesh fill_surface(const std::filesystem::path& file, const RawMesh& raw, const FillTarget& target,
                     const WatchFill& watch = {});

}  // namespace haptable
