// SPDX-License-Identifier: GPL-2.0-or-later
// How a body rings: the files of a scene with [body] modes.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/tables/folder.hpp"

namespace haptable {

/// m modes; n controls, which are those of PairTables: the servo's free vertices, or under a mask all its vertices and
/// edges, each with its own weights w; r drawn rows.
struct ModeTables {
    std::vector<double> omega_rad_per_s;       ///< [m] of the body without damping, ascending
    double damping_ratio = 0.0;                ///< of each
    std::size_t control_count = 0;             ///< n
    std::vector<std::array<double, 3>> shape;  ///< [n m] w_k^T phi, 1/sqrt(kg), by control
    std::vector<std::array<float, 3>> row;     ///< [r m] phi of the rows of row_id.npy; none where nothing is drawn

    std::size_t modes() const { return omega_rad_per_s.size(); }
};

/// modes.json, mode_shape.npy and, where something is drawn, mode_rows.npy.
void write_modes(const ModeTables& tables, const std::filesystem::path& folder);

/// None where the folder's body does not ring. Throws Error that names the file: missing, damaged or not fitting.
std::optional<ModeTables> read_modes(const TablesFolder& folder);

}  // namespace haptable
