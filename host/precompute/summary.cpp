// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/json.hpp"
#include "host/base/text.hpp"
#include "host/body/locking.hpp"
#include "host/inverse/solve/blas_core.hpp"
#include "host/precompute/digits.hpp"
#include "host/precompute/facts.hpp"

namespace haptable {

namespace {

/// {name: member} of every item.
template <typename Item, typename Member>
nlohmann::ordered_json by_name(const std::vector<Item>& items, Member member) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const Item& item : items) object[item.name] = item.*member;
    return object;
}

template <typename Member>
nlohmann::ordered_json list_of(const std::vector<ProcessCost>& processes, Member member) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ProcessCost& process : processes) list.push_back(process.*member);
    return list;
}

/// Faces with membranes and with beds, and their area.
nlohmann::ordered_json layers(const Body& body) {
    nlohmann::ordered_json json;
    for (const auto& [name, is] : {std::pair{"membranes", &Layer::has_membrane}, {"beds", &Layer::has_bed}}) {
        std::size_t faces = 0;
        double area_m2 = 0.0;
        for (const LayeredFace& face : body.layered) {
            if (!(face.layer.*is)()) continue;
            ++faces;
            area_m2 += area_of(body.mesh.position_m, face);
        }
        if (faces > 0) json[name] = {{"faces", faces}, {"area_m2", area_m2}};
    }
    return json;
}

std::string describe(const Material& material) {
    if (!material.orthotropic) return fmt::format("{:g} Pa, Poisson's ratio {:g}", material.young_pa, material.poisson);
    const auto& [e, nu, g, axes] = *material.orthotropic;
    return fmt::format("orthotropic, E {:g} Pa, nu {:g}, G {:g} Pa", fmt::join(e, " "), fmt::join(nu, " "),
                       fmt::join(g, " "));
}

nlohmann::ordered_json regions(const Scene& scene, const Body& body) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (std::size_t r = 0; r < scene.regions.size(); ++r) {
        nlohmann::ordered_json region = to_json(scene.regions[r].material);
        if (!scene.regions[r].where.group.empty()) region["group"] = scene.regions[r].where.group;
        region["tetrahedra"] = std::count(body.region.begin(), body.region.end(), static_cast<std::int32_t>(r));
        list.push_back(region);
    }
    return list;
}

nlohmann::ordered_json flash(const ModelSize& size) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    std::size_t sum = 0;
    for (const TableBytes& table : size.flash) {
        json["table"][table.name] = table.bytes;
        sum += table.bytes;
    }
    json["bytes"] = sum;
    for (const PrecisionError& p : size.precision)
        json["precision"][word(p.precision)] = {
            {"bytes", p.bytes}, {"worst_force_error", p.worst}, {"mean_force_error", p.mean}};
    return json;
}

nlohmann::ordered_json memory(const MemoryNeed& need, const std::vector<StageCost>& stages) {
    return {{"foreseen_bytes", need.peak()},
            {"stiffness_bytes", need.stiffness},
            {"factor_bytes", need.factor},
            {"inversion_bytes", need.fronts},
            {"mask_bytes", need.pairs},
            {"columns_bytes", need.columns},
            {"checks_bytes", need.solves},
            {"peak_bytes", stages.empty() ? 0.0 : stages.back().peak_bytes},
            {"peak_bytes_by_stage", by_name(stages, &StageCost::peak_bytes)}};
}

std::string flash_table(const Scene& scene, const ModelSize& size) {
    std::string text = "\n  flash of the servo       bytes    stored as      bytes   force error: worst    mean\n";
    std::size_t sum = 0;
    for (std::size_t i = 0; i < std::max(size.flash.size(), size.precision.size()); ++i) {
        text += i < size.flash.size() ? fmt::format("  {:<22} {:>8}", size.flash[i].name, size.flash[i].bytes)
                                      : std::string(33, ' ');
        if (i < size.flash.size()) sum += size.flash[i].bytes;
        if (i < size.precision.size()) {
            const PrecisionError& p = size.precision[i];
            text += fmt::format("    {:<10} {:>9}          {}{}", word(p.precision), p.bytes,
                                std::isfinite(p.worst + p.mean) ? fmt::format("{:>9.2g} {:>9.2g}", p.worst, p.mean)
                                                                : fmt::format("{:>19}", "does not fit"),
                                p.precision == scene.tables.precision ? "  (chosen)" : "");
        }
        text += '\n';
    }
    return text + fmt::format("  {:<22} {:>8}\n", "all", sum);
}

