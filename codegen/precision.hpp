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

/// Throws Error where the chosen one would give no force worth the name, and float32 would.
void require_precision(const std::vector<PrecisionError>& all, Storage chosen);

}  // namespace haptable
