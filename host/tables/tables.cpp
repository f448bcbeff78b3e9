// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/limits.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// The rows of a .npy file of shape [any, k...], k many values a row.
template <typename T, std::size_t k>
std::vector<std::array<T, k>> read_rows(const fs::path& path) {
    const Array<T> array = read_npy<T>(path);
    std::size_t width = 1;
    for (std::size_t d = 1; d < array.shape.size(); ++d) width *= array.shape[d];
    if (array.shape.size() < 2 || width != k)
        throw Error(
            fmt::format("{}: has {} values a row where {} belong: make the tables again", path.string(), width, k));
    std::vector<std::array<T, k>> rows(array.shape[0]);
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t c = 0; c < k; ++c) rows[i][c] = array.values[i * k + c];
    return rows;
}

/// 3x3 blocks, row by row, of a file of shape [..., 3, 3].
std::vector<std::array<double, 9>> read_blocks(const fs::path& path) {
    const Array<double> array = read_npy<double>(path);
    if (array.shape.size() < 3 || array.shape.back() != 3 || array.values.size() % 9 != 0)
        throw Error(path.string() + ": does not hold 3x3 blocks: make the tables again");
    std::vector<std::array<double, 9>> blocks(array.values.size() / 9);
    for (std::size_t i = 0; i < array.values.size(); ++i) blocks[i / 9][i % 9] = array.values[i];
    return blocks;
}

void check_nodes(const fs::path& path, std::span<const std::int32_t> nodes, std::size_t node_count) {
    for (std::int32_t node : nodes)
        if (node < 0 || static_cast<std::size_t>(node) >= node_count)
            throw Error(fmt::format("{}: names node {} of a mesh of {}: make the tables again", path.string(), node,
                                    node_count));
}

void check_patches(const fs::path& path, const std::vector<std::array<std::int32_t, 3>>& patches,
                   std::size_t node_count) {
    for (const auto& patch : patches) check_nodes(path, patch, node_count);
}

/// What a scene need not choose.
void read_contact(const SceneOptions& o, Tables& tables) {
    tables.force = o.choice<ForceLaw>("contact.force");
    tables.god_object = o.choice<GodObject>("contact.god_object");
    tables.rigid_stiffness_n_per_m = o.number("contact.rigid_stiffness");
    tables.mask_radius_m = o.number_or("contact.mask_radius", 0.0);
    tables.static_friction = o.number("contact.friction");
    tables.kinetic_friction = o.number("contact.kinetic_friction");
    tables.fingers = static_cast<int>(o.integer("contact.fingers"));
    if (o.is_text("contact.coupling"))
        tables.auto_coupling = o.text("contact.coupling") == "auto";
    else
        tables.coupling_n_per_m = o.number("contact.coupling");
    if (!o.has("relaxation")) return;
    for (const auto& term : o.at("relaxation"))
        tables.relaxation.push_back({term.at("share").get<double>(), term.at("time").get<double>()});
}

void read_device(const SceneOptions& o, Tables& tables) {
    tables.damping_n_s_per_m = o.number("device.damping");
    tables.device_friction_n = o.number("device.friction");
    tables.encoder_step_m = o.number("device.encoder_step");
    tables.device_delay_s = whole_delay_s(o.number("device.delay"), o.number("device.bandwidth"));
    tables.motion_scale = o.number("device.motion_scale");
    tables.force_scale = o.number("device.force_scale");
    tables.max_force_n = o.number("device.max_force") / tables.force_scale;
    SafetyLimits hand;
    hand.max_speed_m_s = o.number("device.max_speed");
    hand.max_force_rate_n_per_s = o.number("device.max_force_rate");
    hand.mean_force_n = o.number("device.mean_force");
    hand.mean_force_time_s = o.number("device.mean_force_time");
    hand.ramp_s = o.number_or("device.ramp_time", 0.0);
    hand.grab = o.flag("contact.grab");
    hand.check = o.flag("tables.check");
    tables.limits = at_body(hand, tables.motion_scale, tables.force_scale);
}

