// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/facts.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"
#include "host/precompute/identity.hpp"

namespace haptable {

namespace {

using nlohmann::ordered_json;

ordered_json counts(const Body& body) {
    return {{"nodes", body.mesh.position_m.size()},
            {"surface_nodes", body.surface.node.size()},
            {"free_surface_nodes", body.free_surface_node.size()},
            {"surface_patches", body.surface.patch.size()},
            {"tetrahedra", body.mesh.tet.size()},
            {"fixed_nodes", body.fixed_count()},
            {"touchable_nodes", body.touch_node.size()},
            {"touchable_patches", body.touch_patch.size()}};
}

ordered_json to_json(const Checks& checks) {
    ordered_json json{{"solved_nodes", checks.solved_nodes}};
    for (const Check& check : kChecks) json[check.key] = checks.*check.value;
    return json;
}

Checks read_checks(const nlohmann::json& json) {
    Checks checks;
    json.at("solved_nodes").get_to(checks.solved_nodes);
    for (const Check& check : kChecks) json.at(check.key).get_to(checks.*check.value);
    return checks;
}

/// Null where it is not known.
ordered_json to_json(const std::optional<SmallStrain>& s, const ContactOptions& contact) {
    if (!s) return nullptr;
    return {{"depth_m", s->depth_m(contact.static_friction > 0.0)},
            {"share", SmallStrain::kShare},
            {"finger_radius_m", s->finger_radius_m},
            {"places", s->places},
            {"pressing_m", s->pressing_m},
            {"pulling_m", s->pulling_m},
            {"sideways_m", s->sideways_m}};
}

std::optional<SmallStrain> read_small_strain(const nlohmann::json& json) {
    if (json.is_null()) return {};
    return SmallStrain{json.at("finger_radius_m"), json.at("places"), json.at("pressing_m"), json.at("pulling_m"),
                       json.at("sideways_m")};
}

ordered_json to_json(const DentErrors& errors) {
    return {{"dents", errors.dents},
            {"depth_m", errors.depth_m},
            {"rms", errors.rms},
            {"worst", errors.worst},
            {"linear_rms", errors.linear_rms}};
}

ordered_json to_json(const Stiffening& material, const StiffeningFit& fit) {
    ordered_json json{{"curve", fit.curve.c}, {"energy_j", fit.curve.energy_j}};
    if (const auto& pressed = fit.pressed)
        json["press"] = {{"node", pressed->node},
                         {"depth_m", material.press->depth_m},
                         {"misfit_n", material.press->misfit_n},
                         {"stiffness_n_per_m", material.press->stiffness_n_per_m},
                         {"scene_stiffness_n_per_m", pressed->stiffness_n_per_m}};
    if (material.curve.energy_j > 0.0) return json;
    if (material.fung > 0.0)
        json["fung"] = material.fung;
    else
        json["yeoh"] = {material.y2, material.y3};
    json["fitted"] = to_json(fit.fitted);
    for (std::size_t way = 0; way < kDentWays.size(); ++way) {
        ordered_json& of_way = json["by_way"][std::string(kDentWays[way])] = to_json(fit.by_way[way]);
        of_way["is_fitted"] = static_cast<bool>(fit.is_fitted[way]);
    }
    for (std::size_t place = 0; place < fit.by_place.size(); ++place) {
        ordered_json of_place{{"node", fit.node[place]}, {"pressed_n_per_m", fit.pressed_n_per_m[place]}};
        of_place.update(to_json(fit.by_place[place]));
        of_place["good_m"] = fit.good_m[place];
        json["by_place"].push_back(std::move(of_place));
    }
    return json;
}

Locking read_locking(const nlohmann::json& json) {
    return {json.at("expected_locking"), json.at("finger_radius_m"), json.at("places")};
}

ordered_json to_json(const GravityFacts& facts) {
    return {{"weight_n", facts.weight_n},
            {"largest_sag_m", facts.largest_sag_m},
            {"lowest_node", facts.lowest_node},
            {"force_change", facts.force_change},
            {"load_factor", facts.load_factor}};
}

std::optional<GravityFacts> read_gravity(const nlohmann::json& json) {
    if (!json.contains("gravity")) return {};
    const nlohmann::json& g = json["gravity"];
    return GravityFacts{g.at("weight_n"), g.at("largest_sag_m"), g.at("lowest_node"), g.at("force_change"),
                        g.at("load_factor")};
}

Precision precision_of(const nlohmann::json& json) {
    return json.at("precision") == "float" ? Precision::kFloat : Precision::kDouble;
}

/// What fixes each body: [{nodes, tetrahedra, held_nodes, held}].
ordered_json to_json(const std::vector<Support>& supports) {
    ordered_json list = ordered_json::array();
    for (const Support& support : supports)
        list.push_back({{"nodes", support.nodes},
                        {"tetrahedra", support.tets},
                        {"held_nodes", support.fixed_nodes},
                        {"bed_faces", support.bed_faces},
                        {"held", support.is_constrained}});
    return list;
}

}  // namespace

ordered_json to_json(const Material& material) {
    if (!material.orthotropic) return {{"young_pa", material.young_pa}, {"poisson", material.poisson}};
    const auto& [young_pa, poisson, shear_pa, axes] = *material.orthotropic;
    return {{"young_pa", young_pa},
            {"poisson", poisson},
            {"shear_pa", shear_pa},
            {"like", {{"young_pa", material.young_pa}, {"poisson", material.poisson}}}};
}

std::string name_of(Precision precision) { return precision == Precision::kFloat ? "float" : "double"; }

std::string to_json(const Audit& audit, const std::vector<Support>& supports,
                    const std::optional<GravityFacts>& gravity) {
    ordered_json json = to_json(audit);
    if (gravity) json["gravity"] = to_json(*gravity);
    if (!supports.empty()) json["body"] = to_json(supports);
    return json_text(json, 2) + "\n";
}

ordered_json facts_of(const Scene& scene, const Body& body, const Summary& summary) {
    const auto& [factor, blocks, columns, checks, small_strain, locking, gravity] = summary.inverse;
    ordered_json json = to_json(scene, summary.identity);
    json["tables_hash"] = fmt::format("{:016x}", summary.size.tables_hash);
    json["body_hash"] = fmt::format("{:016x}", summary.identity.body_hash);
    json["threads"] = factor.threads;
    json["counts"] = counts(body);
    json["mesh"] = to_json(summary.audit);
    json["mesh"]["body"] = to_json(summary.supports);
    json["element"] = {{"name", word(scene.mesh.element)},
                       {"expected_locking", locking.excess},
                       {"finger_radius_m", locking.finger_radius_m},
                       {"places", locking.places}};
    json["material"] = to_json(scene.material);
    if (gravity) json["gravity"] = to_json(*gravity);
    json["checks"] = to_json(checks);
    json["small_strain"] = to_json(small_strain, scene.contact);
    if (summary.stiffening) json["stiffening"] = to_json(*scene.material.stiffening, *summary.stiffening);
    json["factor"] = {{"ordering", factor.ordering}, {"fill", factor.fill}, {"flops", factor.flops}};
    json["blocks"] = {{"method", blocks.method}, {"precision", name_of(blocks.precision)}, {"flops", blocks.flops}};
    json["columns"] = {{"precision", columns.format.empty() ? "" : name_of(columns.facts.precision)},
                       {"float_error", columns.float_error},
                       {"format", columns.format},
                       {"unit_m_per_n", columns.unit_m_per_n},
                       {"flops", columns.facts.flops},
                       {"flops_done", columns.facts.flops_done}};
    json["warnings"] = run_warnings(scene, summary);
    return json;
}

std::string tables_text(ordered_json facts, const Summary& summary, const std::string& summary_hash) {
    if (summary.size.tables_hash == 0) facts.erase("tables_hash");
    if (summary.pair)
        facts["pair"] = {{"meeting_m", summary.pair->meeting_m},
                         {"controls", summary.pair->controls},
                         {"clustered", summary.pair->clustered},
                         {"loads", summary.pair->loads},
                         {"rank", summary.pair->rank}};
    facts["hash"] = ordered_json::object();
    for (const WrittenFile& file : summary.files) facts["hash"][file.name] = file.hash;
    facts["summary"] = summary_hash;
    facts["facts_hash"] = hash_facts(facts);
    return json_text(facts, 1) + "\n";
}

bool is_current(const std::filesystem::path& folder, const Scene& scene, const Identity& identity, bool needs_code) {
    const auto whole = TablesFolder::if_whole(folder);
    if (!whole || (needs_code && !whole->has("model.c"))) return false;
    nlohmann::json wanted = to_json(scene, identity);
    std::error_code none;
    wanted["summary"] =
        std::filesystem::is_regular_file(folder / "summary.json", none) ? hash_file(folder / "summary.json") : "";
    for (const auto& [key, value] : wanted.items())
        if (!whole->facts().contains(key) || whole->facts()[key] != value) return false;
    return whole->has("options.json") && read_file(whole->file("options.json")) == options_text(scene);
}

std::optional<EarlierFacts> read_earlier(const std::filesystem::path& folder, const Identity& identity) try {
    const auto whole = TablesFolder::if_whole(folder);
    if (!whole) return {};
    const nlohmann::json& json = whole->facts();
    if (json.value("body_hash", "") != fmt::format("{:016x}", identity.body_hash) ||
        json.value("program", "") != program_hash())
        return {};
    EarlierFacts earlier{*whole, 0.0, 0.0, {}};
    auto& [factor, blocks, columns, checks, small_strain, locking, gravity] = earlier.inverse;
    gravity = read_gravity(json);
    json.at("tolerance").get_to(earlier.tolerance);
    json.at("column_tolerance").get_to(earlier.column_tolerance);
    json.at("threads").get_to(factor.threads);
    json.at("factor").at("ordering").get_to(factor.ordering);
    json.at("factor").at("fill").get_to(factor.fill);
    json.at("factor").at("flops").get_to(factor.flops);
    json.at("blocks").at("method").get_to(blocks.method);
    blocks.precision = precision_of(json.at("blocks"));
    json.at("blocks").at("flops").get_to(blocks.flops);
    columns.facts.precision = precision_of(json.at("columns"));
    json.at("columns").at("float_error").get_to(columns.float_error);
    json.at("columns").at("format").get_to(columns.format);
    json.at("columns").at("unit_m_per_n").get_to(columns.unit_m_per_n);
    json.at("columns").at("flops").get_to(columns.facts.flops);
    checks = read_checks(json.at("checks"));
    small_strain = read_small_strain(json.at("small_strain"));
    locking = read_locking(json.at("element"));
    return earlier;
} catch (const nlohmann::json::exception&) {
    return {};
}

std::vector<std::string> kept_warnings(const std::filesystem::path& folder) {
    return TablesFolder(folder).facts().value("warnings", std::vector<std::string>());
}

}  // namespace haptable