/// What was chosen beyond the paper's contact.
void add_options(const ContactOptions& c, nlohmann::ordered_json& json) {
    if (c.static_friction > 0.0) json["friction"] = {{"static", c.static_friction}, {"kinetic", c.kinetic_friction}};
    if (c.release_n_per_ms > 0.0) json["release_n_per_ms"] = c.release_n_per_ms;
    if (c.passivity) json["passivity"] = true;
    if (c.grab) json["grab"] = true;
    if (c.auto_coupling) json["coupling"] = "auto";
    if (c.coupling_n_per_m > 0.0) json["coupling"] = c.coupling_n_per_m;
}

nlohmann::ordered_json to_json(const PairSummary& pair) {
    return {{"meeting_m", pair.meeting_m},
            {"controls", pair.controls},
            {"clustered", pair.clustered},
            {"loads", pair.loads},
            {"cores", pair.cores},
            {"dense", pair.dense},
            {"rank", pair.rank},
            {"bytes", pair.bytes},
            {"places", pair.error.places},
            {"worst_error", pair.error.worst},
            {"p99_error", pair.error.p99},
            {"least_eigenvalue", pair.error.least},
            {"meeting_places", pair.error.meeting}};
}

std::string describe(const PairSummary& pair) {
    const std::string how = pair.clustered == 0
                                ? fmt::format("all pairs of {} places", pair.controls)
                                : fmt::format(
                                      "{} places in clusters, {} of {} pairs of them in full, the others of rank "
                                      "{} at most",
                                      pair.clustered, pair.dense, pair.cores, pair.rank);
    return fmt::format(
        "  coupled contacts: {}, {}; over {} pairs of places the forces are off by at most {:.2g} of themselves (99 %: "
        "{:.2g})\n",
        how, human_bytes(pair.bytes), pair.error.places, pair.error.worst, pair.error.p99);
}

/// How the body of a record's press answers there.
std::string describe(const RecordedPress& press, const PressedPlace& place) {
    return fmt::format("  stiffening: of a press to {:.2g} m at node {}, which the curve misses by {:.2g} N (rms)\n",
                       press.depth_m, place.node, press.misfit_n);
}

std::string describe(const StiffeningFit& fit) {
    const DentErrors& all = fit.fitted;
    if (all.dents == 0)
        return fmt::format(
            "  stiffening: the scene's curve, {:.2g} times the linear force where that stores {:.2g} J\n",
            fit.curve.factor(fit.curve.energy_j), fit.curve.energy_j);
    std::string text = fmt::format(
        "  stiffening: the force of {} dents, {:.2g} m deep, is off by {:.1f} % (rms; linear: {:.1f} %), at most "
        "{:.0f} "
        "%\n",
        all.dents, all.depth_m, 100.0 * all.rms, 100.0 * all.linear_rms, 100.0 * all.worst);
    for (std::size_t way = 0; way < kDentWays.size(); ++way)
        text += fmt::format("    {:<9} {:.1f} % (linear: {:.1f} %) to {:.2g} m{}\n", kDentWays[way],
                            100.0 * fit.by_way[way].rms, 100.0 * fit.by_way[way].linear_rms, fit.by_way[way].depth_m,
                            fit.is_fitted[way] ? "" : ", which this finger does not go");
    for (std::size_t place = 0; place < fit.by_place.size(); ++place)
        text += fmt::format("    at node {:<6} {:.1f} % (linear: {:.1f} %), within {:.0f} % to {:.2g} m\n",
                            fit.node[place], 100.0 * fit.by_place[place].rms, 100.0 * fit.by_place[place].linear_rms,
                            100.0 * SmallStrain::kShare, fit.good_m[place]);
    return text + fmt::format(
                      "    within {:.0f} % to {:.2g} m deep; pulling {:.2g}, sideways {:.2g} m (median of {} places)\n",
                      100.0 * SmallStrain::kShare, fit.good.pressing_m, fit.good.pulling_m, fit.good.sideways_m,
                      fit.good.places);
}

/// Adds the limits of [device]; what is off is left out.
void add_limits(const SafetyLimits& limits, nlohmann::ordered_json& json) {
    if (limits.max_speed_m_s > 0.0) json["max_speed_m_s"] = limits.max_speed_m_s;
    if (limits.max_force_rate_n_per_s > 0.0) json["max_force_rate_n_per_s"] = limits.max_force_rate_n_per_s;
    if (limits.mean_force_n > 0.0) json["mean_force_n"] = limits.mean_force_n;
    if (limits.mean_force_n > 0.0) json["mean_force_time_s"] = limits.mean_force_time_s;
    if (limits.ramp_s > 0.0) json["ramp_s"] = limits.ramp_s;
}

