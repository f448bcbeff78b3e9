// SPDX-License-Identifier: GPL-2.0-or-later
// K u = F over the free nodes,   L = K^-1,   S_i = (L_ii)^-1   (the paper's equations 3, 5, 7)
#include "host/precompute/precompute.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <optional>
#include <span>

#include "codegen/codegen.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/fem/elasticity.hpp"
#include "host/precompute/column_solver.hpp"
#include "host/precompute/compliance.hpp"
#include "host/precompute/mask.hpp"
#include "host/precompute/point_compliance.hpp"
#include "host/precompute/selected_inversion.hpp"
#include "host/precompute/vtu.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Nodes = std::vector<std::int32_t>;

// A pivot below this share of its diagonal entry is zero to rounding: 2.2e-16 times the growth of a few hundred
// updates. The bodies of the tests that are held keep above 1e-3.
constexpr double kZeroPivot = 1e-13;
// Solves with a larger residual than this would be seen in the float32 tables.
constexpr double kLargestResidual = 1e-6;
// Relative error of an L_ii that was computed in float from the factor in double: at most 1.4e-6 in
// every case that was tried, slender bodies and Poisson's ratio 0.49999999 among them.
constexpr double kFloatError = 2e-6;

void require_held(const Scene& scene, const Body& body, Summary& summary) {
    const Nodes loose = find_loose_nodes(body);
    summary.holds = find_holds(body, loose);
    if (!loose.empty()) throw Error(fmt::format("{}: fixed: {}", scene.file.string(), describe_loose(loose, body)));
}

