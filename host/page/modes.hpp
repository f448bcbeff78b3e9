// SPDX-License-Identifier: GPL-2.0-or-later
// In which ways a page lets its body be touched: every force and god-object that the tables of a scene hold.
#pragma once

#include <string>
#include <vector>

#include "codegen/loaded_scene.hpp"

namespace haptable {

/// One way, and the servo's model of it as bytes (codegen/model_bytes.hpp).
struct PageMode {
    ForceLaw force;
    GodObject god_object;
    double friction;  ///< static; 0: none
    std::uint64_t hash;
    std::string model;
    std::string coupling;    ///< of two fingers, or of a tool's points (codegen/pair.hpp); empty: one
    std::string body_modes;  ///< of a body that rings (codegen/body_modes.hpp); empty: it follows at once
    std::string tool;        ///< that the hand holds (codegen/tool.hpp); empty: it has fingers
};

/// The scene's own mode first. Then the others of the interpolated force, which all tables hold; of the consistent
/// one, where the tables hold it or columns of float32, whose L_ij between two touchable nodes are its edges; of the
/// scene's own; each with both god-objects, without friction and with it (the scene's, or kPageFriction). A tool has
/// those of the scene's own force. What the
/// servo cannot hold of these, or not for the scene's two fingers or modes, is left out. Throws Error as
/// LoadedScene does for the scene's own.
std::vector<PageMode> page_modes(const SceneFiles& files);

/// Coulomb's coefficient where the scene names none.
inline constexpr double kPageFriction = 0.5;

/// The tables with a consistent force whose edges are read from columns.npy of `folder`: L_ij in float32 instead of
/// double. before: tables.has_columns.
Tables consistent_by_columns(const Tables& tables, const TablesFolder& folder);

}  // namespace haptable