bool is_same(double a, double b) { return std::abs(a - b) < 1e-6 * std::abs(b); }

/// The stiffness of held nodes is the scene's choice, not the body's: it is named apart.
std::string stiffness_line(const Scene& scene, const ServoStiffness& k, const PressStiffness& press) {
    const double held_n_per_m = scene.contact.rigid_stiffness_n_per_m;
    const bool by_held = k.largest_n_per_m > press.largest_n_per_m && is_same(k.largest_n_per_m, held_n_per_m);
    std::string more;
    if (k.coupling_n_per_m > 0.0)
        more = fmt::format("; with a coupling of {:.3g} N/m in series {:.3g} N/m are felt", k.coupling_n_per_m,
                           k.felt_n_per_m);
    else if (by_held && k.stable_n_per_m < held_n_per_m && k.stable_n_per_m > press.largest_n_per_m)
        more = fmt::format(": for held nodes take rigid_stiffness = {:.2g} or coupling = \"auto\" in [contact]",
                           0.9 * k.stable_n_per_m);
    else if (k.felt_n_per_m > k.largest_n_per_m)
        more = fmt::format("; a dent stiffens to {:.3g} N/m at max_force{}", k.felt_n_per_m,
                           k.felt_n_per_m > k.stable_n_per_m ? ": consider a smaller one" : "");
    else if (k.largest_n_per_m > k.stable_n_per_m)
        more = ": consider coupling = \"auto\" in [contact]";
    const double free_n_per_m = by_held ? press.largest_n_per_m : k.largest_n_per_m;
    return fmt::format("  largest stiffness of a free point {:.3g} N/m{}; the device renders {:.3g} N/m stably{}\n",
                       free_n_per_m, by_held ? fmt::format(", of held nodes {:g} (rigid_stiffness)", held_n_per_m) : "",
                       k.stable_n_per_m, more);
}

/// Young's modulus that makes a small dent of the body the record's.
std::vector<std::string> press_warnings(const Scene& scene, const std::optional<StiffeningFit>& fit) {
    constexpr double kShare = 0.1;
    if (!fit || !fit->pressed) return {};
    const RecordedPress& press = *scene.material.stiffening->press;
    const double factor = press.stiffness_n_per_m / fit->pressed->stiffness_n_per_m;
    if (std::abs(factor - 1.0) < kShare) return {};
    return {
        fmt::format("a small dent of the record has {:.3g} N/m, and the body {:.3g} N/m there: young = {:.4g} in "
                    "[material] makes them alike",
                    press.stiffness_n_per_m, fit->pressed->stiffness_n_per_m, factor * scene.material.young_pa)};
}

/// A coupling whose error is felt.
std::vector<std::string> pair_warnings(const std::optional<PairSummary>& pair) {
    constexpr double kFelt = 0.1;  // of the forces
    if (!pair || pair->error.worst <= kFelt) return {};
    return {
        fmt::format("of two contacts the forces are off by up to {:.2g} % of themselves (99 %: {:.2g} %): give "
                    "more tables.coupling_bytes, or touch a smaller region",
                    100.0 * pair->error.worst, 100.0 * pair->error.p99)};
}

}  // namespace

PairSummary::PairSummary(const PairTables& tables, const PairError& measured)
    : meeting_m(tables.meeting_m),
      controls(tables.control_count),
      clustered(tables.clusters.places()),
      loads(tables.clusters.load_place.size()),
      dense(static_cast<std::size_t>(std::count_if(tables.clusters.form.begin(), tables.clusters.form.end(),
                                                   [](auto f) { return f >= kDenseForm; }))),
      cores(tables.clusters.form.size()),
      rank(tables.clusters.rank),
      bytes(pair_bytes(tables)),
      error(measured) {}

std::vector<std::string> run_warnings(const Scene& scene, const Summary& summary) {
    std::vector<std::string> warnings = locking_warnings(scene, summary.inverse.locking);
    for (const std::string& warning : digit_warnings(scene, summary)) warnings.push_back(warning);
    for (const std::string& warning : press_warnings(scene, summary.stiffening)) warnings.push_back(warning);
    for (const std::string& warning : gravity_warnings(scene, summary.inverse.gravity, summary.audit.box_m))
        warnings.push_back(warning);
    for (const std::string& warning : pair_warnings(summary.pair)) warnings.push_back(warning);
    return warnings;
}

