// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies that are stroked: scenes and meshes of files and folders, each mesh once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace haptable {

/// A mesh that passed the audit, as a body.
struct StrokedMesh {
    std::string name;      ///< the mesh file's stem, or the scene's name where it is generated
    std::string identity;  ///< of the mesh file's bytes, or of how it is generated
    Scene scene;           ///< held and made of something; mask_radius_m is two mean edges of its surface
    bool filled = false;   ///< a surface, filled with tetrahedra
    std::size_t nodes = 0, patches = 0;
    std::size_t parts = 1;  ///< that hang together each

    /// Bytes of a block for any two places: vertices; under a mask edges too.
    std::uintmax_t coupling_bytes(ForceLaw force) const;
};

/// One that did not pass, is too large, or is the same as another.
struct LeftOut {
    std::string name, why;
};

struct StrokedMeshes {
    std::vector<StrokedMesh> taken;
    std::vector<LeftOut> left_out;
};

/// Bodies of files and folders (not of the folders in them): scenes (.toml) as they are, but touchable everywhere and
/// without weight; meshes 0.1 m long, of 10 kPa, the lowest tenth of the nodes of each part held, as of a scene that
/// holds none, surfaces filled with 3,000 nodes, or with as many more as their creases need. A mesh of the same bytes
/// as an earlier one is left out. Names that do not contain one of `only` too, where it has some, and untold.
/// most_nodes: larger ones are left out.
StrokedMeshes collect_meshes(const std::vector<std::filesystem::path>& places, const std::vector<std::string>& only,
                             std::size_t most_nodes, const std::filesystem::path& folder);

/// The scene as a file that reads back: mesh, material, what is held or that nothing is, modes, contact.
std::string to_toml(const Scene& scene);

}  // namespace haptable
