// SPDX-License-Identifier: GPL-2.0-or-later
// K u = F over the free nodes,   L = K^-1,   S_i = (L_ii)^-1   (the paper's equations 3, 5, 7)
#include "host/precompute/precompute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <thread>

#include "codegen/codegen.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/body/assembly.hpp"
#include "host/body/rigid_body.hpp"
#include "host/body/sample_tool.hpp"
#include "host/compliance/modes.hpp"
#include "host/compliance/pair_coupling.hpp"
#include "host/compliance/sample.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/inverse/free_inverse.hpp"
#include "host/inverse/solve/factor_file.hpp"
#include "host/precompute/facts.hpp"
#include "host/precompute/plan.hpp"
#include "host/precompute/requirements.hpp"
#include "host/precompute/write_tables.hpp"
#include "host/tables/own_tables.hpp"
#include "host/tables/tool.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Matrices = std::vector<Eigen::Matrix3d>;

// Below it a trial in float would be in vain: rounding the factor to float alone costs as much.
constexpr double kLeastFloatError = 8.0 * std::numeric_limits<float>::epsilon();
// The error of the worst L_ii of all in float, as a multiple of the worst of a sample of 16 to 32: at most 5 on 18
// bodies (needle, slivers, Poisson's ratio up to 0.4999999) under four kernels.
constexpr double kWorseThanSample = 8.0;

/// What the steps of one run share.
struct Run {
    const Scene& scene;
    const Body& body;
    const Plan& plan;
    const PrecomputeOptions& options;
    Inverse& inverse;         ///< of what gives way at once
    Inverse& whole;           ///< of the body at rest: the same, but for its modes
    const RestInverse* rest;  ///< that is `inverse`, where it rings
    Progress& progress;
    StageClock& clock;
    const fs::path& folder;  ///< where the tables are to be
    const fs::path& beside;  ///< where they are written first
    Workers& workers;        ///< for what is not the inverse's
};

