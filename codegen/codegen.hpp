// SPDX-License-Identifier: GPL-2.0-or-later
// Tables in, C text out. Knows no finite elements: it reads the files of a precompute folder.
#pragma once

#include "codegen/model.hpp"
#include "codegen/precision.hpp"
#include "firmware/haptable_body.h"
#include "host/tables/tables.hpp"

struct haptable_body;

namespace haptable {

/// Above this the servo's rounding is told, 1 % of what a hand can tell apart.
inline constexpr double kMostServoError = 1e-3;

/// Another way to make the tables of the same body.
struct Remedy {
    std::string text;    ///< what to write into the scene
    double error = 0.0;  ///< ServoError::worst with it, measured
};

/// What a model takes, and what other ways to store its blocks would.
struct ModelSize {
    std::uint64_t tables_hash = 0;          ///< haptable_model.hash, of all parts
    std::vector<TableBytes> flash;          ///< by table, in the order of model.c
    std::vector<PrecisionError> precision;  ///< of S; empty where the force reads none
    ServoError servo;                       ///< what float32 costs of the force
    std::vector<Remedy> remedies;  ///< where that is more than kMostServoError: what would leave less, best first
    ServoStiffness stiffness;      ///< what it feels like
    ServoIndex index;              ///< of the spatial index
};

/// "; WHAT leaves ERROR, ..."; empty without any.
std::string describe(const std::vector<Remedy>& remedies);

/// Reads the tables in `folder` and writes model.h and model.c beside them: same tables, same bytes.
/// Throws Error that names the file when a table is missing, damaged or not what was written, and Error where the
/// object is too large for the servo or for its flash budget, or is not that of the folder's tables_hash, where it has
/// one.
ModelSize generate_model(const TablesFolder& folder);

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
/// pair: of two fingers; null: one. body_modes: of a body that rings; null: it does not. body: nothing holds it; null:
/// it is held.
ModelText model_text(const Tables& tables, const ServoModel& servo, const ServoPair* pair = nullptr,
                     const ServoModes* body_modes = nullptr, const haptable_body* body = nullptr);

}  // namespace haptable
