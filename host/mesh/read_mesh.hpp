// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>

#include "host/mesh/mesh.hpp"

namespace haptable {

/// Reads a tetrahedral mesh through the Gmsh library: Gmsh .msh (1, 2.2, 4.1; text or binary) and VTK legacy .vtk.
/// scale_m: metres per unit of the file. Nodes keep the order of their numbers in the file; those that no tetrahedron
/// uses are left out, and tetrahedra that stand the other way round are turned: both are said in TetMesh::notes.
/// Throws Error that names the file and the node or element, by its number in the file.
/// Not for two threads at once: the Gmsh library has one global state.
TetMesh read_mesh(const std::filesystem::path& file, double scale_m);

}  // namespace haptable
