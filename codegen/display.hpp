// SPDX-License-Identifier: GPL-2.0-or-later
// The columns of chosen rows for a target with a display: firmware/haptable_deformation.h.
#pragma once

#include "codegen/model.hpp"
#include "firmware/haptable_deformation.h"
#include "host/tables/folder.hpp"

namespace haptable {

/// The tables of struct haptable_deformation, n free vertices, r rows; `column` or `packed`, by the precision.
struct Display {
    std::vector<std::uint32_t> node;           ///< [r]
    std::vector<std::array<float, 3>> rest_m;  ///< [r]
    std::vector<std::array<float, 9>> column;  ///< [n r] m/N
    std::vector<std::array<std::int16_t, 9>> packed;
    std::vector<float> packed_scale;  ///< [n] m/N
    std::size_t bytes() const;        ///< of flash
};

/// Reads the rows that the scene asks for from columns.npy in `folder`. Throws Error that names a row without columns.
Display build_display(const TablesFolder& folder, const Tables& tables);

/// The firmware's struct, for the servo with this hash of its tables; it points into `display`, which must outlive it
/// and stay where it is.
haptable_deformation display_in_memory(const Tables& tables, std::uint64_t tables_hash, const Display& display);

/// display.h and display.c beside the model.h of that hash; returns the bytes of flash that they take.
std::size_t write_display(const TablesFolder& folder, const Tables& tables, std::uint64_t tables_hash);

}  // namespace haptable