/// The servo's indices and the flash budget, before any work is done for an object that is too large. What a force
/// needs besides the paper's tables is counted when they are written.
void require_servo(const Scene& scene, const Body& body) {
    Tables tables;
    for (const Eigen::Vector3d& p : body.mesh.position_m) tables.position.push_back({p.x(), p.y(), p.z()});
    tables.patch = body.touch_patch;
    tables.node_id = body.touch_node;
    tables.precision = scene.tables.precision;
    if (scene.contact.force == "interpolated")
        tables.stiffness.assign(body.touch_node.size(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    try {
        const ServoModel model = build_model(tables);
        require_flash(flash_tables(model), model, scene.tables.flash_budget);
    } catch (const Error& error) {
        throw Error(scene.file.string() + ": " + error.what());
    }
}

void require_pivots(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& k, const Factor& factor) {
    const Factor::Pivot weakest = factor.weakest_pivot();
    if (weakest.ratio > kZeroPivot) return;
    Nodes loose = find_softest_nodes(k);
    for (std::int32_t& node : loose) node = body.free_node[static_cast<std::size_t>(node)];
    throw Error(fmt::format("{}: fixed: the pivot of node {} is zero to rounding: {}", scene.file.string(),
                            body.free_node[static_cast<std::size_t>(weakest.row / 3)], describe_loose(loose, body)));
}

Nodes unknowns_of(const Nodes& mesh_nodes, const Body& body) {
    Nodes unknowns;
    for (std::int32_t node : mesh_nodes) unknowns.push_back(body.unknown[static_cast<std::size_t>(node)]);
    return unknowns;
}

/// Mesh nodes whose displacements columns.npy gives.
const Nodes& rows_of(const Scene& scene, const Body& body) {
    return scene.tables.columns == "all" ? body.free_node : body.free_surface_node;
}

/// Says so before the work, where the columns will not fit on the disk.
void require_room(const Scene& scene, const Body& body, const fs::path& folder) {
    if (scene.tables.columns == "none") return;
    const auto needed =
        static_cast<std::uintmax_t>(body.touch_node.size()) * rows_of(scene, body).size() * 9 * sizeof(float);
    std::error_code unknown;
    const fs::space_info space = fs::space(folder, unknown);
    if (!unknown && needed > space.available)
        throw Error(fmt::format(
            "{}: columns.npy needs {:.1f} GB and {:.1f} GB are free; write elsewhere, touch a "
            "smaller region or set columns = \"none\" in [tables]",
            folder.string(), static_cast<double>(needed) / 1e9, static_cast<double>(space.available) / 1e9));
}

/// Edges whose L_ij the consistent force needs: those between free touchable nodes, as mesh nodes, lower first.
std::vector<std::array<std::int32_t, 2>> coupled_edges(const Scene& scene, const Body& body) {
    std::vector<std::array<std::int32_t, 2>> edges;
    if (scene.contact.force != "consistent") return edges;
    for (const auto& edge : edges_of(body.touch_patch))
        if (!body.is_fixed(edge[0]) && !body.is_fixed(edge[1])) edges.push_back(edge);
    return edges;
}

/// The blocks that selected inversion gives: L_ii of the touchable nodes, then L_ij of edges.
std::vector<NodePair> wanted_blocks(const Scene& scene, const Body& body) {
    std::vector<NodePair> wanted;
    const auto unknown = [&](std::int32_t node) { return body.unknown[static_cast<std::size_t>(node)]; };
    for (std::int32_t node : body.touch_node) wanted.push_back({unknown(node), unknown(node)});
    for (const auto& edge : coupled_edges(scene, body)) wanted.push_back({unknown(edge[0]), unknown(edge[1])});
    return wanted;
}

/// A column's entries are not inverted: only the rounding of the solve counts, twice that of a block at the worst.
bool takes_float_columns(double tolerance) { return tolerance > 2.0 * kFloatError; }

/// The wanted blocks by selected inversion, L_ii of `mesh_node` first. In float only where inverting the worst L_ii
/// leaves the error below the tolerance.
std::vector<Eigen::Matrix3d> invert_blocks(const Factor& factor, const std::vector<NodePair>& wanted,
                                           const Nodes& mesh_node, double tolerance, Progress& progress,
                                           Summary& summary) {
    const SelectedInversion inversion(factor.supernodes(), wanted);
    summary.block_flops = inversion.flops();
    if (tolerance > kFloatError) {
        std::vector<Eigen::Matrix3d> blocks = inversion.compute<float>(progress);
        NodeStiffness trial;
        for (std::size_t i = 0; i < mesh_node.size(); ++i) trial.add(mesh_node[i], blocks[i]);
        summary.block_precision = "float";
        if (trial.largest_condition * kFloatError < tolerance) return blocks;
    }
    summary.block_precision = "double";
    return inversion.compute<double>(progress);
}

/// Places in the table of the nodes that are solved for as a check: a block of them, spread evenly.
std::vector<std::size_t> sample_of(std::size_t node_count) {
    std::vector<std::size_t> sample;
    const std::size_t count = std::min(node_count, kNodesPerBlock);
    for (std::size_t c = 0; c < count; ++c) sample.push_back(c * node_count / count);
    return sample;
}

/// Columns of the touchable nodes into the file. In float only where the tolerance leaves room for its rounding.
void compute_columns(const Factor& factor, const Nodes& node, const Nodes& row, double tolerance, Progress& progress,
                     ColumnFile& file, Summary& summary) {
    const ColumnSolver solver(factor.supernodes(), node, row);
    summary.column_flops = solver.flops();
    summary.column_precision = takes_float_columns(tolerance) ? "float" : "double";
    const auto put = [&](std::size_t i, std::size_t k, const Eigen::Matrix3f& l_ri) { file.put(i, k, l_ri); };
    if (summary.column_precision == "float")
        solver.compute<float>(progress, put);
    else
        solver.compute<double>(progress, put);
}

void require_residual(const Scene& scene, const Checks& checks) {
    if (!(checks.largest_residual < kLargestResidual))
        throw Error(
            fmt::format("{}: the solves leave a residual of {:.3g}, more than {}: K is too badly conditioned; "
                        "mend slivers in the mesh, or lower a Poisson's ratio near 0.5",
                        scene.file.string(), checks.largest_residual, kLargestResidual));
}

/// Compares blocks and columns with plain solves of a sample of nodes, which share no code with them.
void check_with_solves(const Scene& scene, const Eigen::SparseMatrix<double>& k, const Factor& factor,
                       const Nodes& node, const Nodes& row, const std::vector<Eigen::Matrix3d>& l_ii,
                       const ColumnFile* columns, Progress& progress, Checks& checks) {
    const std::vector<std::size_t> sample = sample_of(node.size());
    Nodes sample_node;
    std::vector<Eigen::Matrix3d> sample_l_ii;
    for (std::size_t i : sample) {
        sample_node.push_back(node[i]);
        sample_l_ii.push_back(l_ii[i]);
    }
    BlockDifference difference(sample_node, sample_l_ii);
    Asymmetry asymmetry(sample_node);
    checks.largest_residual =
        solve_columns(factor, k, sample_node, progress, [&](std::size_t first, const Eigen::MatrixXd& x) {
            difference.take(first, x);
            asymmetry.take(first, x);
            for (std::size_t c = 0; columns != nullptr && c < static_cast<std::size_t>(x.cols()) / 3; ++c)
                checks.largest_column_difference = std::max(
                    checks.largest_column_difference,
                    columns->difference(sample[first + c], row, x.middleCols<3>(3 * static_cast<Eigen::Index>(c))));
        });
    checks.solved_nodes = sample.size();
    checks.largest_block_difference = difference.largest;
    checks.largest_asymmetry = asymmetry.largest;
    require_residual(scene, checks);
}

/// S_i of the touchable nodes, and what their L_ii tell.
std::vector<Eigen::Matrix3d> invert_each(const Body& body, const std::vector<Eigen::Matrix3d>& l_ii, Checks& checks) {
    NodeStiffness stiffness;
    for (std::size_t i = 0; i < l_ii.size(); ++i) stiffness.add(body.touch_node[i], l_ii[i]);
    checks.smallest_eigenvalue_m_per_n = stiffness.smallest_eigenvalue_m_per_n;
    checks.largest_block_condition = stiffness.largest_condition;
    return std::move(stiffness.stiffness_n_per_m);
}

template <typename T, std::size_t k>
void write_rows(const fs::path& path, const std::vector<std::array<T, k>>& rows) {
    const T* first = rows.empty() ? nullptr : rows.front().data();
    write_npy<T>(path, {rows.size(), k}, std::span<const T>(first, k * rows.size()));
}

void write_position(const fs::path& path, const std::vector<Eigen::Vector3d>& position_m) {
    NpyWriter<double> writer(path, {position_m.size(), 3});
    for (const Eigen::Vector3d& p : position_m) writer.append(std::span<const double>(p.data(), 3));
    writer.close();
}

/// S is symmetric: its columns are its rows.
void write_stiffness(const fs::path& path, const std::vector<Eigen::Matrix3d>& stiffness_n_per_m) {
    NpyWriter<double> writer(path, {stiffness_n_per_m.size(), 3, 3});
    for (const Eigen::Matrix3d& s : stiffness_n_per_m) writer.append(std::span<const double>(s.data(), 9));
    writer.close();
}

void write_tables(const Scene& scene, const Body& body, const std::vector<Eigen::Matrix3d>& stiffness_n_per_m,
                  const fs::path& folder) {
    write_position(folder / "position.npy", body.mesh.position_m);
    write_rows(folder / "surface.npy", body.surface.patch);
    write_rows(folder / "patch.npy", body.touch_patch);
    write_npy<std::int32_t>(folder / "node_id.npy", {body.touch_node.size()}, body.touch_node);
    write_stiffness(folder / "stiffness.npy", stiffness_n_per_m);
    if (scene.tables.columns != "none") {
        const Nodes& rows = rows_of(scene, body);
        write_npy<std::int32_t>(folder / "row_id.npy", {rows.size()}, rows);
    }
    write_file(folder / "mesh.vtu", to_vtu(body));
}

/// 3x3 blocks, row by row.
void write_blocks(const fs::path& path, const std::vector<std::size_t>& shape,
                  const std::vector<Eigen::Matrix3d>& blocks) {
    NpyWriter<double> writer(path, shape);
    for (const Eigen::Matrix3d& block : blocks) {
        const Eigen::Matrix3d rows = block.transpose();
        writer.append(std::span<const double>(rows.data(), 9));
    }
    writer.close();
}

template <std::size_t group>
std::vector<Eigen::Matrix3d> flat(const std::vector<std::array<Eigen::Matrix3d, group>>& grouped) {
    std::vector<Eigen::Matrix3d> blocks;
    for (const auto& one : grouped) blocks.insert(blocks.end(), one.begin(), one.end());
    return blocks;
}

/// L_ij of every touchable edge; 0 where an end is fixed.
void write_edges(const std::vector<std::array<std::int32_t, 2>>& coupled, const std::vector<Eigen::Matrix3d>& l_ij,
                 const Body& body, const fs::path& folder) {
    const auto edges = edges_of(body.touch_patch);
    std::vector<Eigen::Matrix3d> blocks;
    std::size_t next = 0;
    for (const auto& edge : edges) {
        const bool has = next < coupled.size() && coupled[next] == edge;
        blocks.push_back(has ? l_ij[next++] : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
    }
    write_rows(folder / "edge_id.npy", edges);
    write_blocks(folder / "edge_compliance.npy", {edges.size(), 1, 3, 3}, blocks);
}

/// How loads on the masks' control points spread over nodes: vertices first, then edges.
void write_spread(const Masks& masks, const fs::path& folder) {
    std::vector<std::int32_t> begin{0}, node;
    std::vector<float> weight;
    for (const auto* list : {&masks.vertex, &masks.edge})
        for (const NodeWeights& one : *list) {
            node.insert(node.end(), one.node.begin(), one.node.end());
            for (double w : one.weight) weight.push_back(static_cast<float>(w));
            begin.push_back(static_cast<std::int32_t>(node.size()));
        }
    write_npy<std::int32_t>(folder / "spread_begin.npy", {begin.size()}, begin);
    write_npy<std::int32_t>(folder / "spread_node.npy", {node.size()}, node);
    write_npy<float>(folder / "spread_weight.npy", {weight.size()}, weight);
}

/// The tables of the pressure mask.
void compute_mask(const Scene& scene, const Body& body, const Factor& factor, const Eigen::SparseMatrix<double>& k,
                  const fs::path& folder, Progress& progress, Summary& summary) {
    const Masks masks = make_masks(body.mesh.position_m, body.touch_patch, scene.contact.mask_radius_m);
    const MaskCompliance c = compute_mask_compliance(factor, k, masks, body.touch_patch, body.unknown, progress);
    summary.mask_most_nodes = masks.most_nodes;
    summary.mask_widened = masks.widened;
    summary.mask_places = masks.vertex_id.size() + masks.edge_id.size();
    write_npy<std::int32_t>(folder / "vertex_id.npy", {masks.vertex_id.size()}, masks.vertex_id);
    write_rows(folder / "edge_id.npy", masks.edge_id);
    write_blocks(folder / "vertex_compliance.npy", {c.vertex.size(), 3, 3}, c.vertex);
    write_blocks(folder / "edge_compliance.npy", {c.edge.size(), 3, 3, 3}, flat(c.edge));
    write_blocks(folder / "patch_compliance.npy", {c.patch.size(), 3, 3, 3}, flat(c.patch));
    write_spread(masks, folder);
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().filename() != "summary.json") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// Renames every file from the folder beside into its place, summary.json last: who finds it finds all.
void publish(const fs::path& beside, const fs::path& folder) {
    try {
        fs::create_directories(folder);
        fs::remove(folder / "summary.json");
        for (const char* optional : {"columns.npy", "row_id.npy", "edge_id.npy", "edge_compliance.npy", "vertex_id.npy",
                                     "vertex_compliance.npy", "patch_compliance.npy", "spread_begin.npy",
                                     "spread_node.npy", "spread_weight.npy", "display.h", "display.c"})
            if (!fs::exists(beside / optional)) fs::remove(folder / optional);
        for (const fs::path& file : files_in(beside)) fs::rename(file, folder / file.filename());
        fs::rename(beside / "summary.json", folder / "summary.json");
    } catch (const fs::filesystem_error& error) {
        throw Error(fmt::format("{}: cannot be written: {}", folder.string(), error.code().message()));
    }
}

/// An absolute path without a slash at its end has a parent and a name, which "." and "out/" have not.
fs::path plain_folder(const fs::path& given) {
    const fs::path folder = fs::absolute(given).lexically_normal();
    return folder.has_filename() ? folder : folder.parent_path();
}

/// Makes the folder beside `folder` in which the files are written first.
void make_folder(const fs::path& beside, const fs::path& folder) {
    std::error_code failed;
    if (fs::exists(folder, failed) && !fs::is_directory(folder, failed))
        throw Error(folder.string() + ": is a file, and a folder is to be written; give another -o");
    fs::create_directories(beside, failed);
    if (failed) throw Error(fmt::format("{}: cannot be written: {}", folder.string(), failed.message()));
}

/// What make looks at: the tables are as new as their inputs.
void touch_summary(const fs::path& folder) {
    std::error_code ignored;  // a folder that may only be read is no error: nothing was to be written
    fs::last_write_time(folder / "summary.json", fs::file_time_type::clock::now(), ignored);
}

double peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) * 1024.0;
}

/// What the run will need, from the pattern of the factor.
MemoryNeed foresee(const Scene& scene, const Body& body, const Factor& factor, const Eigen::SparseMatrix<double>& k,
                   const Nodes& node, const Nodes& row, double tolerance) {
    MemoryNeed need;
    need.stiffness = static_cast<double>(k.nonZeros()) * (sizeof(double) + sizeof(int));
    need.factor = factor.bytes();
    // A trial in float may have to be done again in double.
    need.fronts =
        static_cast<double>(SelectedInversion(factor.supernodes(), wanted_blocks(scene, body)).stack_entries()) *
        sizeof(double);
    need.solves = 4.0 * static_cast<double>(k.rows()) * 3.0 * static_cast<double>(kNodesPerBlock) * sizeof(double);
    if (scene.tables.columns == "none") return need;
    const ColumnSolver columns(factor.supernodes(), node, row);
    need.columns = takes_float_columns(tolerance) ? columns.bytes<float>() : columns.bytes<double>();
    return need;
}

void describe_factor(const Factor& factor, Summary& summary) {
    summary.ordering = factor.ordering();
    summary.fill = factor.fill();
    summary.flops = factor.flops();
    summary.checks.smallest_pivot_ratio = factor.weakest_pivot().ratio;
}

}  // namespace

