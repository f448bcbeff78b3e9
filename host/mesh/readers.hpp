// SPDX-License-Identifier: GPL-2.0-or-later
// One function a format. Each takes the file's whole text and throws Error with the file and its line.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "host/mesh/raw_mesh.hpp"

namespace haptable {

/// Gmsh's names of what its library reads: each makes the library choose the reader that we mean.
/// ".msh", ".vtk", ".mesh"
using GmshKind = std::string_view;

/// Through the Gmsh library, in a process of its own: it may crash, hang or take all memory without harm.
RawMesh read_with_gmsh(const std::filesystem::path& file, std::string_view text, GmshKind kind);

/// A closed surface in RawMesh::triangle.
enum class SurfaceKind { kStl, kPly, kOff, kObj };
RawMesh read_surface(const std::filesystem::path& file, std::string_view text, SurfaceKind kind);

/// "0,5" is read as 0 or as 0.5, as the locale will: neither is what a file of numbers may depend on.
void refuse_comma_decimals(const std::filesystem::path& file, std::string_view text);

/// TetGen's pair NAME.node, NAME.ele; either may be named.
RawMesh read_tetgen(const std::filesystem::path& file);
/// Abaqus input: *NODE, *ELEMENT (C3D4, C3D10), *NSET, *ELSET.
RawMesh read_abaqus(const std::filesystem::path& file, std::string_view text);
/// VegaFEM: *VERTICES, *ELEMENTS, *SET.
RawMesh read_vega(const std::filesystem::path& file, std::string_view text);
/// VTK XML, UnstructuredGrid: text, base64, appended; plain or zlib; either byte order.
/// vectors: names of the cells' arrays of three components to keep.
RawMesh read_vtu(const std::filesystem::path& file, std::string_view text, std::span<const std::string> vectors = {});
/// The same of a legacy file, by the order of its tetrahedra; names that it lacks are left out.
CellVectors read_vtk_vectors(const std::filesystem::path& file, std::string_view text,
                             std::span<const std::string> wanted);

}  // namespace haptable