void read_options(const TablesFolder& folder, const SceneOptions& o, Tables& tables) try {
    tables.options = o;
    tables.name = o.text("name");
    tables.scene_file = o.text("scene");
    read_contact(o, tables);
    read_device(o, tables);
    tables.precision = o.choice<Storage>("tables.precision");
    if (o.has("tables.flash_budget")) tables.flash_budget = o.at("tables.flash_budget").get<std::uintmax_t>();
    if (o.has("tables.display_rows")) o.at("tables.display_rows").get_to(tables.display_rows);
    tables.display_precision = o.choice<Storage>("tables.display_precision");
} catch (const nlohmann::json::exception& error) {
    folder.fail("options.json", fmt::format("is not of haptable-precompute ({})", error.what()));
} catch (const Error& error) {
    folder.fail("options.json", error.what());
}

/// Force and stiffness grow with the dent.
void check_curve(const TablesFolder& folder, const StiffeningCurve& curve) {
    if (!curve.grows()) folder.fail("tables.json", "has a stiffening whose force does not grow with the dent");
}

/// How the run stored what it computed.
void read_facts(const TablesFolder& folder, Tables& tables) try {
    const nlohmann::json& facts = folder.facts();
    tables.model_hash = folder.model_hash();
    tables.tables_hash = folder.tables_hash();
    const std::string drawing = facts.at("drawing").get<std::string>();
    tables.has_columns = drawing == "columns";
    tables.has_factor = drawing == "solves";
    if (const auto fit = facts.find("stiffening"); fit != facts.end()) {
        fit->at("curve").get_to(tables.stiffening.c);
        fit->at("energy_j").get_to(tables.stiffening.energy_j);
        check_curve(folder, tables.stiffening);
    }
    const nlohmann::json columns = facts.value("columns", nlohmann::json::object());
    tables.half_columns = columns.value("format", "") == "float16";
    tables.column_unit_m_per_n = columns.value("unit_m_per_n", 1.0);
} catch (const nlohmann::json::exception& error) {
    folder.fail("tables.json", fmt::format("is not of haptable-precompute ({})", error.what()));
}

void require_count(const fs::path& path, std::size_t count, std::size_t wanted) {
    if (count != wanted)
        throw Error(
            fmt::format("{}: has {} entries where {} belong: make the tables again", path.string(), count, wanted));
}

void read_mask(const TablesFolder& folder, const Tables& tables, ComplianceTables& c) {
    c.vertex_id = read_npy<std::int32_t>(folder.file("vertex_id.npy")).values;
    c.vertex = read_blocks(folder.file("vertex_compliance.npy"));
    c.patch = read_blocks(folder.file("patch_compliance.npy"));
    c.spread_begin = read_npy<std::int32_t>(folder.file("spread_begin.npy")).values;
    c.spread_node = read_npy<std::int32_t>(folder.file("spread_node.npy")).values;
    c.spread_weight = read_npy<float>(folder.file("spread_weight.npy")).values;
    check_nodes(folder.file("vertex_id.npy"), c.vertex_id, tables.position.size());
    check_nodes(folder.file("spread_node.npy"), c.spread_node, tables.position.size());
    require_count(folder.file("vertex_compliance.npy"), c.vertex.size(), c.vertex_id.size());
    require_count(folder.file("patch_compliance.npy"), c.patch.size(), 3 * tables.patch.size());
    require_count(folder.file("spread_begin.npy"), c.spread_begin.size(), c.vertex_id.size() + c.edge_id.size() + 1);
    require_count(folder.file("spread_weight.npy"), c.spread_weight.size(), c.spread_node.size());
    std::int32_t before = 0;
    for (std::int32_t begin : c.spread_begin)
        if (begin < std::exchange(before, begin) || static_cast<std::size_t>(begin) > c.spread_node.size())
            throw Error(folder.file("spread_begin.npy").string() + ": does not ascend: make the tables again");
}

void read_compliance(const TablesFolder& folder, Tables& tables) {
    ComplianceTables& c = tables.compliance;
    c.degree = degree_of(tables.force);
    if (c.degree == 0) return;
    c.edge_id = read_rows<std::int32_t, 2>(folder.file("edge_id.npy"));
    c.edge = read_blocks(folder.file("edge_compliance.npy"));
    for (const auto& edge : c.edge_id) check_nodes(folder.file("edge_id.npy"), edge, tables.position.size());
    require_count(folder.file("edge_compliance.npy"), c.edge.size(),
                  c.edge_id.size() * static_cast<std::size_t>(c.degree - 1));
    if (c.degree == 4) read_mask(folder, tables, c);
}

// ---- what a servo must not be given
// -----------------------------------------------------------------------------------

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
    throw Error(path.string() + ": " + what + ": make the tables again");
}