Eigen::SparseMatrix<double> assemble_free(const Scene& scene, const Body& body) {
    const auto lame = [](const Material& m) { return Lame::from_young(m.young_pa, m.poisson); };
    std::vector<Lame> material;
    for (std::int32_t region : body.region)
        material.push_back(
            lame(region < 0 ? scene.material : scene.regions[static_cast<std::size_t>(region)].material));
    return assemble_stiffness(body.mesh.position_m, body.mesh.tet, material, body.unknown,
                              static_cast<std::int32_t>(body.free_node.size()));
}

Result precompute(const Scene& scene, const fs::path& folder_in, Progress& progress, const PrecomputeOptions& options) {
    const fs::path folder = plain_folder(folder_in);
    Result result;
    Summary& summary = result.summary;
    const Body& body = result.body;
    StageClock clock(summary);
    // 1. The mesh, and what of it is held and touched. Is it held still? The mesh alone can tell.
    progress.stage("mesh");
    result.body = make_body(scene, make_mesh(scene.mesh));
    summary.audit = audit_mesh(body.mesh);
    require_held(scene, body, summary);
    require_servo(scene, body);
    summary.model_hash = hash_model(scene, body);
    summary.tolerance = options.tolerance;
    result.unchanged = !options.force && is_current(folder, scene, summary);
    if (result.unchanged) return touch_summary(folder), result;
    clock.end("mesh");
    // 2. K of the free nodes.
    progress.stage("assembly");
    const Eigen::SparseMatrix<double> k = assemble_free(scene, body);
    clock.end("assembly");
    // 3. Its Cholesky factor. What the mesh could not tell, the pivots do.
    progress.stage("factor");
    const Nodes node = unknowns_of(body.touch_node, body), row = unknowns_of(rows_of(scene, body), body);
    const Factor factor(k, [&](const Factor& symbolic) {
        summary.memory = foresee(scene, body, symbolic, k, node, row, options.tolerance);
        require_memory(scene.file.string(), summary.memory,
                       options.memory_bytes > 0.0 ? options.memory_bytes : available_memory(),
                       static_cast<double>(body.free_node.size()));
        clock.end("analysis");
    });
    require_pivots(scene, body, k, factor);
    describe_factor(factor, summary);
    clock.end("factor");
    summary.checks.condition_estimate = estimate_condition(k, factor);
    clock.end("condition");
    // 4. Blocks and columns of L, into a folder beside.
    const Beside beside(folder);
    make_folder(beside.path(), folder);
    require_room(scene, body, beside.path());
    progress.stage("blocks");
    std::vector<Eigen::Matrix3d> l_ii =
        invert_blocks(factor, wanted_blocks(scene, body), body.touch_node, options.tolerance, progress, summary);
    const std::vector<Eigen::Matrix3d> l_ij(l_ii.begin() + static_cast<std::ptrdiff_t>(node.size()), l_ii.end());
    l_ii.resize(node.size());
    const std::vector<Eigen::Matrix3d> stiffness = invert_each(body, l_ii, summary.checks);
    clock.end("blocks");
    if (scene.contact.force == "consistent") write_edges(coupled_edges(scene, body), l_ij, body, beside.path());
    if (scene.contact.force == "pressure-mask") {
        progress.stage("mask");
        compute_mask(scene, body, factor, k, beside.path(), progress, summary);
        clock.end("mask");
    }
    std::optional<ColumnFile> columns;
    if (scene.tables.columns != "none") {
        progress.stage("columns");
        columns.emplace(beside.path() / "columns.npy", node.size(), row.size());
        compute_columns(factor, node, row, options.tolerance, progress, *columns, summary);
    }
    clock.end("columns");
    progress.stage("check");
    check_with_solves(scene, k, factor, node, row, l_ii, columns ? &*columns : nullptr, progress, summary.checks);
    columns.reset();
    clock.end("check");
    // 5. The other tables.
    progress.stage("write");
    write_tables(scene, body, stiffness, beside.path());
    write_file(beside.path() / "summary.json", to_json(scene, body, summary));
    clock.end("write");
    // 6. The tables as C; then the summary again, with sizes and times.
    progress.stage("codegen");
    summary.size = generate_model(beside.path());
    clock.end("codegen");
    summary.memory_peak = peak_memory();
    for (const fs::path& file : files_in(beside.path()))
        summary.bytes.emplace_back(file.filename(), fs::file_size(file));
    write_file(beside.path() / "summary.json", to_json(scene, body, summary));
    // 7. All files to their places.
    publish(beside.path(), folder);
    progress.clear();
    return result;
}

}  // namespace haptable