std::string summary_text(nlohmann::ordered_json json, const Scene& scene, const Body& body, const Summary& summary) {
    json["reused"] = summary.reused.all;
    json["reused_blocks"] = summary.reused.blocks;
    json["reused_columns"] = summary.reused.columns;
    json["resumed_columns"] = summary.inverse.columns.facts.resumed;
    json["blas_kernels"] = blas_kernels();
    if (!body.layered.empty()) json["layers"] = layers(body);
    if (!scene.regions.empty()) json["regions"] = regions(scene, body);
    json["contact"] = {{"force", word(scene.contact.force)},
                       {"god_object", word(scene.contact.god_object)},
                       {"rigid_stiffness_n_per_m", scene.contact.rigid_stiffness_n_per_m}};
    for (const RelaxationTerm& term : scene.relaxation)
        json["relaxation"].push_back({{"share", term.share}, {"time_s", term.time_s}});
    add_options(scene.contact, json["contact"]);
    if (scene.contact.mask_radius_m > 0.0)
        json["contact"]["mask"] = {{"radius_m", scene.contact.mask_radius_m},
                                   {"most_nodes", summary.mask.most_nodes},
                                   {"pairs", summary.mask.pairs},
                                   {"method", summary.mask.blocks.method},
                                   {"flops", summary.mask.blocks.flops},
                                   {"product_flops", summary.mask.product_flops},
                                   {"widened", summary.mask.widened},
                                   {"places", summary.mask.places}};
    if (summary.pair) {
        json["contact"]["fingers"] = 2;
        json["contact"]["pair"] = to_json(*summary.pair);
    }
    if (summary.body_modes)
        json["modes"] = {{"frequency_hz", summary.body_modes->frequency_hz},
                         {"damping_ratio", summary.body_modes->damping_ratio},
                         {"compliance_share", summary.body_modes->share}};
    const std::array<double, 3>& mass_kg = scene.device.mass_kg;
    json["device"] = {{"max_force_n", servo_force_limit_n(scene)},
                      {"mass_kg", (mass_kg[0] + mass_kg[1] + mass_kg[2]) / 3.0},
                      {"damping_n_s_per_m", scene.device.damping_n_s_per_m},
                      {"friction_n", scene.device.friction_n},
                      {"encoder_step_m", scene.device.encoder_step_m},
                      {"delay_s", whole_delay_s(scene.device)},
                      {"motion_scale", scene.device_map.motion_scale},
                      {"force_scale", scene.device_map.force_scale}};
    add_limits(servo_limits(scene), json["device"]);
    if (summary.size.stiffness.largest_n_per_m > 0.0)
        json["stiffness"] = {{"largest_n_per_m", summary.size.stiffness.largest_n_per_m},
                             {"stable_n_per_m", summary.size.stiffness.stable_n_per_m},
                             {"coupling_n_per_m", summary.size.stiffness.coupling_n_per_m},
                             {"felt_n_per_m", summary.size.stiffness.felt_n_per_m}};
    json["tables"] = {{"check", scene.device.limits.check},
                      {"precision", word(scene.tables.precision)},
                      {"columns", word(scene.tables.columns)},
                      {"flash_budget", scene.tables.flash_budget}};
    if (!scene.tables.display_rows.empty()) {
        json["tables"]["display_rows"] = scene.tables.display_rows;
        json["tables"]["display_precision"] = word(scene.tables.display_precision);
    }
    json["flash"] = flash(summary.size);
    json["index"] = {{"boxes", summary.size.index.boxes},
                     {"fast_way_boxes", summary.size.index.fast_way_boxes},
                     {"tick_boxes", summary.size.index.tick_boxes}};
    const Digits digits = digits_of(summary);
    json["force_error"] = {{"inverse", digits.inverse},
                           {"depth_m", digits.servo.depth_m},
                           {"servo", digits.servo.worst},
                           {"servo_without_positions", digits.servo.force_alone}};
    for (const Remedy& remedy : summary.size.remedies)
        json["force_error"]["remedies"].push_back({{"scene", remedy.text}, {"servo", remedy.error}});
    json["memory"] = memory(summary.memory, summary.stages);
    if (!summary.processes.empty())
        json["ranks"] = {{"count", summary.processes.size()},
                         {"cpu_s", list_of(summary.processes, &ProcessCost::cpu_s)},
                         {"peak_bytes", list_of(summary.processes, &ProcessCost::peak_bytes)}};
    json["bytes"] = by_name(summary.files, &WrittenFile::bytes);
    json["hash"] = by_name(summary.files, &WrittenFile::hash);
    json["time_s"] = by_name(summary.stages, &StageCost::time_s);
    json["cpu_s"] = by_name(summary.stages, &StageCost::cpu_s);
    json["notes"] = body.mesh.notes;
    return json_text(json, 2) + "\n";
}