int threads_of(const PrecomputeOptions& options) {
    return options.threads > 0 ? options.threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// Two places of the body are loaded at once.
bool is_coupled(const Scene& scene) { return scene.contact.fingers > 1 || scene.tool; }

/// The mesh, and what of it is fixed and touched.
Body read_body(const Scene& scene, Progress& progress) {
    return make_body(scene, make_mesh(scene.mesh, [&](std::size_t nodes, std::size_t expected) {
                         // An estimate, and a second try may follow: never quite done.
                         const double filled =
                             expected > 0 ? static_cast<double>(nodes) / static_cast<double>(expected) : 0.0;
                         progress.done(std::min(filled, 0.99),
                                       fmt::format("filling the surface: {} of about {} nodes", nodes, expected));
                     }));
}

/// A factor that is distributed over processes, or of a body that is held where it should not be, cannot be left for
/// the viewer: then nothing is drawn, and a note says so.
Drawing choose_drawing(const Scene& scene, const Inverse& inverse, Body& body) {
    const Drawing drawing = drawing_of(scene, body);
    if (drawing != Drawing::kSolves || !(inverse.is_distributed() || scene.free_body || scene.body_modes))
        return drawing;
    body.mesh.notes.push_back(fmt::format(
        "columns.npy would have {:.3g} GB, over tables.column_budget: there will be no deformation to "
        "draw (the factor that a viewer could solve with is haptable-precompute's, on one machine, of a body that "
        "is held and does not ring); raise it "
        "or touch a smaller region",
        column_bytes(scene, body) / 1e9));
    return Drawing::kNone;
}

/// Bytes of the Lanczos vectors, of the modes and of M.
double mode_memory(const Scene& scene, Eigen::Index unknowns) {
    return 8.0 * static_cast<double>(unknowns) * (4.0 * scene.body_modes->modes + 60.0);
}

/// Is there room for all that follows?
MemoryNeed foresee(const Run& run, const Stiffness& k) {
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    InverseRequest request{
        {plan.blocks, plan.mask_pairs}, {}, {}, options.column_tolerance > 0.0, 3 * static_cast<int>(kNodesPerBlock)};
    if (plan.drawing == Drawing::kColumns) {
        request.node = plan.column_node;
        request.row = plan.column_row;
    }
    MemoryNeed need = inverse.analyse(k, request);
    if (scene.body_modes) need.solves += mode_memory(scene, k.size());
    if (is_coupled(scene)) need.solves += pair_memory(pair_controls(scene, body, plan.masks));
    if (options.memory_bytes > 0.0) need.available = options.memory_bytes;
    require_memory(scene.file.string(), need, static_cast<double>(body.free_node.size()));
    if (plan.drawing == Drawing::kColumns) require_room("columns.npy", column_bytes(scene, body), beside);
    if (plan.drawing == Drawing::kSolves)
        require_room("the factor", factor_file_bytes(*inverse.whole_factor()), beside);
    return need;
}

/// L_ii of all nodes: of `found` and of the earlier run.
Matrices complete_l_ii(const Plan& plan, const Matrices& found) {
    const Matrices earlier = plan.earlier.compliance();
    Matrices l_ii;
    std::size_t next = 0;
    for (std::int32_t place : plan.block_place)
        l_ii.push_back(place < 0 ? found[next++] : earlier[static_cast<std::size_t>(place)]);
    return l_ii;
}

/// Bound of the relative error of S_i = (L_ii)^-1 where L_ii was found in float: that of L_ii, as the sample's solves
/// show it, times its condition. Infinite where too few of the sample were found now.
double float_error(const Plan& plan, const Sample& sample, const Matrices& found) {
    const auto is_new = [&](std::size_t place) { return plan.block_place[place] < 0; };
    if (2 * std::count_if(sample.place.begin(), sample.place.end(), is_new) < std::ssize(sample.place))
        return std::numeric_limits<double>::infinity();
    double condition = 1.0;
    for (std::size_t i = 0; i < plan.l_ii_count; ++i) condition = std::max(condition, condition_of(found[i]));
    return kWorseThanSample * condition * largest_difference(sample, complete_l_ii(plan, found));
}

/// The missing blocks; in float only where that is shown to keep the tolerance.
Blocks compute_blocks(const Run& run, const Sample& sample) {
    const Plan& plan = run.plan;
    if (plan.blocks.empty()) return {{}, {BlockFacts().method, plan.earlier.summary().blocks.precision, 0.0}};
    if (run.options.tolerance > kLeastFloatError && !run.inverse.is_distributed()) {
        Blocks trial = run.inverse.blocks(plan.blocks, Precision::kFloat, run.progress);
        if (trial.facts.precision == Precision::kDouble ||
            float_error(plan, sample, trial.l_ij) < run.options.tolerance)
            return trial;
    }
    return run.inverse.blocks(plan.blocks, Precision::kDouble, run.progress);
}

/// S_i of all nodes; those of the earlier run to the last bit.
NodeStiffness invert_l_ii(const Body& body, const Plan& plan, const Matrices& l_ii) {
    NodeStiffness stiffness;
    for (std::size_t i = 0; i < l_ii.size(); ++i) stiffness.add(body.touch_node[i], l_ii[i]);
    for (std::size_t i = 0; i < l_ii.size(); ++i)
        if (plan.block_place[i] >= 0) stiffness.stiffness_n_per_m[i] = plan.earlier.stiffness(plan.block_place[i]);
    return stiffness;
}

MaskSummary make_mask(const Run& run) {
    const Masks& masks = run.plan.masks;
    run.clock.begin("mask_blocks");
    const Blocks under = run.inverse.blocks(run.plan.mask_pairs, Precision::kDouble, run.progress);
    run.clock.begin("mask_products");
    const auto compliance = compute_mask_compliance(masks, run.body.mesh.position_m, run.body.unknown,
                                                    run.plan.mask_pairs, under.l_ij, run.workers, run.progress);
    write_mask(masks, compliance, run.beside);
    return {under.facts,      compliance.flops, under.l_ij.size(),
            masks.most_nodes, masks.widened,    masks.vertex_id.size() + masks.edge_id.size()};
}

/// What couples two fingers, and how good it is.
PairSummary make_pair(const Run& run) {
    constexpr std::size_t kPlaces = 10000, kOfExact = 500;  // where nothing is left out, the eigenvalue alone is asked
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    run.clock.begin("coupling");
    const PairControls controls = pair_controls(scene, body, plan.masks);
    const Eigen::MatrixXd l = loaded_compliance(inverse, controls, body.unknown, progress);
    const double meeting_m = meeting_distance(scene, body);
    run.clock.begin("clusters");
    const PairTables tables = in_scene(scene, [&] {
        return make_pair_tables(controls, l, meeting_m, run.scene.tables.coupling_bytes, run.scene.contact,
                                run.progress);
    });
    write_pair(tables, beside);
    return {tables, measure_pair(controls, l, tables, scene.contact, tables.is_exact() ? kOfExact : kPlaces)};
}

/// Entries of columns.npy in half precision are multiples of a power of 2 that puts the largest L_ii at 2^8: far above
/// the least normal number (2^-14), with room up to 2^15 for rows that are softer than the touchable nodes.
ColumnFormat format_of(const Scene& scene, const Matrices& l_ii) {
    if (scene.tables.column_precision != Storage::kFloat16) return {};
    double largest = 0.0;
    for (const Eigen::Matrix3d& block : l_ii) largest = std::max(largest, block.cwiseAbs().maxCoeff());
    return {true, std::ldexp(1.0, std::ilogb(largest) - 8)};
}

/// How it rings: files, and what is told of it.
ModeFacts make_modes(const Run& run, const Matrices& l_ii) {
    run.clock.begin("modes");
    const PairControls controls = pair_controls(run.scene, run.body, run.plan.masks);
    write_modes(mode_tables(run.scene, run.body, run.rest->modes(), controls, run.plan.row), run.beside);
    return mode_facts(run.scene, *run.rest, run.plan.node, l_ii);
}

/// columns.npy, through a store that outlives a run that is cut short. In float where the sample leaves half of the
/// tolerance for columns that are worse. Returns the largest difference to the sample too.
std::pair<ColumnSummary, double> make_columns(const Run& run, const Identity& identity, const Matrices& l_ii,
                                              const Sample& sample) {
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    const ColumnFormat format = format_of(scene, l_ii);
    ColumnSummary summary{word(scene.tables.column_precision), format.unit_m_per_n, 0.0, {}};
    Precision precision = Precision::kDouble;
    if (options.column_tolerance > 0.0 && !inverse.is_distributed()) {
        summary.float_error = float_column_error(inverse, plan.row, sample, progress);
        if (summary.float_error <= 0.5 * options.column_tolerance) precision = Precision::kFloat;
    }
    const auto columns = inverse.columns(plan.column_node, plan.column_row, precision);
    const std::uint64_t key =
        hash_work(scene, identity, name_of(precision), format.unit_m_per_n, plan.column_node, plan.column_row);
    ColumnStore store(work_folder(folder), key, *columns, plan.node.size(), plan.row.size(), format,
                      plan.column_places);
    double difference = 0.0;
    try {
        summary.facts = columns->compute(progress, store.sink());
        if (plan.reused_columns() > 0)
            plan.earlier.copy_columns(body.touch_node, plan.column_place, rows_of(scene, body), store.file());
        for (std::size_t c = 0; c < sample.place.size(); ++c)
            difference = std::max(difference, store.difference(sample.place[c], sample.column[c]));
        store.publish(beside / "columns.npy");
    } catch (const Error&) {
        store.discard();
        throw;
    }
    return {summary, difference};
}

/// K and its factor, where there is room for all that follows.
void factorize(const Run& run, const Stiffness& k, Summary& summary) {
    run.clock.begin("analysis");
    summary.memory = foresee(run, k);
    run.clock.begin("factor");
    summary.inverse.factor = run.inverse.factorize(k, run.progress);
    summary.inverse.checks.smallest_pivot_ratio =
        require_pivots(run.scene, run.body, k, run.whole, summary.inverse.factor);
    if (run.rest != nullptr) require_rendered(run.scene, run.rest->modes());
}

/// The body under its own weight. With prestress K becomes that of the loaded body, and is factorised again.
void load_by_gravity(const Run& run, Stiffness& k, Summary& summary) {
    run.clock.begin("gravity");
    summary.sag_m = find_sag(run.scene, run.body, run.whole);
    const Eigen::SparseMatrix<double> k_sigma = prestress_of(run.scene, run.body, summary.sag_m);
    summary.inverse.gravity = judge_gravity(run.scene, run.body, run.plan.masks, run.whole, summary.sag_m, k_sigma);
    if (!run.scene.gravity->prestress) return;
    require_unbuckled(run.scene, *summary.inverse.gravity);
    k = assemble_free(run.scene, run.body, k_sigma);
    factorize(run, k, summary);
}

/// K of a body that is not held, in place of K_c, which was factorised.
void assemble_unheld(const Run& run, Stiffness& k) {
    if (run.scene.free_body) k = assemble_free(run.scene, run.body);
}

/// What is missing of L. Returns S_i of all nodes; edges, masks and columns go into files.
Matrices compute(const Run& run, Summary& summary) {
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    Checks& checks = summary.inverse.checks;
    // 4. K of the free nodes, and its factor; again where the body's own weight changes it.
    clock.begin("assembly");
    Stiffness k = assemble_held(scene, body);
    factorize(run, k, summary);
    assemble_unheld(run, k);
    if (scene.gravity && !scene.free_body) load_by_gravity(run, k, summary);
    // 5. Checks that need K, which can go then.
    clock.begin("condition");
    checks.condition_estimate = estimate_condition(k, whole);
    checks.scaled_condition = estimate_scaled_condition(k, whole);
    clock.begin("check");
    const Sample sample = solve_sample(inverse, k, plan.node, plan.row, progress);
    checks.solved_nodes = sample.place.size();
    checks.largest_residual = sample.largest_residual;
    checks.largest_asymmetry = largest_asymmetry(sample.l);
    require_residual(scene, sample.largest_residual);
    k = Stiffness();
    clock.begin("small_strain");
    summary.inverse.small_strain = find_small_strain(scene, body, plan.masks, whole);
    if (const auto& stiffening = scene.material.stiffening) {
        clock.begin("stiffening");
        if (stiffening->press) {
            const double radius_m = stiffening->press->radius_m;
            summary.stiffening = fit_press(
                scene, body, radius_m > 0.0 ? masks_of(body, radius_m, run.workers, progress) : plan.masks, whole);
            summary.inverse.small_strain.reset();
        } else if (stiffening->curve.energy_j > 0.0) {
            summary.stiffening.emplace().curve = stiffening->curve;
            summary.inverse.small_strain.reset();
        } else {
            summary.stiffening = fit_stiffening(scene, body, plan.masks, whole, progress);
            summary.inverse.small_strain = summary.stiffening->good;
        }
    }
    clock.begin("locking");
    summary.inverse.locking = measure_locking(scene, body, plan.masks, whole);
    // 6. L_ii of nodes, L_ij of edges and under masks.
    clock.begin("blocks");
    const Blocks blocks = compute_blocks(run, sample);
    summary.inverse.blocks = blocks.facts;
    const Matrices l_ii = complete_l_ii(plan, blocks.l_ij);
    const NodeStiffness stiffness = invert_l_ii(body, plan, l_ii);
    checks.smallest_eigenvalue_m_per_n = stiffness.smallest_eigenvalue_m_per_n;
    checks.largest_block_condition = stiffness.largest_condition;
    checks.largest_block_difference = largest_difference(sample, l_ii);
    if (scene.contact.force == ForceLaw::kConsistent)
        write_edges(scene, body, std::span(blocks.l_ij).subspan(plan.l_ii_count), beside);
    if (!plan.mask_pairs.empty()) summary.mask = make_mask(run);
    if (is_coupled(scene)) summary.pair = make_pair(run);
    if (rest != nullptr) summary.body_modes = make_modes(run, l_ii);
    // 7. Columns; or the factor, for a viewer that solves.
    clock.begin("columns");
    if (plan.drawing == Drawing::kColumns)
        std::tie(summary.inverse.columns, checks.largest_column_difference) =
            make_columns(run, summary.identity, l_ii, sample);
    if (plan.drawing == Drawing::kSolves) write_factor(*inverse.whole_factor(), body.free_node, beside);
    summary.reused = {false, plan.node.size() - plan.l_ii_count, plan.reused_columns()};
    summary.processes = inverse.processes();
    return stiffness.stiffness_n_per_m;
}

ToolTables tool_tables(const Tool& tool, const ToolSample& sample) {
    ToolTables tables{tool.point_m,           tool.max_torque_n_m,
                      tool.stiffness_n_per_m, tool.turn_stiffness_n_m_per_rad,
                      sample.spacing_m,       {}};
    for (const auto& triangle : sample.surface_m)
        for (const Eigen::Vector3d& corner : triangle)
            tables.surface_corner_m.push_back(
                {static_cast<float>(corner.x()), static_cast<float>(corner.y()), static_cast<float>(corner.z())});
    return tables;
}

/// Nothing is missing: neither K nor its factor is needed.
Matrices take_over(const Run& run, Summary& summary) {
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    clock.begin("reuse");
    summary.inverse = plan.earlier.summary();
    if (auto& known = summary.inverse.small_strain; known && known->finger_radius_m != scene.contact.mask_radius_m)
        known.reset();  // of another finger
    if (auto& known = summary.inverse.locking; known.finger_radius_m != pad_radius_m(scene, body.mesh))
        known = foresee_locking(scene, body.mesh);
    if (plan.drawing == Drawing::kColumns) {
        const ColumnFormat format = format_of(scene, plan.earlier.compliance());
        const std::vector<std::int32_t>& rows = rows_of(scene, body);
        ColumnFile file(beside / "columns.npy", plan.node.size(), rows.size(), format, false);
        plan.earlier.copy_columns(body.touch_node, plan.column_place, rows, file);
        summary.inverse.columns.format = word(scene.tables.column_precision);
        summary.inverse.columns.unit_m_per_n = format.unit_m_per_n;
    }
    if (plan.drawing == Drawing::kSolves)
        for (const char* file : kFactorFiles) fs::copy_file(folder / file, beside / file);
    Matrices stiffness;
    for (std::int32_t place : plan.block_place) stiffness.push_back(plan.earlier.stiffness(place));
    if (scene.gravity && !scene.free_body) summary.sag_m = read_sag(folder);
    summary.reused = {true, plan.node.size(), plan.reused_columns()};
    return stiffness;
}

/// The files that the folder has now, by name, each with its hash; one that is known is not read again.
void list_files(const fs::path& folder, std::vector<WrittenFile>& files) {
    for (const fs::path& file : files_in(folder)) {
        const fs::path name = file.filename();
        const bool is_known =
            std::any_of(files.begin(), files.end(), [&](const auto& known) { return known.name == name; });
        if (!is_known) files.push_back({name, fs::file_size(file), hash_file(file)});
    }
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
}

/// The tables; the same as C; the summary; and again what programs read, with the hash of all that.
void write(const Run& run, const Matrices& stiffness_n_per_m, const std::optional<RigidBody>& rigid, Summary& summary) {
    const auto& [scene, body, plan, options, inverse, whole, rest, progress, clock, folder, beside, workers] = run;
    clock.begin("write");
    write_file(beside / "options.json", options_text(scene));
    write_tables(scene, body, plan.drawing, stiffness_n_per_m, summary.sag_m, beside);
    if (rigid) write_rigid_body(scene, body, *rigid, beside);
    list_files(beside, summary.files);
    write_file(beside / "tables.json", tables_text(facts_of(scene, body, summary), summary, ""));
    clock.begin("codegen");
    summary.size = in_scene(scene, [&] { return generate_model(run.beside, run.options.code); });
    list_files(beside, summary.files);
    summary.stages = clock.end();
    const nlohmann::ordered_json facts = facts_of(scene, body, summary);
    write_file(beside / "summary.json", summary_text(facts, scene, body, summary));
    write_file(beside / "tables.json", tables_text(facts, summary, hash_file(beside / "summary.json")));
}

}  // namespace

