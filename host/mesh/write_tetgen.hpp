// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "host/mesh/mesh.hpp"

namespace haptable {

/// TetGen's pair of files, stem.node and stem.ele, numbered from 0, positions in their own unit and to the last bit.
/// Makes the folder. Returns the .node file, which is written last. Throws Error that names the file.
std::filesystem::path write_tetgen(const std::vector<Eigen::Vector3d>& position, const std::vector<Tet>& tet,
                                   const std::filesystem::path& stem);

}  // namespace haptable
