// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's tables without C text and compiler: for tests and benchmarks, which run the same firmware on them.
#pragma once

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

/// A model that points into `servo`, which must outlive it and stay where it is. Its hash is of its every byte, of
/// the nodes of its vertices and of what the tables were made from: tables that differ in one bit have another.
haptable_model model_in_memory(const Tables& tables, const ServoModel& servo);

}  // namespace haptable