fs::path work_folder(const fs::path& folder) { return plain_folder(folder) / "columns.unfinished"; }

Result precompute(const Scene& given, const fs::path& folder_in, Progress& progress, const PrecomputeOptions& options) {
    Scene scene = given;
    const ToolSample tool = complete_tool(scene);
    const fs::path folder = plain_folder(folder_in);
    CholmodInverse here(options.threads);
    Inverse& inverse = options.inverse != nullptr ? *options.inverse : here;
    StageClock clock(progress);
    Result result;
    auto& [body, summary, unchanged] = result;
    // 1. The mesh, and what of it is fixed and touched. Is it constrained, and does it fit? The mesh alone can tell.
    clock.begin("mesh");
    body = read_body(scene, progress);
    if (scene.tool) body.mesh.notes.push_back("the tool has " + describe_tool(scene, tool));
    summary.audit = audit_mesh(body.mesh, body.surface);
    summary.supports = require_constrained(scene, body);
    std::optional<RigidBody> rigid;
    if (scene.free_body) require_movable(scene, rigid.emplace(rigid_body_of(scene, body)));
    require_rows_and_modes(scene, body);
    require_servo(scene, body);
    const Drawing drawing = choose_drawing(scene, inverse, body);
    summary.identity = {hash_model(scene, body), hash_body(scene, body), options.tolerance, options.column_tolerance,
                        name_of(drawing)};
    unchanged = !options.force && is_current(folder, scene, summary.identity, options.code);
    if (unchanged) return result;
    // 2. A folder of ours, and one in it for files that come into their place together. One writer at a time.
    OwnFolder own(folder, kTables, own_tables_in(folder));
    own.file(work_folder(folder).filename());
    const StagedPath beside(folder / "tables", StagedKind::folder);
    // 3. What an earlier run left that still holds, and so what is missing. Then 4 to 7: K, its factor, what is wanted
    // of L = K^-1.
    clock.begin("plan");
    // What two fingers, modes and dents need of an earlier run's factor was not kept.
    const bool anew = options.force || is_coupled(scene) || scene.body_modes || scene.material.stiffening;
    Plan plan = make_plan(scene, body, drawing, summary.identity, folder, anew);
    Workers workers(threads_of(options));
    if (scene.contact.force == ForceLaw::kPressureMask) {
        clock.begin("masks");
        plan_masks(scene, body, workers, progress, plan);
    }
    std::optional<FreeInverse> relieved;
    if (rigid) relieved.emplace(inverse, rigid->motion, rigid->momentum);
    Inverse& whole = relieved ? static_cast<Inverse&>(*relieved) : inverse;
    std::optional<RestInverse> rest;
    if (scene.body_modes) rest.emplace(whole, assemble_mass(scene, body), scene.body_modes->modes);
    const Run run{scene,
                  body,
                  plan,
                  options,
                  rest ? static_cast<Inverse&>(*rest) : whole,
                  whole,
                  rest ? &*rest : nullptr,
                  progress,
                  clock,
                  folder,
                  beside.path(),
                  workers};
    if (scene.tool) write_tool(tool_tables(*scene.tool, tool), beside.path());
    const Matrices stiffness_n_per_m = plan.is_complete() ? take_over(run, summary) : compute(run, summary);
    // 8. All tables, as C too, and the summary; then into their place.
    write(run, stiffness_n_per_m, rigid, summary);
    publish(beside.path(), own);
    progress.clear();
    return result;
}

}  // namespace haptable
