// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/loaded_scene.hpp"

#include <fmt/format.h>

#include <utility>

#include "codegen/in_memory.hpp"
#include "codegen/rigid_body.hpp"
#include "codegen/scene_bytes.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

/// The coupling as the servo reads it, of a patch with itself: a finger that presses is pushed back.
void require_definite(const haptable_pair_model& pair, const TablesFolder& folder) {
    std::array<std::array<float, 9>, std::size_t{HAPTABLE_PAIR_CONTROLS} * HAPTABLE_PAIR_CONTROLS> block;
    const std::size_t count = pair.law->controls;
    for (std::uint16_t patch = 0; patch < pair.model->patch_count; ++patch) {
        pair.blocks(&pair, patch, patch, reinterpret_cast<float(*)[9]>(block.data()));
        for (std::size_t c = 0; c < count; ++c) {
            std::array<double, 9> own{};
            bool is_zero = true;  // held still
            for (std::size_t e = 0; e < 9; ++e) {
                own[e] = static_cast<double>(block[c * count + c][e]);
                is_zero = is_zero && own[e] == 0.0;
            }
            if (!is_zero && !is_definite(own))
                folder.fail(pair.block != nullptr ? "coupling.npy"
                            : pair.fine_count > 0 ? "coupling_fine.npy"
                                                  : "coupling_core.npy",
                            fmt::format("couples a place of patch {} with itself by a block that is not positive "
                                        "definite: it would pull",
                                        patch));
        }
    }
}

}  // namespace

SceneFiles read_scene_files(const TablesFolder& folder) {
    return {folder,           read_tables(folder), read_pair(folder), read_rigid_body(folder), read_modes(folder),
            read_tool(folder)};
}

SceneFiles read_unlimited(const TablesFolder& folder) {
    SceneFiles files = read_scene_files(folder);
    files.tables.limits = {};
    return files;
}

LoadedScene::LoadedScene(const TablesFolder& folder) : LoadedScene(read_scene_files(folder)) {
    require_tables_hash(folder.tables_hash());
}

void LoadedScene::require_tables_hash(std::uint64_t wanted) const {
    if (model_.hash != wanted)
        folder_.fail("tables.json", fmt::format("the folder's files make tables {:016x}, not its tables_hash {:016x}",
                                                model_.hash, wanted));
}

LoadedScene::LoadedScene(SceneFiles files)
    : folder_(std::move(files.folder)),
      tables_(std::move(files.tables)),
      servo_(build_model(tables_)),
      model_(model_in_memory(tables_, servo_)),
      node_(servo_.node.begin(), servo_.node.end()),
      body_(files.body),
      body_modes_(std::move(files.body_modes)),
      tool_(std::move(files.tool)) {
    if (files.pair) {
        servo_pair_ = build_pair(*files.pair, tables_, servo_);
        pair_ = pair_in_memory(*servo_pair_, tables_, model_);
        require_definite(pair_, folder_);
    }
    if (tool_) {
        if (!servo_pair_) folder_.fail("tool.json", "is of a tool, and there is no coupling.npy");
        tool_points_ = points_of(*tool_);
        tool_model_ = tool_in_memory(*tool_, tool_points_, pair_);
    }
    if (body_modes_) {
        servo_modes_ = build_modes(*body_modes_, tables_, servo_);
        modes_ = modes_in_memory(servo_modes_);
        if (!body_modes_->row.empty() && body_modes_->row.size() != tables_.row_id.size() * body_modes_->modes())
            folder_.fail("mode_rows.npy", "does not fit row_id.npy");
    }
    model_.hash = tables_hash(model_, pair(), body(), servo_modes(), tool());
}

}  // namespace haptable
