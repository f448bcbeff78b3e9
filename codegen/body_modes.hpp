// SPDX-License-Identifier: GPL-2.0-or-later
// The tables of a body that rings: firmware/haptable_modes.h.
#pragma once

#include <string>

#include "codegen/model.hpp"
#include "codegen/template.hpp"
#include "firmware/haptable_modes.h"
#include "host/tables/modes.hpp"

namespace haptable {

/// The tables of struct haptable_modes.
struct ServoModes {
    std::vector<haptable_mode> mode;
    std::vector<std::array<float, 3>> shape;
    std::uint8_t controls = 3;
};

/// A tick of a mode under a force that is held, exactly; 0 < damping_ratio < 1.
haptable_mode tick_of_mode(double omega_rad_per_s, double damping_ratio);

/// Throws Error where the tables do not fit the model, or hold a number that no float does.
ServoModes build_modes(const ModeTables& body_modes, const Tables& tables, const ServoModel& servo);

/// Points to the tables, which must outlive it.
haptable_modes modes_in_memory(const ServoModes& body_modes);

/// What a page reads behind a model: number of modes and controls of a patch (32 bits each), both tables, each after
/// its number of rows, then the number of the surface's controls and the CRC, little-endian.
std::string modes_bytes(const ServoModes& body_modes);

/// Bytes of flash, by table.
std::vector<TableBytes> flash_tables(const ServoModes& body_modes);

/// What model.c says of it.
void add_mode_values(const ServoModes& body_modes, TemplateValues& values);

}  // namespace haptable
