// SPDX-License-Identifier: GPL-2.0-or-later
// A model as one row of bytes: what its hash is taken of, and what an image or a page reads
// (firmware/port/haptable_scene_reader.h).
#pragma once

#include <string>

#include "firmware/haptable_model.h"

namespace haptable {

/// All fields but the hash, in the order of HAPTABLE_MODEL_FIELDS and without padding, little-endian: values; tables
/// after their number of rows (32 bits); functions by their number among the choices, from 1 (32 bits, 0: none); the
/// compliance after a number that says whether there is one (32 bits).
/// Throws Error where the model names a function that is none of the choices.
std::string model_bytes(const haptable_model& model);

}  // namespace haptable
