// SPDX-License-Identifier: GPL-2.0-or-later
// K u = F over the free nodes,   L = K^-1,   S_i = (L_ii)^-1   (the paper's equations 3, 5, 7)
#include "host/precompute/precompute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <span>
#include <thread>

#include "codegen/codegen.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/folder_lock.hpp"
#include "host/inverse/column_solver.hpp"
#include "host/inverse/numeric.hpp"
#include "host/inverse/pairs.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/column_store.hpp"
#include "host/precompute/compliance.hpp"
#include "host/precompute/earlier_tables.hpp"
#include "host/precompute/mask.hpp"
#include "host/precompute/point_compliance.hpp"
#include "host/precompute/vtu.hpp"
#include "host/solve/factor_file.hpp"
#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"

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

[[noreturn]] void refuse_loose(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& k,
                               const std::string& what) {
    Nodes loose = find_softest_nodes(k);
    for (std::int32_t& node : loose) node = body.free_node[static_cast<std::size_t>(node)];
    throw Error(fmt::format("{}: fixed: {} to rounding: {}", scene.file.string(), what, describe_loose(loose, body)));
}

void require_pivots(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& k, const Factor& factor) {
    const Factor::Pivot weakest = factor.weakest_pivot();
    if (weakest.ratio > kZeroPivot) return;
    const std::int32_t node = body.free_node[static_cast<std::size_t>(weakest.row / 3)];
    refuse_loose(scene, body, k, fmt::format("the pivot of node {} is zero", node));
}

