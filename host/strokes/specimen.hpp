// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies that are stroked: scenes and meshes of files and folders, each mesh once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace haptable {

/// A body that passed the audit.
struct Specimen {
    std::string name;  ///< the mesh file's stem, or the scene's name where it is generated
    Scene scene;       ///< held and made of something; mask_radius_m is two mean edges of its surface
    std::size_t nodes = 0, patches = 0, hinges = 0;  ///< hinges: edges and nodes
};

/// One that did not, or that is too large.
struct Refused {
    std::string name, why;
};

struct Specimens {
    std::vector<Specimen> taken;
    std::vector<Refused> refused;
};

/// Of files and folders (not of the folders in them): scenes (.toml) as they are, but touchable everywhere; meshes
/// 0.1 m long, of 10 kPa, the lowest tenth of the nodes of each part held, surfaces filled with 3,000 nodes, or with as
/// many more as their creases need. A mesh of the same bytes as an earlier one is left out. Names that do not contain
/// one of `only` too, where it has some. most_nodes: larger ones are refused.
Specimens collect_specimens(const std::vector<std::filesystem::path>& places, const std::vector<std::string>& only,
                            std::size_t most_nodes, const std::filesystem::path& folder);

/// The scene as a file that reads back: mesh, material, what is held, contact.
std::string to_toml(const Scene& scene);

}  // namespace haptable
