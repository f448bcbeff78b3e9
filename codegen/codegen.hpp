// SPDX-License-Identifier: GPL-2.0-or-later
// Tables in, C text out. Knows no finite elements: it reads the files of a precompute folder.
#pragma once

#include "codegen/size.hpp"
#include "host/tables/tables.hpp"

struct haptable_body;

namespace haptable {

struct ServoModel;

/// Reads the tables in `folder` and writes model.h and model.c beside them, unless told to measure and check alone:
/// same tables, same bytes. Throws Error that names the file when a table is missing, damaged or not what was written,
/// and Error where the object is too large for the servo or for its flash budget, or is not that of the folder's
/// tables_hash, where it has one.
ModelSize generate_model(const TablesFolder& folder, bool writes_code = true);

/// Bytes of flash that each of the servo's tables takes, in the order of model.c.
std::vector<TableBytes> flash_tables(const ServoModel& model);

/// Throws Error that lists what takes the room, and what would make it fit, where the tables take more than the budget
/// (0: none).
void require_flash(const std::vector<TableBytes>& tables, const ServoModel& model, std::uintmax_t budget_bytes);

/// Bytes of flash that the servo's tables take.
std::size_t flash_bytes(const ServoModel& model);

/// The two C files of one model.
struct ModelText {
    std::string header;
    std::string source;
};
struct ServoPair;
struct ServoModes;
struct ToolTables;
/// pair: of two fingers, or of a tool's points; null: one finger. body_modes: of a body that rings; null: it does not.
/// body: nothing holds it; null: it is held. tool: null: none.
ModelText model_text(const Tables& tables, const ServoModel& servo, const ServoPair* pair = nullptr,
                     const ServoModes* body_modes = nullptr, const haptable_body* body = nullptr,
                     const ToolTables* tool = nullptr);

}  // namespace haptable