/// The servo's forces are limited by these and follow their signs.
void check_limits(const fs::path& path, const Tables& tables) {
    const auto check = [&path](const char* key, double value, bool is_fine) {
        if (!is_fine || !std::isfinite(value)) fail(path, fmt::format("{} = {} is no limit", key, value));
    };
    const auto positive = [&check](const char* key, double value) { check(key, value, value > 0.0); };
    const auto not_negative = [&check](const char* key, double value) { check(key, value, value >= 0.0); };
    positive("device.max_force", tables.max_force_n);
    positive("contact.rigid_stiffness", tables.rigid_stiffness_n_per_m);
    not_negative("contact.kinetic_friction", tables.kinetic_friction);
    check("contact.friction", tables.static_friction, tables.static_friction >= tables.kinetic_friction);
    for (const RelaxationTerm& term : tables.relaxation) {
        positive("relaxation.share", term.share);
        positive("relaxation.time", term.time_s);
    }
    positive("1 - the sum of relaxation.share", rest_share(tables.relaxation));
    not_negative("contact.release_slew", tables.options.number("contact.release_slew"));
    not_negative("device.max_speed", tables.limits.max_speed_m_s);
    not_negative("device.max_force_rate", tables.limits.max_force_rate_n_per_s);
    not_negative("device.mean_force", tables.limits.mean_force_n);
    positive("device.mean_force_time", tables.limits.mean_force_time_s);
    not_negative("device.ramp_time", tables.limits.ramp_s);
    not_negative("contact.coupling", tables.coupling_n_per_m);
    not_negative("device.damping", tables.damping_n_s_per_m);
    not_negative("device.friction", tables.device_friction_n);
    not_negative("device.encoder_step", tables.encoder_step_m);
    not_negative("device.delay", tables.device_delay_s);
    positive("device.motion_scale", tables.motion_scale);
    positive("device.force_scale", tables.force_scale);
}

/// A finger that presses is pushed back: every block of a free node.
void check_definite(const fs::path& path, const std::vector<std::int32_t>& node,
                    const std::vector<std::array<double, 9>>& blocks) {
    for (std::size_t i = 0; i < blocks.size(); ++i)
        if (!is_definite(blocks[i]))
            fail(path, fmt::format("the block of node {} is not positive definite: it would pull", node[i]));
}

}  // namespace

bool is_definite(const std::array<double, 9>& block) {
    const auto at = [&block](std::size_t a, std::size_t b) { return 0.5 * (block[3 * a + b] + block[3 * b + a]); };
    const double d0 = at(0, 0), d1 = at(1, 1) - at(0, 1) * at(0, 1) / d0;
    const double l = at(1, 2) - at(0, 1) * at(0, 2) / d0;
    const double d2 = at(2, 2) - at(0, 2) * at(0, 2) / d0 - l * l / d1;
    return d0 > 0.0 && d1 > 0.0 && d2 > 0.0;  // false for what is not a number
}

Tables read_tables(const TablesFolder& folder) {
    Tables tables;
    read_options(folder, folder.options(), tables);
    read_facts(folder, tables);
    tables.position = read_rows<double, 3>(folder.file("position.npy"));
    tables.surface = read_rows<std::int32_t, 3>(folder.file("surface.npy"));
    tables.patch = read_rows<std::int32_t, 3>(folder.file("patch.npy"));
    tables.node_id = read_npy<std::int32_t>(folder.file("node_id.npy")).values;
    tables.stiffness = read_rows<double, 9>(folder.file("stiffness.npy"));

    const std::size_t nodes = tables.position.size();
    check_patches(folder.file("surface.npy"), tables.surface, nodes);
    check_patches(folder.file("patch.npy"), tables.patch, nodes);
    check_nodes(folder.file("node_id.npy"), tables.node_id, nodes);
    if (tables.has_columns || tables.has_factor) {
        tables.row_id = read_npy<std::int32_t>(folder.file("row_id.npy")).values;
        check_nodes(folder.file("row_id.npy"), tables.row_id, nodes);
    }
    require_count(folder.file("stiffness.npy"), tables.stiffness.size(), tables.node_id.size());
    read_compliance(folder, tables);
    check_limits(folder.path() / "options.json", tables);
    check_definite(folder.file("stiffness.npy"), tables.node_id, tables.stiffness);
    return tables;
}

}  // namespace haptable