/// What a spread solver does not tell of its pivots.
double least_pivot_of(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& k,
                      const LinearSolver& solver) {
    const double least = least_scaled_eigenvalue(k, solver);
    if (!(least > kZeroPivot)) refuse_loose(scene, body, k, "K is singular");
    return least;
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

double column_bytes(const Scene& scene, const Body& body) {
    const double entry = scene.tables.column_precision == "float16" ? sizeof(Half) : sizeof(float);
    return static_cast<double>(body.touch_node.size()) * static_cast<double>(rows_of(scene, body).size()) * 9.0 * entry;
}

/// How the viewer gets its displacements: from columns.npy, or by a solve for each frame where that is over the budget.
enum class Drawing { kNone, kColumns, kSolves };

Drawing drawing_of(const Scene& scene, const Body& body) {
    if (scene.tables.columns == "none") return Drawing::kNone;
    // The target's own display is made from columns.
    const bool fits = column_bytes(scene, body) <= scene.tables.column_budget_bytes;
    return fits || !scene.tables.display_rows.empty() ? Drawing::kColumns : Drawing::kSolves;
}

/// Says so before the work, where a file will not fit on the disk.
void require_room(const char* file, double needed_bytes, const fs::path& folder) {
    std::error_code unknown;
    const fs::space_info space = fs::space(folder, unknown);
    if (!unknown && needed_bytes > static_cast<double>(space.available))
        throw Error(
            fmt::format("{}: {} needs {:.1f} GB and {:.1f} GB are free; write elsewhere, touch a "
                        "smaller region or set columns = \"none\" in [tables]",
                        folder.string(), file, needed_bytes / 1e9, static_cast<double>(space.available) / 1e9));
}

/// Edges whose L_ij the consistent force needs: those between free touchable nodes, as mesh nodes, lower first.
std::vector<std::array<std::int32_t, 2>> coupled_edges(const Scene& scene, const Body& body) {
    std::vector<std::array<std::int32_t, 2>> edges;
    if (scene.contact.force != "consistent") return edges;
    for (const auto& edge : edges_of(body.touch_patch))
        if (!body.is_fixed(edge[0]) && !body.is_fixed(edge[1])) edges.push_back(edge);
    return edges;
}

/// The blocks that selected inversion gives: L_ii of the mesh nodes, then L_ij of edges.
std::vector<NodePair> wanted_blocks(const Scene& scene, const Body& body, const Nodes& mesh_node) {
    std::vector<NodePair> wanted;
    const auto unknown = [&](std::int32_t node) { return body.unknown[static_cast<std::size_t>(node)]; };
    for (std::int32_t node : mesh_node) wanted.push_back({unknown(node), unknown(node)});
    for (const auto& edge : coupled_edges(scene, body)) wanted.push_back({unknown(edge[0]), unknown(edge[1])});
    return wanted;
}

/// The wanted blocks by selected inversion, L_ii of `mesh_node` first. In float only where inverting the worst L_ii
/// leaves the error below the tolerance.
std::vector<Eigen::Matrix3d> invert_blocks(const Factor& factor, const std::vector<NodePair>& wanted,
                                           const Nodes& mesh_node, double tolerance, Progress& progress,
                                           Workers& workers, Summary& summary) {
    const SelectedInversion inversion(factor.supernodes(), wanted);
    summary.block_flops = inversion.flops();
    if (tolerance > kFloatError) {
        std::vector<Eigen::Matrix3d> blocks = inversion.compute<float>(progress, &workers);
        NodeStiffness trial;
        for (std::size_t i = 0; i < mesh_node.size(); ++i) trial.add(mesh_node[i], blocks[i]);
        summary.block_precision = "float";
        if (trial.largest_condition * kFloatError < tolerance) return blocks;
    }
    summary.block_precision = "double";
    return inversion.compute<double>(progress, &workers);
}

/// Places in the table of the nodes that are solved for as a check, spread evenly. A large body's solves are long.
std::vector<std::size_t> sample_of(std::size_t node_count, std::size_t unknown_nodes) {
    constexpr std::size_t kMost = 2 * kNodesPerBlock, kLarge = 20000;
    std::vector<std::size_t> sample;
    const std::size_t count = std::min(node_count, unknown_nodes < kLarge ? kMost : kNodesPerBlock);
    for (std::size_t c = 0; c < count; ++c) sample.push_back(c * node_count / count);
    return sample;
}

/// Entries of columns.npy in half precision are multiples of a power of 2 that puts the largest L_ii at 2^8: far above
/// the least normal number (2^-14), with room up to 2^15 for rows that are softer than the touchable nodes.
ColumnFormat format_of(const Scene& scene, const std::vector<Eigen::Matrix3d>& l_ii) {
    if (scene.tables.column_precision != "float16") return {};
    double largest = 0.0;
    for (const Eigen::Matrix3d& block : l_ii) largest = std::max(largest, block.cwiseAbs().maxCoeff());
    return {true, std::ldexp(1.0, std::ilogb(largest) - 8)};
}

/// Columns of the touchable nodes into the store.
void compute_columns(const ColumnSolver& solver, Progress& progress, Workers& workers, ColumnStore& store,
                     Summary& summary) {
    summary.column_flops = solver.flops();
    summary.column_flops_done = summary.column_precision == "float"
                                    ? solver.compute<float>(progress, store.sink(), &workers)
                                    : solver.compute<double>(progress, store.sink(), &workers);
}

void require_residual(const Scene& scene, const Checks& checks) {
    if (!(checks.largest_residual < kLargestResidual))
        throw Error(
            fmt::format("{}: the solves leave a residual of {:.3g}, more than {}: K is too badly conditioned; "
                        "mend slivers in the mesh, or lower a Poisson's ratio near 0.5",
                        scene.file.string(), checks.largest_residual, kLargestResidual));
}

/// Plain solves of a sample of nodes: they share nothing with inversion and pruned solves but the factor, and their
/// residual checks the factor.
struct Sample {
    std::vector<std::size_t> place;       // in the table
    std::vector<Eigen::Matrix3d> l_ii;    // m/N
    std::vector<Eigen::MatrixXd> column;  // [3 r, 3] at the rows of columns.npy; empty without it
};

Sample solve_sample(const Scene& scene, const Eigen::SparseMatrix<double>& k, const LinearSolver& solver,
                    const Nodes& node, const Nodes& row, Progress& progress, Checks& checks) {
    Sample sample{sample_of(node.size(), static_cast<std::size_t>(k.rows()) / 3), {}, {}};
    Nodes sample_node;
    for (std::size_t i : sample.place) sample_node.push_back(node[i]);
    Asymmetry asymmetry(sample_node);
    checks.largest_residual =
        solve_columns(solver, k, sample_node, progress, [&](std::size_t first, const Eigen::MatrixXd& x) {
            asymmetry.take(first, x);
            for (Eigen::Index c = 0; c < x.cols() / 3; ++c) {
                const std::size_t at = first + static_cast<std::size_t>(c);
                sample.l_ii.emplace_back(x.block<3, 3>(Eigen::Index{3} * sample_node[at], 3 * c));
                Eigen::MatrixXd& column = sample.column.emplace_back(3 * static_cast<Eigen::Index>(row.size()), 3);
                for (std::size_t r = 0; r < row.size(); ++r)
                    column.middleRows<3>(3 * static_cast<Eigen::Index>(r)) =
                        x.block<3, 3>(Eigen::Index{3} * row[r], 3 * c);
            }
        });
    checks.solved_nodes = sample.place.size();
    checks.largest_asymmetry = asymmetry.largest;
    require_residual(scene, checks);
    return sample;
}

/// The sample's columns once more, in float: largest ||float - double|| / ||double|| of a column.
double float_column_error(const Supernodes& factor, const Nodes& node, const Nodes& row, const Sample& sample,
                          Progress& progress) {
    Nodes sample_node;
    for (std::size_t i : sample.place) sample_node.push_back(node[i]);
    std::vector<double> squared(sample_node.size(), 0.0);
    ColumnSolver::Sink sink;
    sink.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri) {
        const auto solved = sample.column[c].middleRows<3>(3 * static_cast<Eigen::Index>(k));
        squared[c] += (l_ri.cast<double>() - solved).squaredNorm();
    };
    ColumnSolver(factor, sample_node, row).compute<float>(progress, sink);
    double largest = 0.0;
    for (std::size_t c = 0; c < squared.size(); ++c) {
        const double error = std::sqrt(squared[c]) / sample.column[c].norm();
        largest = std::max(largest, error < 1.0 ? error : 1.0);  // a NaN is no digit either
    }
    return largest;
}