std::string to_table(const Scene& scene, const Body& body, const Summary& summary, const PressStiffness& press) {
    std::string text = fmt::format("{} (model {:016x}, tables {:016x})\n", scene.name, summary.identity.model_hash,
                                   summary.size.tables_hash) +
                       to_table(summary.audit);
    text +=
        fmt::format("  fixed {} nodes; free on the surface {}; touchable: {} free nodes, {} patches\n",
                    body.fixed_count(), body.free_surface_node.size(), body.touch_node.size(), body.touch_patch.size());
    if (scene.material.orthotropic) text += "  material: " + describe(scene.material) + "\n";
    for (std::size_t r = 0; r < scene.regions.size(); ++r)
        text += fmt::format("  region of line {}: {} tetrahedra, {}\n", scene.regions[r].where.line,
                            std::count(body.region.begin(), body.region.end(), static_cast<std::int32_t>(r)),
                            describe(scene.regions[r].material));
    const nlohmann::ordered_json carried = layers(body);
    for (const auto& [name, layer] : carried.items())
        text += fmt::format("  {}: {} faces, {:.3g} m^2\n", name, layer["faces"].get<std::size_t>(),
                            layer["area_m2"].get<double>());
    if (summary.inverse.gravity) text += describe(scene, *summary.inverse.gravity);
    if (scene.contact.mask_radius_m > 0.0)
        text += fmt::format(
            "  pressure mask of {:g} m: at most {} nodes; at {} of {} vertices and edges the mesh is coarser, "
            "and the patch's own nodes carry the load\n",
            scene.contact.mask_radius_m, summary.mask.most_nodes, summary.mask.widened, summary.mask.places);
    if (summary.pair) text += describe(*summary.pair);
    if (summary.body_modes) text += describe(*summary.body_modes);
    text += stiffness_line(scene, summary.size.stiffness, press);
    if (summary.stiffening && summary.stiffening->pressed)
        text += describe(*scene.material.stiffening->press, *summary.stiffening->pressed);
    else if (summary.stiffening)
        text += describe(*summary.stiffening);
    else if (const auto& s = summary.inverse.small_strain)
        text += fmt::format(
            "  small strain: the force is within {:.0f} % of a rubber's to {:.2g} m deep; pulling {:.2g}, sideways "
            "{:.2g} m "
            "(expected, median of {} places)\n",
            100.0 * SmallStrain::kShare, s->pressing_m, s->pulling_m, s->sideways_m, s->places);
    text += fmt::format("  spatial index: {} boxes, of which a finger's way of 5 mm visits at most {}; a tick {}\n",
                        summary.size.index.boxes, summary.size.index.fast_way_boxes, summary.size.index.tick_boxes);
    text += "\n  check                                        value\n";
    for (const Check& check : kChecks)
        text += fmt::format("  {:<40} {:>9.3g}\n", check.text, summary.inverse.checks.*check.value);
    text += describe(digits_of(summary), summary);
    if (summary.identity.drawing == "solves")
        text +=
            "\n  columns.npy would be over tables.column_budget: the factor is kept, and the viewer solves each "
            "frame\n";
    if (summary.reused.all) text += "\n  blocks, columns and checks are those of an earlier run of the same body\n";
    text += flash_table(scene, summary.size);
    text += ("\n  table                size    stage           time\n");
    for (std::size_t i = 0; i < std::max(summary.files.size(), summary.stages.size()); ++i) {
        if (i < summary.files.size())
            text += fmt::format("  {:<14} {:>10}", summary.files[i].name, human_bytes(summary.files[i].bytes));
        else
            text += fmt::format("{:28}", "");
        if (i < summary.stages.size())
            text += fmt::format("    {:<13} {:>9.4f} s", summary.stages[i].name, summary.stages[i].time_s);
        text += '\n';
    }
    return text;
}

}  // namespace haptable
