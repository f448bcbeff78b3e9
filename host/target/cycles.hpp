// SPDX-License-Identifier: GPL-2.0-or-later
// Cycles of a tick, estimated: what it executed, through LLVM's model of the core.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/target/image.hpp"

namespace haptable {

/// llvm-mca's cycles for the instructions of one tick, in the order in which they ran, as if flash answered at once and
/// every branch was foreseen: an estimate, from below. Nothing where LLVM has no model of the core, or is not
/// installed.
template <std::size_t size>
std::optional<std::uint64_t> estimate_cycles(const TargetImage& image, const TargetPath<size>& path_m,
                                             std::size_t tick);

}  // namespace haptable
