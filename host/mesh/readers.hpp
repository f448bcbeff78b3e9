// SPDX-License-Identifier: GPL-2.0-or-later
// Two functions a format, each by the line of host/base/mesh_formats.inc: does a file hold it, and what does it say?
// Readers throw Error with the file and its line.
#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/text.hpp"
#include "host/mesh/raw_mesh.hpp"

namespace haptable {

/// A mesh file, read whole.
struct MeshFile {
    /// vectors: names of the cells' arrays of three components to keep, by the formats that have such.
    MeshFile(std::filesystem::path file, std::string_view whole, std::span<const std::string> wanted = {})
        : path(std::move(file)),
          text(whole),
          vectors(wanted),
          head(text.substr(0, 4096)),
          first(head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()))),
          ending(lower(path.extension().string())) {}

    std::filesystem::path path;
    std::string_view text;
    std::span<const std::string> vectors;
    std::string_view head;   ///< its first 4096 bytes
    std::string_view first;  ///< the same, from the first character that is no blank
    std::string ending;      ///< of its name, in lower case
};

[[noreturn]] inline void fail(const std::filesystem::path& file, const std::string& what) {
    throw Error(file.string() + ": " + what);
}

#define HAPTABLE_MESH_FORMAT(NAME, ...)   \
    bool is_##NAME(const MeshFile& file); \
    RawMesh read_##NAME(const MeshFile& file);
#include "host/base/mesh_formats.inc"

/// Surfaces that CGAL reads.
enum class SurfaceKind { kStl, kPly, kOff, kObj };

/// "0,5" is read as 0 or as 0.5, as the locale will: neither is what a file of numbers may depend on.
void refuse_comma_decimals(const std::filesystem::path& file, std::string_view text);

/// Vectors of a legacy VTK file, by the order of its tetrahedra; names that it lacks are left out.
CellVectors read_vtk_vectors(const std::filesystem::path& file, std::string_view text,
                             std::span<const std::string> wanted);

}  // namespace haptable
