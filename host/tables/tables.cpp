// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "host/base/error.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

using nlohmann::json;
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
void read_options(const json& contact, const json& device, Tables& tables) {
    if (contact.contains("friction")) {
        tables.static_friction = contact.at("friction").at("static").get<double>();
        tables.kinetic_friction = contact.at("friction").at("kinetic").get<double>();
    }
    tables.release_n_per_ms = contact.value("release_n_per_ms", 0.0);
    tables.passivity = contact.value("passivity", false);
    tables.fingers = contact.value("fingers", 1);
    if (contact.contains("coupling")) {
        tables.auto_coupling = contact.at("coupling").is_string();
        if (!tables.auto_coupling) tables.coupling_n_per_m = contact.at("coupling").get<double>();
    }
    tables.damping_n_s_per_m = device.value("damping_n_s_per_m", 0.0);
    tables.device_friction_n = device.value("friction_n", 0.0);
    tables.encoder_step_m = device.value("encoder_step_m", 0.0);
    tables.device_delay_s = device.value("delay_s", 0.0);
    tables.motion_scale = device.value("motion_scale", 1.0);
    tables.force_scale = device.value("force_scale", 1.0);
}

/// The choice that the summary names.
template <typename Choice>
Choice choice(const json& section, const char* key, std::optional<Choice> fallback = {}) {
    const auto text = section.value(key, std::string(fallback ? word(*fallback) : ""));
    const std::optional<Choice> chosen = choice_of<Choice>(text);
    if (!chosen)
        throw Error(fmt::format("the tables ask for {} = \"{}\", which this version does not have: make them again",
                                key, text));
    return *chosen;
}

/// What a summary does not name is off.
SafetyLimits read_limits(const json& summary) {
    const json &device = summary.at("device"), &contact = summary.at("contact");
    SafetyLimits limits;
    limits.max_speed_m_s = device.value("max_speed_m_s", 0.0);
    limits.max_force_rate_n_per_s = device.value("max_force_rate_n_per_s", 0.0);
    limits.mean_force_n = device.value("mean_force_n", 0.0);
    limits.mean_force_time_s = device.value("mean_force_time_s", limits.mean_force_time_s);
    limits.ramp_s = device.value("ramp_s", 0.0);
    limits.grab = contact.value("grab", false);
    limits.check = summary.at("tables").value("check", false);
    return limits;
}

void read_summary(const TablesFolder& folder, Tables& tables) {
    try {
        const json& summary = folder.summary();
        tables.name = summary.at("name").get<std::string>();
        tables.model_hash = folder.model_hash();
        tables.tables_hash = folder.tables_hash();
        tables.scene_file = summary.at("scene").get<std::string>();
        tables.force = choice<ForceLaw>(summary.at("contact"), "force");
        tables.god_object = choice<GodObject>(summary.at("contact"), "god_object");
        tables.rigid_stiffness_n_per_m = summary.at("contact").at("rigid_stiffness_n_per_m").get<double>();
        tables.max_force_n = summary.at("device").at("max_force_n").get<double>();
        read_options(summary.at("contact"), summary.at("device"), tables);
        tables.limits = read_limits(summary);
        tables.mask_radius_m = summary.at("contact").value("mask", json::object()).value("radius_m", 0.0);
        for (const json& term : summary.value("relaxation", json::array()))
            tables.relaxation.push_back({term.at("share").get<double>(), term.at("time_s").get<double>()});
        tables.precision = choice<Storage>(summary.at("tables"), "precision", Storage::kFloat32);
        tables.flash_budget = summary.at("tables").value("flash_budget", std::uintmax_t{0});
        tables.display_rows = summary.at("tables").value("display_rows", std::vector<std::int32_t>());
        tables.display_precision = choice<Storage>(summary.at("tables"), "display_precision", Storage::kFloat32);
        const bool none = summary.at("tables").at("columns").get<std::string>() == "none";
        const std::string drawing = summary.value("drawing", none ? "none" : "columns");
        tables.has_columns = drawing == "columns";
        tables.has_factor = drawing == "solves";
        const json columns = summary.value("columns", json::object());
        tables.half_columns = columns.value("format", "") == "float16";
        tables.column_unit_m_per_n = columns.value("unit_m_per_n", 1.0);
    } catch (const json::exception& error) {
        folder.fail("summary.json", fmt::format("is not a summary of haptable-precompute ({})", error.what()));
    }
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
    positive("max_force_n", tables.max_force_n);
    positive("rigid_stiffness_n_per_m", tables.rigid_stiffness_n_per_m);
    not_negative("friction.kinetic", tables.kinetic_friction);
    check("friction.static", tables.static_friction, tables.static_friction >= tables.kinetic_friction);
    for (const RelaxationTerm& term : tables.relaxation) {
        positive("relaxation.share", term.share);
        positive("relaxation.time_s", term.time_s);
    }
    positive("1 - the sum of relaxation.share", rest_share(tables.relaxation));
    not_negative("release_n_per_ms", tables.release_n_per_ms);
    not_negative("max_speed_m_s", tables.limits.max_speed_m_s);
    not_negative("max_force_rate_n_per_s", tables.limits.max_force_rate_n_per_s);
    not_negative("mean_force_n", tables.limits.mean_force_n);
    positive("mean_force_time_s", tables.limits.mean_force_time_s);
    not_negative("ramp_s", tables.limits.ramp_s);
    not_negative("coupling", tables.coupling_n_per_m);
    not_negative("damping_n_s_per_m", tables.damping_n_s_per_m);
    not_negative("friction_n", tables.device_friction_n);
    not_negative("encoder_step_m", tables.encoder_step_m);
    not_negative("delay_s", tables.device_delay_s);
    positive("motion_scale", tables.motion_scale);
    positive("force_scale", tables.force_scale);
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
    read_summary(folder, tables);
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
    check_limits(folder.path() / "summary.json", tables);
    check_definite(folder.file("stiffness.npy"), tables.node_id, tables.stiffness);
    return tables;
}

}  // namespace haptable
