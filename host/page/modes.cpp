// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/modes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "codegen/in_memory.hpp"
#include "codegen/model_bytes.hpp"
#include "host/base/error.hpp"
#include "host/tables/columns.hpp"

namespace haptable {

namespace {

constexpr double kRelease_n_per_ms = 0.01;  // a scene's default with least energy

PageMode mode_of(const SceneFiles& files) {
    const LoadedScene scene(files);
    Tables unlimited = files.tables;
    unlimited.limits = {};  // a page has no motors, and a pointer jumps
    const haptable_model model = model_in_memory(unlimited, scene.servo());
    PageMode mode{unlimited.force,
                  unlimited.god_object,
                  unlimited.static_friction,
                  scene.model().hash,
                  model_bytes(model),
                  "",
                  "",
                  ""};
    if (scene.servo_modes() != nullptr) mode.body_modes = modes_bytes(*scene.servo_modes());
    if (scene.coupling() == nullptr) return mode;
    ServoPair coupling = *scene.coupling();
    coupling.finger_count = std::min<std::uint16_t>(coupling.finger_count, HAPTABLE_FINGERS);  // a page has two at most
    const haptable_pair_model pair = pair_in_memory(coupling, unlimited, model);
    mode.coupling = coupling_bytes(pair);
    if (scene.tool() != nullptr)
        mode.tool = tool_bytes(tool_in_memory(*scene.tool_tables(), scene.tool_points(), pair));
    return mode;
}

bool has(const std::vector<PageMode>& modes, const Tables& tables) {
    return std::any_of(modes.begin(), modes.end(), [&](const PageMode& mode) {
        return mode.force == tables.force && mode.god_object == tables.god_object &&
               (mode.friction > 0.0) == (tables.static_friction > 0.0);
    });
}

/// Both god-objects over the blocks of one force, without friction and with it.
void add_modes(SceneFiles files, std::vector<PageMode>& modes) {
    Tables& tables = files.tables;
    const double friction = tables.static_friction > 0.0 ? tables.static_friction : kPageFriction;
    const double kinetic = tables.static_friction > 0.0 ? tables.kinetic_friction : kPageFriction;
    for (const bool rough : {false, true})
        for (const GodObject god_object : every<GodObject>()) {
            tables.god_object = god_object;
            tables.static_friction = rough ? friction : 0.0;
            tables.kinetic_friction = rough ? kinetic : 0.0;
            const bool releases = god_object == GodObject::kLeastEnergy && !files.tool;
            tables.options.set("contact.release_slew", releases ? kRelease_n_per_ms : 0.0);
            if (has(modes, tables)) continue;
            try {
                modes.push_back(mode_of(files));
            } catch (const Error&) {  // more than the servo can hold: the scene never asked for it
            }
        }
}

/// The same scene with other tables.
SceneFiles with(SceneFiles files, Tables tables) {
    files.tables = std::move(tables);
    return files;
}

Tables interpolated(Tables tables) {
    tables.force = ForceLaw::kInterpolated;
    tables.compliance = {};
    return tables;
}

std::set<std::array<std::int32_t, 2>> edges_of(const std::vector<std::array<std::int32_t, 3>>& patches) {
    std::set<std::array<std::int32_t, 2>> edges;
    for (const auto& patch : patches)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t a = patch[c], b = patch[(c + 1) % 3];
            edges.insert({std::min(a, b), std::max(a, b)});
        }
    return edges;
}

/// Where each mesh node stands in a list, or -1.
std::vector<std::int32_t> places(const std::vector<std::int32_t>& nodes, std::size_t mesh_nodes) {
    std::vector<std::int32_t> place(mesh_nodes, -1);
    for (std::size_t i = 0; i < nodes.size(); ++i)
        place[static_cast<std::size_t>(nodes[i])] = static_cast<std::int32_t>(i);
    return place;
}

}  // namespace

Tables consistent_by_columns(const Tables& tables, const TablesFolder& folder) {
    const MappedColumns columns(tables, folder);
    const std::vector<std::int32_t> column = places(tables.node_id, tables.position.size());
    const std::vector<std::int32_t> row = places(tables.row_id, tables.position.size());
    Tables made = tables;
    made.force = ForceLaw::kConsistent;
    made.compliance = {};
    made.compliance.degree = 2;
    for (const auto& edge : edges_of(tables.patch)) {
        std::array<double, 9> block{};
        const std::int32_t to = row[static_cast<std::size_t>(edge[0])];
        const std::int32_t from = column[static_cast<std::size_t>(edge[1])];
        if (to >= 0 && from >= 0) {
            const std::size_t at = columns.block(static_cast<std::size_t>(from), static_cast<std::size_t>(to));
            for (std::size_t k = 0; k < 9; ++k) block[k] = static_cast<double>(columns.at(at + k));
        }
        made.compliance.edge_id.push_back(edge);
        made.compliance.edge.push_back(block);
    }
    return made;
}

std::vector<PageMode> page_modes(const SceneFiles& files) {
    const Tables& tables = files.tables;
    std::vector<PageMode> modes{mode_of(files)};
    if (files.tool) {
        add_modes(files, modes);
        return modes;
    }
    add_modes(with(files, interpolated(tables)), modes);
    if (tables.force == ForceLaw::kConsistent)
        add_modes(files, modes);
    else if (tables.has_columns && !tables.half_columns)
        add_modes(with(files, consistent_by_columns(tables, files.folder)), modes);
    if (tables.force == ForceLaw::kPressureMask) add_modes(files, modes);
    return modes;
}

}  // namespace haptable
