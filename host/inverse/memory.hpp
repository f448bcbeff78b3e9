// SPDX-License-Identifier: GPL-2.0-or-later
// What a run will need of the machine's memory, known from the factor's pattern before the long work begins.
#pragma once

#include <string>

namespace haptable {

/// Bytes by part. Fronts and columns are never held at the same time.
struct MemoryNeed {
    double stiffness = 0.0;  ///< K
    double factor = 0.0;     ///< L and the workspace of the factorisation
    double fronts = 0.0;     ///< of the selected inversion
    double pairs = 0.0;      ///< of blocks that are not in the factor's pattern
    double columns = 0.0;    ///< workspace of the pruned solves; columns.npy itself is on the disk
    double solves = 0.0;     ///< workspace of the plain solves that check
    double available = 0.0;  ///< what the machine has free

    double peak() const;
};

/// Bytes that this process may still take: the kernel's estimate, or what is left of the control group's limit.
/// Infinite where neither can be read.
double available_memory();

/// Throws Error where the need is more than what is available, with what would fit.
///   scene  named in the error
void require_memory(const std::string& scene, const MemoryNeed& need, double node_count);

}  // namespace haptable
