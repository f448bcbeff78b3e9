// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>

#include "host/bench/error/specimen.hpp"

namespace haptable {

/// Errors of one mesh, by force: the servo's float32 from its own equations in double, how far the force is from
/// that contact imposed on the mesh and solved for, and how far the drawn surface then misses the finger. Rows for the
/// table of contact_error_table().
std::vector<std::vector<Cell>> contact_errors(const Specimen& specimen, const Meshed& meshed,
                                              const std::vector<Truth>& truths, const std::filesystem::path& build);
NumberTable contact_error_table(std::vector<std::vector<Cell>> rows);

}  // namespace haptable
