// SPDX-License-Identifier: GPL-2.0-or-later
// A scene in memory: the files of its folder, read and checked, and the servo's tables that are made of them.
#pragma once

#include <optional>
#include <vector>

#include "codegen/body_modes.hpp"
#include "codegen/model.hpp"
#include "codegen/pair.hpp"
#include "codegen/tool.hpp"
#include "firmware/haptable_body.h"
#include "host/tables/folder.hpp"
#include "host/tables/modes.hpp"
#include "host/tables/pair.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// What the files of a folder hold, besides columns and factor.
struct SceneFiles {
    TablesFolder folder;
    Tables tables;
    std::optional<PairTables> pair;        ///< of two fingers, or of a tool's points
    std::optional<haptable_body> body;     ///< of a body that nothing holds
    std::optional<ModeTables> body_modes;  ///< of a body that rings
    std::optional<ToolTables> tool;        ///< that one hand holds
};

/// Throws Error that names the file: missing, damaged, not what was written, or not fitting the others.
SceneFiles read_scene_files(const TablesFolder& folder);

/// The same without the device's limits: the body's own force, however a finger jumps.
SceneFiles read_unlimited(const TablesFolder& folder);

/// The servo's tables of a scene. const once it is made; any number of servos may read it.
class LoadedScene {
public:
    /// Reads the folder, and builds its servo's tables again. Throws Error as read_scene_files does, and where they are
    /// not those of the folder's tables_hash.
    explicit LoadedScene(const TablesFolder& folder);
    /// From files that somebody changed: without limits, in another mode. Throws Error if the servo cannot hold them.
    explicit LoadedScene(SceneFiles files);
    LoadedScene(const LoadedScene&) = delete;
    LoadedScene& operator=(const LoadedScene&) = delete;

    /// Throws Error where its tables are others.
    void require_tables_hash(std::uint64_t wanted) const;

    const TablesFolder& folder() const { return folder_; }
    const Tables& tables() const { return tables_; }
    const ServoModel& servo() const { return servo_; }
    /// Its hash is the scene's: of all parts.
    const haptable_model& model() const { return model_; }
    /// [model().vertex_count] mesh node of each vertex.
    const std::vector<std::uint32_t>& node() const { return node_; }

    /// Null where the scene has none.
    const ServoPair* servo_pair() const { return pair() != nullptr ? coupling() : nullptr; }
    const haptable_pair_model* pair() const { return servo_pair_ && !tool_ ? &pair_ : nullptr; }
    /// The coupling of two fingers, or of a tool's points.
    const ServoPair* coupling() const { return servo_pair_ ? &*servo_pair_ : nullptr; }
    const haptable_tool_model* tool() const { return tool_ ? &tool_model_ : nullptr; }
    const ToolTables* tool_tables() const { return tool_ ? &*tool_ : nullptr; }
    const ToolPoints& tool_points() const { return tool_points_; }
    const haptable_body* body() const { return body_ ? &*body_ : nullptr; }
    const haptable_modes* modes() const { return body_modes_ ? &modes_ : nullptr; }
    const ModeTables* body_modes() const { return body_modes_ ? &*body_modes_ : nullptr; }
    const ServoModes* servo_modes() const { return body_modes_ ? &servo_modes_ : nullptr; }

private:
    TablesFolder folder_;
    Tables tables_;
    ServoModel servo_;
    haptable_model model_;
    std::vector<std::uint32_t> node_;
    std::optional<ServoPair> servo_pair_;
    haptable_pair_model pair_{};
    std::optional<haptable_body> body_;
    std::optional<ModeTables> body_modes_;
    ServoModes servo_modes_;
    haptable_modes modes_{};
    std::optional<ToolTables> tool_;
    ToolPoints tool_points_;
    haptable_tool_model tool_model_{};
};

}  // namespace haptable
