// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/mesh/fill.hpp"
#include "host/mesh/mesh.hpp"
#include "host/mesh/soup.hpp"

namespace haptable {

struct ReadOptions {
    double scale_m = 1.0;    ///< metres per unit of the file
    bool linearize = false;  ///< take second-order tetrahedra by their corners
    FillTarget fill;         ///< how to fill a closed surface; belongs to a file without tetrahedra
    WatchFill watch{};       ///< while it is filled
    bool quadratic = false;  ///< tetrahedra are to have nodes in the middle of their edges: the file's or straight ones
    std::vector<std::string> vectors{};  ///< of cells, VTK's both kinds: names to keep in TetMesh::vectors
};

/// Reads a tetrahedral mesh whose format its content tells: Gmsh .msh (1, 2.2, 4.1; text or binary), VTK legacy and
/// XML, INRIA .mesh, TetGen .node/.ele, Abaqus .inp, Vega .veg. Nodes keep the order of their numbers in the file;
/// those that no tetrahedron uses are left out, and tetrahedra that stand the other way round are turned: both are
/// counted and said in TetMesh::notes. A closed surface (STL, OBJ, PLY, OFF, or triangles alone in one of those
/// formats) is filled. `quadratic`: second-order tetrahedra are taken as they are, unless `linearize` says otherwise,
/// and to all others add_middles() gives nodes. Throws Error that names the file and the node or element, by its number
/// in the file.
TetMesh read_mesh(const std::filesystem::path& file, const ReadOptions& options);
inline TetMesh read_mesh(const std::filesystem::path& file, double scale_m) {
    return read_mesh(file, ReadOptions{scale_m, false, {}, {}});
}

/// The triangles of a surface's file, welded; of a body of tetrahedra, those that bound it. Metres. Throws Error as
/// read_mesh does, and where there are none.
Soup read_triangles(const std::filesystem::path& file, double scale_m);

/// The files that are read for it: two for TetGen's pair.
std::vector<std::filesystem::path> mesh_files(const std::filesystem::path& file);

}  // namespace haptable
