// SPDX-License-Identifier: GPL-2.0-or-later
// Blocks of S or C in 16 bits, and what that does to the force.
#pragma once

#include "codegen/model.hpp"

namespace haptable {

/// Packs the blocks that the force reads, of S or of a compliance: float32 leaves them, float16 and int16 fill
/// model.packed. The floats stay, for comparison: codegen does not write them.
void pack_blocks(Storage precision, ServoModel& model);

/// What one way of storing the blocks costs and gives.
struct PrecisionError {
    Storage precision = Storage::kFloat32;
    std::size_t bytes = 0;  ///< of the blocks
    double worst = 0.0;  ///< largest |F - F_double| / |F_double| over patches, points of them and all directions of u
    double mean = 0.0;   ///< over patches and points, of the worst direction there
};

/// float32, float16 and int16 against the double tables: on every touchable patch at its corners, mid-edges and
/// centroid, with the worst direction of u (the 2-norm of (S - S_double) S_double^-1). The blocks are read by the
/// firmware's own code.
std::vector<PrecisionError> compare_precisions(const Tables& tables, const ServoModel& model);

/// What the servo's float32 costs, from positions to force, with blocks in float32: largest |F - F_double| / |F_double|
/// over patches, points of them and three directions of u (along the normal and across it), as deep as a small dent.
struct ServoError {
    double depth_m = 0.0;  ///< of the dent

    double worst = 0.0;        ///< of the servo as it is
    double force_alone = 0.0;  ///< with u exact: blocks and arithmetic, not the positions that u is a difference of
};

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
