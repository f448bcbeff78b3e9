// SPDX-License-Identifier: GPL-2.0-or-later
// Blocks of S or C in 16 bits, and what that does to the force.
#pragma once

#include "codegen/size.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

struct ServoModel;

/// Packs the blocks that the force reads, of S or of a compliance: float32 leaves them, float16 and int16 fill
/// model.packed. The floats stay, for comparison: codegen does not write them.
void pack_blocks(Storage precision, ServoModel& model);

/// float32, float16 and int16 against the double tables: on every touchable patch at its corners, mid-edges and
/// centroid, with the worst direction of u (the 2-norm of (S - S_double) S_double^-1). The blocks are read by the
/// firmware's own code.
std::vector<PrecisionError> compare_precisions(const Tables& tables, const ServoModel& model);

/// How deep a small dent is: a fifth of the body's volume over its surface, so 1 mm in a cube of 30 mm and a tenth of a
/// plate's thickness.
double small_dent_m(const Tables& tables);

/// By the firmware's own force. Points where C is singular are left out.
ServoError measure_servo(const Tables& tables, const ServoModel& model);

/// True where every block that the force reads, as it is stored, is positive definite, so that no force can pull.
bool has_definite_blocks(const Tables& tables, const ServoModel& model);

/// Throws Error where the chosen one would give no force worth the name, and float32 would.
void require_precision(const std::vector<PrecisionError>& all, Storage chosen);

}  // namespace haptable
