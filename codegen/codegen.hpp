// SPDX-License-Identifier: GPL-2.0-or-later
// Tables in, C text out. Knows no finite elements: it reads the files of a precompute folder.
#pragma once

#include <filesystem>

#include "codegen/model.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// Reads the tables in `folder` and writes model.h and model.c beside them: same tables, same bytes.
/// Throws Error that names the file when a table is missing or damaged, or the object is too large for the servo.
void generate_model(const std::filesystem::path& folder);

/// Throws Error where a touchable surface has more vertices or patches than the servo's 16-bit indices can number.
void require_fits(std::size_t vertex_count, std::size_t patch_count);

/// Bytes of flash that the servo's tables take.
std::size_t flash_bytes(const ServoModel& model);

/// The two C files of one model.
struct ModelText {
    std::string header;
    std::string source;
};
ModelText model_text(const Tables& tables, const ServoModel& model);

}  // namespace haptable
