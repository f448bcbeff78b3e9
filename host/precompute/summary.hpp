// SPDX-License-Identifier: GPL-2.0-or-later
// What a run of precompute tells: summary.json, and the hash that ties tables, servo and messages together.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codegen/codegen.hpp"
#include "host/inverse/memory.hpp"
#include "host/mesh/audit.hpp"
#include "host/precompute/body.hpp"
#include "host/precompute/loose.hpp"

namespace haptable {

/// Residuals of the checks that every run makes.
struct Checks {
    double largest_residual = 0.0;             ///< ||K x - b|| / ||b|| over the solves
    double largest_block_difference = 0.0;     ///< ||L_ii by inversion - by solves|| / ||L_ii||
    double largest_column_difference = 0.0;    ///< ||column in the file - by solves|| / ||column||
    std::size_t solved_nodes = 0;              ///< that these three and the residual were taken from
    double largest_asymmetry = 0.0;            ///< ||L_ij - L_ji^T|| / sqrt(||L_ii|| ||L_jj||)
    double smallest_eigenvalue_m_per_n = 0.0;  ///< of any L_ii
    double largest_block_condition = 0.0;      ///< of any L_ii, 2-norm
    double condition_estimate = 0.0;           ///< of K, 2-norm
    double smallest_pivot_ratio = 0.0;         ///< l_jj^2 / k_jj of the factor
};

struct Summary {
    std::uint64_t model_hash = 0;
    std::uint64_t body_hash = 0;      ///< of what decides the factor: mesh, held nodes, material
    bool reused = false;              ///< all blocks and columns come from an earlier run of the same body
    std::size_t resumed_columns = 0;  ///< of a run that was cut short, where a SpreadSolver worked
    std::size_t reused_blocks = 0, reused_columns = 0;  ///< nodes whose L_ii, whose columns do
    int threads = 1;
    std::string drawing;  ///< "columns", "solves" (columns are over the budget, the factor is kept) or "none"
    Audit audit;
    std::vector<Hold> holds;  ///< by body
    double tolerance = 0.0;   ///< as asked for
    double column_tolerance = 0.0;
    MemoryNeed memory;  ///< foreseen, bytes
    Checks checks;
    std::string ordering;
    double fill = 0.0;   ///< nonzeros of the factor
    double flops = 0.0;  ///< of the factorisation
    std::string block_method = "selected inversion";
    double block_flops = 0.0;        ///< of the selected inversion
    std::string block_precision;     ///< it was computed in: "double" or "float"
    double column_flops = 0.0;       ///< of the pruned solves; 0 without columns
    double column_flops_done = 0.0;  ///< in this run: less where it went on from another
    std::size_t mask_pairs = 0;      ///< blocks under masks; 0 without
    std::string mask_method;         ///< how they were found; empty under MPI
    double mask_flops = 0.0;
    std::size_t mask_most_nodes = 0;                            ///< under a pressure mask; 0 without
    std::size_t mask_widened = 0;                               ///< vertices and edges with only their own nodes
    std::size_t mask_places = 0;                                ///< vertices and edges
    std::string column_precision;                               ///< as block_precision; empty without columns
    double float_column_error = 0.0;                            ///< of the trial: ||float - double|| / ||double||
    std::string column_format;                                  ///< "float32" or "float16"; empty without columns
    double column_unit_m_per_n = 1.0;                           ///< of the entries in columns.npy
    std::vector<double> rank_cpu_s, rank_peak_bytes;            ///< by process, where a SpreadSolver worked
    ModelSize size;                                             ///< of the servo's tables
    std::vector<std::pair<std::string, double>> time_s;         ///< by stage, in order
    std::vector<std::pair<std::string, double>> cpu_s;          ///< of all threads, by stage
    std::vector<std::pair<std::string, double>> peak_bytes;     ///< largest resident set so far, at a stage's end
    std::vector<std::pair<std::string, std::uintmax_t>> bytes;  ///< by table, in order of name
    std::vector<std::pair<std::string, std::string>> hashes;    ///< XXH3 of the files
};

/// Adds the time of each stage to a summary.
class StageClock {
public:
    explicit StageClock(Summary& summary);
    /// Ends the stage that ran since the last call.
    void end(const std::string& stage);

private:
    Summary& summary_;
    std::chrono::steady_clock::time_point begin_;
    double cpu_begin_s_;
};

/// XXH3 (64 bits) of all that decides the tables: version, mesh, held nodes, touchable patches, material, contact and
/// table options and the force limit. Names, paths and times are not in it: equal content gives equal hashes.
std::uint64_t hash_model(const Scene& scene, const Body& body);

/// XXH3 of what decides K and its factor.
std::uint64_t hash_body(const Scene& scene, const Body& body);

/// XXH3 of all that decides what is solved for columns.npy, and how: nodes and rows are unknowns.
std::uint64_t hash_work(const Scene& scene, const Summary& summary, std::span<const std::int32_t> node,
                        std::span<const std::int32_t> row);

/// XXH3 of a file's bytes, 16 hex digits; empty where it cannot be read.
std::string hash_file(const std::filesystem::path& path);

/// Fills in what an earlier run found, its tolerances too, where the folder holds, complete and undamaged, tables of
/// the same body, made by the same program.
bool restore(const std::filesystem::path& folder, Summary& summary);

/// True where the folder holds, complete, what this program would compute: summary.json names the same content
/// (model_hash), scene, tolerance and program (its own bytes), and every file has the size and the hash that it gives.
bool is_current(const std::filesystem::path& folder, const Scene& scene, const Summary& expected);

/// How each body is held: [{nodes, tetrahedra, held_nodes, held}].
nlohmann::ordered_json to_json(const std::vector<Hold>& holds);

/// The text of summary.json.
std::string to_json(const Scene& scene, const Body& body, const Summary& summary);

/// A short table for people: counts, checks, bytes by table, time by stage.
std::string to_table(const Scene& scene, const Body& body, const Summary& summary);

}  // namespace haptable
