// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/scene_bytes.hpp"

#include "codegen/model_bytes.hpp"
#include "codegen/pair.hpp"
#include "codegen/tool.hpp"
#include "host/base/hash.hpp"

namespace haptable {

std::string scene_bytes(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
                        const ServoModes* body_modes, const haptable_tool_model* tool) {
    if (tool != nullptr) pair = tool->points.pair;
    const std::uint32_t parts = (pair != nullptr ? 1U : 0U) | (body != nullptr ? 2U : 0U) |
                                (body_modes != nullptr ? 4U : 0U) | (tool != nullptr ? 8U : 0U);
    std::string bytes(reinterpret_cast<const char*>(&parts), sizeof parts);
    bytes += model_bytes(model);
    if (pair != nullptr) bytes += coupling_bytes(*pair);
    if (body != nullptr) bytes.append(reinterpret_cast<const char*>(body), sizeof *body);
    if (body_modes != nullptr) bytes += modes_bytes(*body_modes);
    if (tool != nullptr) bytes += tool_bytes(*tool);
    return bytes;
}

std::uint64_t tables_hash(const haptable_model& model, const haptable_pair_model* pair, const haptable_body* body,
                          const ServoModes* body_modes, const haptable_tool_model* tool) {
    if (pair == nullptr && body == nullptr && body_modes == nullptr && tool == nullptr) return model.hash;
    Hash hash;
    hash.add(std::span<const std::uint64_t>(&model.hash, 1));
    hash.add(scene_bytes(model, pair, body, body_modes, tool));
    return hash.digest();
}

}  // namespace haptable
