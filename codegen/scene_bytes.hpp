// SPDX-License-Identifier: GPL-2.0-or-later
// A scene as one row of bytes: what an image reads that is not linked with one (firmware/port/haptable_scene_reader.h).
#pragma once

#include <cstdint>
#include <string>

#include "codegen/body_modes.hpp"
#include "firmware/haptable_body.h"
#include "firmware/haptable_pair.h"

struct haptable_tool_model;

namespace haptable {

/// Which parts there are (32 bits: 1 pair, 2 body, 4 modes, 8 tool), then model_bytes, coupling_bytes, the body's table
/// as it is, modes_bytes, tool_bytes. pair, body, body_modes, tool: null where the scene has none; a tool brings its
/// own pair. Throws Error where the model names a function that is none of the servo's.
std::string scene_bytes(const haptable_model& model, const haptable_pair_model* pair = nullptr,
                        const haptable_body* body = nullptr, const ServoModes* body_modes = nullptr,
                        const haptable_tool_model* tool = nullptr);

/// XXH3 of the model's hash and of all parts: model.hash where the scene has a model alone. Messages, frames and
/// summaries carry it.
std::uint64_t tables_hash(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
                          const ServoModes* body_modes, const haptable_tool_model* tool = nullptr);

}  // namespace haptable
