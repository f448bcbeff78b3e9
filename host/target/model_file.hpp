// SPDX-License-Identifier: GPL-2.0-or-later
// A model in memory as the words that the measure image reads (firmware/port/measure.c).
#pragma once

#include <string>

#include "firmware/haptable.h"

namespace haptable {

/// Head, then tables, each padded to whole words; little-endian. The functions that the model names become numbers.
/// before: they are the servo's own.
std::string model_file(const haptable_model& model);

}  // namespace haptable
