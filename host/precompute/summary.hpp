// SPDX-License-Identifier: GPL-2.0-or-later
// What a run of precompute tells: summary.json, and a table for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "codegen/size.hpp"
#include "host/body/gravity.hpp"
#include "host/body/locking.hpp"
#include "host/body/small_strain.hpp"
#include "host/body/stiffening_fit.hpp"
#include "host/body/under_constrained.hpp"
#include "host/compliance/modes.hpp"
#include "host/compliance/pair_coupling.hpp"
#include "host/inverse/inverse.hpp"
#include "host/mesh/audit.hpp"
#include "host/precompute/identity.hpp"
#include "host/precompute/press.hpp"
#include "host/precompute/stage_clock.hpp"

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
    double scaled_condition = 0.0;             ///< of K scaled to a diagonal of 1, 2-norm: what costs digits
    double smallest_pivot_ratio = 0.0;         ///< l_jj^2 / k_jj of the factor, or a bound from below
};

/// columns.npy and how it was found.
struct ColumnSummary {
    std::string format;         ///< of the entries: "float32" or "float16"; empty without columns
    double unit_m_per_n = 1.0;  ///< of the entries
    double float_error = 0.0;   ///< of the trial: ||float - double|| / ||double||
    ColumnFacts facts;
};

/// How L was found. Of an earlier run of the same body it holds for this one too.
struct InverseSummary {
    FactorFacts factor;
    BlockFacts blocks;
    ColumnSummary columns;
    Checks checks;
    std::optional<SmallStrain> small_strain;
    Locking locking;
    std::optional<GravityFacts> gravity;  ///< of a scene with [gravity]
};

/// The pressure mask's tables.
struct MaskSummary {
    BlockFacts blocks;
    double product_flops = 0.0;  ///< of the products of masks and blocks
    std::size_t pairs = 0;       ///< blocks under masks
    std::size_t most_nodes = 0;  ///< under the mask of any point
    std::size_t widened = 0;     ///< vertices and edges with only their own nodes
    std::size_t places = 0;      ///< vertices and edges
};

/// One line of Checks.
struct Check {
    const char *key, *text;  ///< in both files, for people
    double Checks::*value;
};
inline constexpr Check kChecks[] = {
    {"largest_residual", "largest ||K x - b|| / ||b||", &Checks::largest_residual},
    {"largest_block_difference", "largest difference of L_ii to solves", &Checks::largest_block_difference},
    {"largest_column_difference", "largest difference of columns to solves", &Checks::largest_column_difference},
    {"largest_asymmetry", "largest asymmetry of L", &Checks::largest_asymmetry},
    {"smallest_eigenvalue_m_per_n", "smallest eigenvalue of any L_ii (m/N)", &Checks::smallest_eigenvalue_m_per_n},
    {"largest_block_condition", "largest condition of any L_ii", &Checks::largest_block_condition},
    {"condition_estimate", "condition of K, estimated", &Checks::condition_estimate},
    {"scaled_condition", "the same with K scaled to a diagonal of 1", &Checks::scaled_condition},
    {"smallest_pivot_ratio", "smallest pivot / diagonal of K", &Checks::smallest_pivot_ratio}};

/// What couples two fingers.
struct PairSummary {
    PairSummary(const PairTables& tables, const PairError& error);
    double meeting_m;
    std::size_t controls;   ///< places that a patch's corners and edges are
    std::size_t clustered;  ///< places in clusters; 0: every pair of controls is kept
    std::size_t loads;      ///< entries of what patches load of them; 0: places are controls
    std::size_t dense;      ///< pairs of clusters that are kept in full
    std::size_t cores;      ///< of so many
    std::size_t rank;       ///< of the others, at most
    std::size_t bytes;
    PairError error;
};

/// What an earlier run gave.
struct Reused {
    bool all = false;                     ///< all blocks and columns: nothing was computed
    std::size_t blocks = 0, columns = 0;  ///< nodes whose L_ii, whose columns it gave
};

struct WrittenFile {
    std::string name;
    std::uintmax_t bytes = 0;
    std::string hash;  ///< XXH3
};

struct Summary {
    Identity identity;
    Audit audit;
    std::vector<Support> supports;  ///< by body
    MemoryNeed memory;              ///< foreseen
    InverseSummary inverse;
    MaskSummary mask;
    std::optional<PairSummary> pair;  ///< of two fingers
    std::optional<ModeFacts> body_modes;
    std::optional<StiffeningFit> stiffening;
    std::vector<Eigen::Vector3d> sag_m;  ///< [N] under the body's own weight; empty without [gravity]
    Reused reused;
    std::vector<ProcessCost> processes;  ///< where there are many
    ModelSize size;                      ///< of the servo's tables
    std::vector<StageCost> stages;       ///< in order
    std::vector<WrittenFile> files;      ///< in order of name
};

/// The text of summary.json: facts_of() and what only people and scripts ask for.
std::string summary_text(nlohmann::ordered_json facts, const Scene& scene, const Body& body, const Summary& summary);

/// Digits of the force that are lost, and what the body's weight does to it.
std::vector<std::string> run_warnings(const Scene& scene, const Summary& summary);

/// A short table for people: counts, checks, bytes by table, time by stage. press: of the same tables.
std::string to_table(const Scene& scene, const Body& body, const Summary& summary, const PressStiffness& press);

}  // namespace haptable