/// "float" where the trial leaves half of the tolerance for columns that are worse than the sample's.
std::string column_precision(const Supernodes& factor, const Nodes& node, const Nodes& row, const Sample& sample,
                             double tolerance, Progress& progress, Summary& summary) {
    if (!(tolerance > 0.0)) return "double";
    summary.float_column_error = float_column_error(factor, node, row, sample, progress);
    return summary.float_column_error <= 0.5 * tolerance ? "float" : "double";
}

void compare(const Sample& sample, const std::vector<Eigen::Matrix3d>& l_ii, Checks& checks) {
    for (std::size_t c = 0; c < sample.place.size(); ++c) {
        const Eigen::Matrix3d& solved = sample.l_ii[c];
        checks.largest_block_difference =
            std::max(checks.largest_block_difference, (l_ii[sample.place[c]] - solved).norm() / solved.norm());
    }
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

void write_tables(const Scene& scene, const Body& body, const fs::path& folder) {
    write_position(folder / "position.npy", body.mesh.position_m);
    write_rows(folder / "surface.npy", body.surface.patch);
    write_rows(folder / "patch.npy", body.touch_patch);
    write_npy<std::int32_t>(folder / "node_id.npy", {body.touch_node.size()}, body.touch_node);
    if (drawing_of(scene, body) != Drawing::kNone) {
        const Nodes& rows = rows_of(scene, body);
        write_npy<std::int32_t>(folder / "row_id.npy", {rows.size()}, rows);
    }
    write_file(folder / "mesh.vtu", to_vtu(body));
}

/// Files that a scene may do without; old ones must go.
std::vector<std::string> optional_files() {
    std::vector<std::string> files{"columns.npy",          "row_id.npy",       "edge_id.npy",
                                   "edge_compliance.npy",  "vertex_id.npy",    "vertex_compliance.npy",
                                   "patch_compliance.npy", "spread_begin.npy", "spread_node.npy",
                                   "spread_weight.npy",    "display.h",        "display.c"};
    for (const char* name : kFactorFiles) files.emplace_back(name);
    return files;
}

/// 3x3 blocks, row by row.
using Blocks = std::vector<Eigen::Matrix3d>;
/// Writes blocks, row by row, as an array of that shape.
using WriteBlocks = std::function<void(const fs::path&, const std::vector<std::size_t>& shape, const Blocks&)>;

/// Here, or by the processes that the solver is spread over.
WriteBlocks writer_of(SpreadSolver* solver) {
    return [solver](const fs::path& path, const std::vector<std::size_t>& shape, const Blocks& blocks) {
        std::vector<double> values;
        for (const Eigen::Matrix3d& block : blocks) {
            const Eigen::Matrix3d rows = block.transpose();
            values.insert(values.end(), rows.data(), rows.data() + 9);
        }
        if (solver == nullptr)
            write_npy<double>(path, shape, values);
        else
            solver->write_blocks(path, shape, values);
    };
}

template <std::size_t group>
std::vector<Eigen::Matrix3d> flat(const std::vector<std::array<Eigen::Matrix3d, group>>& grouped) {
    std::vector<Eigen::Matrix3d> blocks;
    for (const auto& one : grouped) blocks.insert(blocks.end(), one.begin(), one.end());
    return blocks;
}

/// L_ij of every touchable edge; 0 where an end is fixed.
void write_edges(const std::vector<std::array<std::int32_t, 2>>& coupled, const std::vector<Eigen::Matrix3d>& l_ij,
                 const Body& body, const fs::path& folder, const WriteBlocks& write) {
    const auto edges = edges_of(body.touch_patch);
    std::vector<Eigen::Matrix3d> blocks;
    std::size_t next = 0;
    for (const auto& edge : edges) {
        const bool has = next < coupled.size() && coupled[next] == edge;
        blocks.push_back(has ? l_ij[next++] : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
    }
    write_rows(folder / "edge_id.npy", edges);
    write(folder / "edge_compliance.npy", {edges.size(), 1, 3, 3}, blocks);
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
void write_mask(const Masks& masks, const MaskCompliance& c, const fs::path& folder, const WriteBlocks& write,
                Summary& summary) {
    summary.mask_most_nodes = masks.most_nodes;
    summary.mask_widened = masks.widened;
    summary.mask_places = masks.vertex_id.size() + masks.edge_id.size();
    write_npy<std::int32_t>(folder / "vertex_id.npy", {masks.vertex_id.size()}, masks.vertex_id);
    write_rows(folder / "edge_id.npy", masks.edge_id);
    write(folder / "vertex_compliance.npy", {c.vertex.size(), 3, 3}, c.vertex);
    write(folder / "edge_compliance.npy", {c.edge.size(), 3, 3, 3}, flat(c.edge));
    write(folder / "patch_compliance.npy", {c.patch.size(), 3, 3, 3}, flat(c.patch));
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
        for (const std::string& optional : optional_files())
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

/// Bytes of the factor's files for a viewer that solves: values in float, rows and the rest as int32.
double factor_file_bytes(const Factor& factor) {
    const Supernodes s = factor.supernodes();
    return static_cast<double>(s.value_begin.back()) * sizeof(float) +
           static_cast<double>(s.row.size() + 3 * s.first_column.size() + s.permutation.size()) * sizeof(std::int32_t);
}

/// What the run will need, from the pattern of the factor: K, L, the inversion for `wanted` and the plain solves.
MemoryNeed foresee(const Factor& factor, const Eigen::SparseMatrix<double>& k, const std::vector<NodePair>& wanted,
                   const Workers& workers) {
    MemoryNeed need;
    need.stiffness = static_cast<double>(k.nonZeros()) * (sizeof(double) + sizeof(int));
    need.factor = factor.bytes() + factorize_bytes(factor.supernodes(), workers.count());
    // A trial in float may have to be done again in double.
    const SelectedInversion inversion(factor.supernodes(), wanted);
    need.fronts = static_cast<double>(inversion.stack_entries(workers.count())) * sizeof(double);
    need.solves = 4.0 * static_cast<double>(k.rows()) * 3.0 * static_cast<double>(kNodesPerBlock) * sizeof(double);
    return need;
}

/// Below about ten thousand nodes the supernodes are too small to share.
int threads_for(const PrecomputeOptions& options, const Body& body) {
    constexpr std::size_t kSmall = 10000;
    if (options.threads > 0) return options.threads;
    return body.free_node.size() < kSmall ? 1 : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// The share is an estimate, and a second try may follow: never quite done.
void show_filling(std::size_t nodes, std::size_t expected, Progress& progress) {
    const double share = expected > 0 ? static_cast<double>(nodes) / static_cast<double>(expected) : 0.0;
    progress.done(std::min(share, 0.99), fmt::format("filling the surface: {} of about {} nodes", nodes, expected));
}

void describe_factor(const Factor& factor, Summary& summary) {
    summary.ordering = factor.ordering();
    summary.fill = factor.fill();
    summary.flops = factor.flops();
    summary.checks.smallest_pivot_ratio = factor.weakest_pivot().ratio;
}

/// One run: its scene, its folder, what it has found so far.
class Run {
public:
    Run(const Scene& scene, const fs::path& folder, Progress& progress, const PrecomputeOptions& options,
        Result& result)
        : scene_(scene), folder_(folder), progress_(progress), options_(options), result_(result) {}

    void compute() {
        // 1. The mesh, and what of it is held and touched. Is it held still? The mesh alone can tell.
        progress_.stage("mesh");
        result_.body = make_body(scene_, make_mesh(scene_.mesh, [&](std::size_t nodes, std::size_t expected) {
                                     show_filling(nodes, expected, progress_);
                                 }));
        summary_.audit = audit_mesh(body_.mesh, body_.surface);
        require_held(scene_, body_, summary_);
        require_servo(scene_, body_);
        drawing_ = drawing_of(scene_, body_);
        if (options_.solver != nullptr && drawing_ == Drawing::kSolves) leave_out_columns();
        identify();
        result_.unchanged = !options_.force && is_current(folder_, scene_, summary_);
        if (result_.unchanged) return touch_summary(folder_);
        clock_.end("mesh");
        const FolderLock lock(folder_);
        remove_leftovers(folder_);
        const Beside beside(folder_);
        make_folder(beside.path(), folder_);
        plan();
        find_mask_pairs();
        if (is_complete())
            take_over(beside.path());
        else if (options_.solver != nullptr)
            solve_spread(*options_.solver, beside.path());
        else
            solve(beside.path());
        write(beside.path());
        publish(beside.path(), folder_);
        progress_.clear();
    }

private:
    /// A factor that is spread over processes cannot be left for the viewer.
    void leave_out_columns() {
        drawing_ = Drawing::kNone;
        result_.body.mesh.notes.push_back(fmt::format(
            "columns.npy would have {:.3g} GB, over tables.column_budget: there will be no deformation to "
            "draw (the factor that a viewer could solve with is haptable-precompute's, on one machine); raise it "
            "or touch a smaller region",
            column_bytes(scene_, body_) / 1e9));
    }

    void identify() {
        summary_.model_hash = hash_model(scene_, body_);
        summary_.body_hash = hash_body(scene_, body_);
        summary_.tolerance = options_.tolerance;
        summary_.column_tolerance = options_.column_tolerance;
        summary_.drawing = drawing_ == Drawing::kNone ? "none" : drawing_ == Drawing::kColumns ? "columns" : "solves";
    }

    /// What of an earlier run holds, and what is missing.
    void plan() {
        const std::size_t count = body_.touch_node.size();
        block_place_.assign(count, -1);
        column_place_.assign(count, -1);
        if (options_.force) return;
        earlier_ = EarlierTables(folder_, summary_, rows_of(scene_, body_), scene_.tables.column_precision);
        const std::vector<std::int32_t> place = earlier_.places_of(body_.touch_node);
        // The other forces need more than the L_ii, and then get these with the rest.
        if (earlier_.has_blocks() && scene_.contact.force == "interpolated") block_place_ = place;
        if (earlier_.has_columns() && drawing_ == Drawing::kColumns) column_place_ = place;
    }

    bool is_complete() const {
        const auto held = [](const Nodes& place) { return std::count(place.begin(), place.end(), -1) == 0; };
        return held(block_place_) && (drawing_ != Drawing::kColumns || held(column_place_)) &&
               (drawing_ != Drawing::kSolves || earlier_.has_factor());
    }

    /// Nothing is missing: neither K nor its factor is needed.
    void take_over(const fs::path& beside) {
        Summary old = earlier_.summary();
        if (drawing_ == Drawing::kColumns) {
            const ColumnFormat format = format_of(scene_, earlier_.compliance());
            const Nodes& rows = rows_of(scene_, body_);
            ColumnFile file(beside / "columns.npy", body_.touch_node.size(), rows.size(), format, false);
            earlier_.copy_columns(body_.touch_node, column_place_, rows, file);
            old.column_format = scene_.tables.column_precision;
            old.column_unit_m_per_n = format.unit_m_per_n;
        }
        if (drawing_ == Drawing::kSolves)
            for (const char* file : kFactorFiles) fs::copy_file(folder_ / file, beside / file);
        for (std::int32_t place : block_place_) stiffness_.push_back(earlier_.stiffness(place));
        // What was told of this run so far stays.
        for (auto part : {&Summary::time_s, &Summary::cpu_s, &Summary::peak_bytes}) old.*part = summary_.*part;
        old.model_hash = summary_.model_hash;
        old.drawing = summary_.drawing;
        old.tolerance = summary_.tolerance;
        old.column_tolerance = summary_.column_tolerance;
        old.audit = summary_.audit;
        old.holds = summary_.holds;
        old.reused = true;
        old.reused_blocks = body_.touch_node.size();
        old.reused_columns = drawing_ == Drawing::kColumns ? body_.touch_node.size() : 0;
        summary_ = old;
        clock_.end("reuse");
    }

    /// Places in the table of what is not held.
    static std::vector<std::size_t> missing(const Nodes& place) {
        std::vector<std::size_t> list;
        for (std::size_t i = 0; i < place.size(); ++i)
            if (place[i] < 0) list.push_back(i);
        return list;
    }

    /// The columns that are to be solved for: nodes without one, at the rows that no held column gives by symmetry.
    struct ColumnWork {
        ColumnPlaces place;
        Nodes node, row;  // unknowns
    };
    ColumnWork column_work(const Nodes& node, const Nodes& row) const {
        ColumnWork work;
        work.place.node = missing(column_place_);
        std::set<std::int32_t> held;
        for (std::size_t i = 0; i < node.size(); ++i)
            if (column_place_[i] >= 0) held.insert(node[i]);
        for (std::size_t i : work.place.node) work.node.push_back(node[i]);
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (held.count(row[k]) > 0) continue;
            work.place.row.push_back(k);
            work.row.push_back(row[k]);
        }
        return work;
    }

    /// Mesh nodes whose L_ii is not held.
    Nodes missing_nodes() const {
        Nodes node;
        for (std::size_t i : missing(block_place_)) node.push_back(body_.touch_node[i]);
        return node;
    }

    /// The blocks that are to be computed: L_ii of these, and edges.
    std::vector<NodePair> block_work() const { return wanted_blocks(scene_, body_, missing_nodes()); }

    /// K, its factor, blocks and columns.
    void solve(const fs::path& beside) {
        Workers workers(threads_for(options_, body_));
        summary_.threads = workers.count();
        // 2. K of the free nodes.
        progress_.stage("assembly");
        Eigen::SparseMatrix<double> k = assemble_free(scene_, body_);
        clock_.end("assembly");
        // 3. Its Cholesky factor. What the mesh could not tell, the pivots do.
        const Nodes node = unknowns_of(body_.touch_node, body_);
        const Nodes row = drawing_ == Drawing::kNone ? Nodes() : unknowns_of(rows_of(scene_, body_), body_);
        progress_.stage("ordering");
        const Factor factor(
            k, [&](const Factor& symbolic) { before_factor(symbolic, k, node, row, workers, beside); }, &workers,
            &progress_);
        require_pivots(scene_, body_, k, factor);
        describe_factor(factor, summary_);
        clock_.end("factor");
        // 4. Checks that need K, which can go then.
        const Sample sample = check(factor, k, node, row);
        Eigen::SparseMatrix<double>().swap(k);
        factor.release_workspace();
        clock_.end("check");
        // 5. Blocks and columns of L.
        progress_.stage("blocks");
        const std::vector<Eigen::Matrix3d> l_ii = take_blocks(missing_blocks(factor, workers), sample, beside);
        make_mask([&] { return find_mask_blocks(factor, workers); }, beside);
        if (drawing_ == Drawing::kColumns) make_columns(factor, node, row, l_ii, sample, workers, beside);
        if (drawing_ == Drawing::kSolves) write_factor(factor.supernodes(), Nodes(body_.free_node), beside);
        clock_.end("columns");
    }

    /// The same by a solver that is spread over processes; this one leads.
    void solve_spread(SpreadSolver& solver, const fs::path& beside) {
        const Nodes node = unknowns_of(body_.touch_node, body_);
        const Nodes row = drawing_ == Drawing::kNone ? Nodes() : unknowns_of(rows_of(scene_, body_), body_);
        const Sample sample = factorize_spread(solver, node, row, beside);
        progress_.stage("blocks");
        const std::vector<Eigen::Matrix3d> l_ii = take_blocks(solver.blocks(block_work()), sample, beside);
        make_mask([&] { return solver.blocks(mask_pair_); }, beside);
        if (drawing_ == Drawing::kColumns) write_columns(solver, node, row, l_ii, sample, beside);
        solver.report(summary_);
    }

    /// K, which goes to the processes, and the checks that need it here.
    Sample factorize_spread(SpreadSolver& solver, const Nodes& node, const Nodes& row, const fs::path& beside) {
        progress_.stage("assembly");
        const Eigen::SparseMatrix<double> k = assemble_free(scene_, body_);
        clock_.end("assembly");
        if (drawing_ == Drawing::kColumns) require_room("columns.npy", column_bytes(scene_, body_), beside);
        progress_.stage("factor");
        solver.factorize(k, summary_);
        summary_.checks.smallest_pivot_ratio = least_pivot_of(scene_, body_, k, solver);
        clock_.end("factor");
        Sample sample = check(solver, k, node, row);
        clock_.end("check");
        return sample;
    }

    /// Condition, solves of a sample and what else needs K.
    Sample check(const LinearSolver& solver, const Eigen::SparseMatrix<double>& k, const Nodes& node,
                 const Nodes& row) {
        progress_.stage("check");
        summary_.checks.condition_estimate = estimate_condition(k, solver);
        clock_.end("condition");
        Sample sample = solve_sample(scene_, k, solver, node, drawing_ == Drawing::kColumns ? row : Nodes(), progress_,
                                     summary_.checks);
        return sample;
    }

    std::vector<Eigen::Matrix3d> missing_blocks(const Factor& factor, Workers& workers) {
        const std::vector<NodePair> wanted = block_work();
        if (!wanted.empty())
            return invert_blocks(factor, wanted, missing_nodes(), options_.tolerance, progress_, workers, summary_);
        summary_.block_precision = earlier_.summary().block_precision;
        return {};
    }

    /// What the servo needs of the blocks of block_work(), with those that are held. Returns the L_ii.
    std::vector<Eigen::Matrix3d> take_blocks(const std::vector<Eigen::Matrix3d>& found, const Sample& sample,
                                             const fs::path& beside) {
        const std::vector<std::size_t> fresh = missing(block_place_);
        const auto diagonal_end = found.begin() + static_cast<std::ptrdiff_t>(fresh.size());
        if (scene_.contact.force == "consistent")
            write_edges(coupled_edges(scene_, body_), {diagonal_end, found.end()}, body_, beside, write_blocks_);
        const std::vector<Eigen::Matrix3d> held = earlier_.compliance();
        std::vector<Eigen::Matrix3d> l_ii;
        for (std::size_t i = 0, next = 0; i < block_place_.size(); ++i)
            l_ii.push_back(block_place_[i] < 0 ? found[next++] : held[static_cast<std::size_t>(block_place_[i])]);
        stiffness_ = invert_each(body_, l_ii, summary_.checks);
        for (std::size_t i = 0; i < block_place_.size(); ++i)  // to the last bit
            if (block_place_[i] >= 0) stiffness_[i] = earlier_.stiffness(block_place_[i]);
        summary_.reused_blocks = block_place_.size() - fresh.size();
        compare(sample, l_ii, summary_.checks);
        clock_.end("blocks");
        return l_ii;
    }

    void write_columns(SpreadSolver& solver, const Nodes& node, const Nodes& row,
                       const std::vector<Eigen::Matrix3d>& l_ii, const Sample& sample, const fs::path& beside) {
        progress_.stage("columns");
        const ColumnFormat format = format_of(scene_, l_ii);
        summary_.column_precision = "double";
        summary_.column_format = scene_.tables.column_precision;
        summary_.column_unit_m_per_n = format.unit_m_per_n;
        const fs::path file = beside / "columns.npy", folder = work_folder(folder_);
        const ColumnWork work = column_work(node, row);
        summary_.reused_columns = node.size() - work.node.size();
        const std::uint64_t key = hash_work(scene_, summary_, work.node, row);
        summary_.resumed_columns =
            solver.write_columns({folder, key, node.size(), work.node, work.place.node, row, format}, progress_);
        fs::rename(folder / "columns.npy", file);
        fs::remove_all(folder);
        if (summary_.reused_columns > 0) {
            ColumnFile columns(file, node.size(), row.size(), format, true);
            earlier_.copy_columns(body_.touch_node, column_place_, rows_of(scene_, body_), columns);
        }
        const ColumnReader columns(file, format);
        for (std::size_t c = 0; c < sample.place.size(); ++c)
            summary_.checks.largest_column_difference = std::max(summary_.checks.largest_column_difference,
                                                                 columns.difference(sample.place[c], sample.column[c]));
        clock_.end("columns");
    }

    bool has_mask() const { return scene_.contact.force == "pressure-mask"; }

    void find_mask_pairs() {
        if (!has_mask()) return;
        masks_ = make_masks(body_.mesh.position_m, body_.touch_patch, scene_.contact.mask_radius_m);
        mask_pair_ = mask_pairs(masks_, body_.touch_patch, body_.unknown);
        clock_.end("masks");
    }

    /// The pressure mask's tables. find: the blocks of pairs.
    template <typename Find>
    void make_mask(Find find, const fs::path& beside) {
        if (!has_mask()) return;
        progress_.stage("mask");
        summary_.mask_pairs = mask_pair_.size();
        write_mask(masks_, compute_mask_compliance(masks_, body_.touch_patch, body_.unknown, find()), beside,
                   write_blocks_, summary_);
        clock_.end("mask");
    }

    std::vector<Eigen::Matrix3d> find_mask_blocks(const Factor& factor, Workers& workers) {
        const CompliancePairs pairs(factor.supernodes(), mask_pair_);
        summary_.mask_method = pairs.method();
        summary_.mask_flops = pairs.flops();
        return pairs.compute(progress_, &workers);
    }

    void before_factor(const Factor& symbolic, const Eigen::SparseMatrix<double>& k, const Nodes& node,
                       const Nodes& row, const Workers& workers, const fs::path& beside) {
        summary_.memory = foresee(symbolic, k, block_work(), workers);
        if (has_mask())
            summary_.memory.pairs = CompliancePairs(symbolic.supernodes(), mask_pair_).bytes(workers.count()) +
                                    2.0 * static_cast<double>(mask_pair_.size()) * sizeof(Eigen::Matrix3d);
        if (drawing_ == Drawing::kColumns) {
            const ColumnWork work = column_work(node, row);
            const ColumnSolver columns(symbolic.supernodes(), work.node, work.row);
            summary_.memory.columns = columns.bytes<double>(workers.count());
            if (options_.column_tolerance > 0.0)
                summary_.memory.columns = std::max(summary_.memory.columns, columns.bytes<float>(workers.count()));
        }
        require_memory(scene_.file.string(), summary_.memory,
                       options_.memory_bytes > 0.0 ? options_.memory_bytes : available_memory(),
                       static_cast<double>(body_.free_node.size()));
        if (drawing_ == Drawing::kColumns) require_room("columns.npy", column_bytes(scene_, body_), beside);
        if (drawing_ == Drawing::kSolves) require_room("the factor", factor_file_bytes(symbolic), beside);
        clock_.end("analysis");
        progress_.stage("factor");
    }

    void make_columns(const Factor& factor, const Nodes& node, const Nodes& row,
                      const std::vector<Eigen::Matrix3d>& l_ii, const Sample& sample, Workers& workers,
                      const fs::path& beside) {
        progress_.stage("columns");
        const ColumnFormat format = format_of(scene_, l_ii);
        summary_.column_format = scene_.tables.column_precision;
        summary_.column_unit_m_per_n = format.unit_m_per_n;
        const ColumnWork work = column_work(node, row);
        summary_.reused_columns = node.size() - work.node.size();
        summary_.column_precision =
            column_precision(factor.supernodes(), node, row, sample, options_.column_tolerance, progress_, summary_);
        const ColumnSolver solver(factor.supernodes(), work.node, work.row);
        ColumnStore store(work_folder(folder_), hash_work(scene_, summary_, work.node, work.row), solver, node.size(),
                          row.size(), format, work.place);
        try {
            compute_columns(solver, progress_, workers, store, summary_);
            if (summary_.reused_columns > 0)
                earlier_.copy_columns(body_.touch_node, column_place_, rows_of(scene_, body_), store.file());
            for (std::size_t c = 0; c < sample.place.size(); ++c)
                summary_.checks.largest_column_difference = std::max(
                    summary_.checks.largest_column_difference, store.difference(sample.place[c], sample.column[c]));
            store.publish(beside / "columns.npy");
        } catch (const Error&) {
            store.discard();
            throw;
        }
    }

    /// The other tables; the tables as C; then the summary again, with sizes and times.
    void write(const fs::path& beside) {
        progress_.stage("write");
        write_tables(scene_, body_, beside);
        write_blocks_(beside / "stiffness.npy", {stiffness_.size(), 3, 3}, stiffness_);
        write_file(beside / "summary.json", to_json(scene_, body_, summary_));
        clock_.end("write");
        progress_.stage("codegen");
        summary_.size = generate_model(beside);
        clock_.end("codegen");
        for (const fs::path& file : files_in(beside)) {
            summary_.bytes.emplace_back(file.filename(), fs::file_size(file));
            summary_.hashes.emplace_back(file.filename(), hash_file(file));
        }
        write_file(beside / "summary.json", to_json(scene_, body_, summary_));
    }

    const Scene& scene_;
    const fs::path& folder_;
    Progress& progress_;
    const PrecomputeOptions& options_;
    Result& result_;
    const Body& body_ = result_.body;
    Summary& summary_ = result_.summary;
    StageClock clock_{summary_};
    Drawing drawing_ = Drawing::kNone;
    std::vector<Eigen::Matrix3d> stiffness_;
    WriteBlocks write_blocks_ = writer_of(options_.solver);
    Masks masks_;
    std::vector<NodePair> mask_pair_;
    EarlierTables earlier_;
    Nodes block_place_, column_place_;  // [n] of the table's nodes in the earlier one, -1 where that has not got it
};

}  // namespace

fs::path work_folder(const fs::path& folder) { return plain_folder(folder).concat(".columns"); }

Result precompute(const Scene& scene, const fs::path& folder_in, Progress& progress, const PrecomputeOptions& options) {
    const fs::path folder = plain_folder(folder_in);
    Result result;
    Run(scene, folder, progress, options, result).compute();
    return result;
}

}  // namespace haptable
