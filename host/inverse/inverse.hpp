// SPDX-License-Identifier: GPL-2.0-or-later
// What is asked of L = K^-1. Two answer: CholmodInverse in this process, DistributedInverse (host/precompute/mpi) over
// many. Neither knows scenes, files or the report: they return facts and fill sinks.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/base/process_cost.hpp"
#include "host/base/progress.hpp"
#include "host/inverse/memory.hpp"
#include "host/inverse/solve/supernodes.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable {

enum class Precision { kDouble, kFloat };

/// Asks for the block L_ij of unknown nodes i (row) and j (column): rows 3 i .. 3 i + 2 of K, columns 3 j .. 3 j + 2.
struct NodePair {
    std::int32_t row = 0;
    std::int32_t column = 0;
};

/// What will be asked for once K is factorised: it decides how much memory that takes.
struct InverseRequest {
    std::vector<std::span<const NodePair>> blocks;  ///< of each call of blocks()
    std::span<const std::int32_t> node, row;        ///< of columns()
    bool float_columns = false;                     ///< which may be asked for in float
    int right_sides = 0;                            ///< of a call of solve()
};

/// The least pivot l_jj^2, as a fraction of k_jj; 0 where the factorisation stopped at that row.
struct Pivot {
    Eigen::Index row = 0;  ///< of K
    double ratio = 0.0;
};

struct FactorFacts {
    std::string ordering;
    double fill = 0.0;             ///< nonzeros of the factor
    double flops = 0.0;            ///< of the factorisation
    int threads = 1;               ///< of this process
    std::optional<Pivot> weakest;  ///< none: the solver does not tell
};

struct BlockFacts {
    std::string method = "selected inversion";
    Precision precision = Precision::kDouble;  ///< that was computed in
    double flops = 0.0;                        ///< multiplications and additions; 0 where the solver does not tell
};

struct Blocks {
    std::vector<Eigen::Matrix3d> l_ij;  ///< m/N, in the order asked for
    BlockFacts facts;
};

struct ColumnFacts {
    Precision precision = Precision::kDouble;
    double flops = 0.0;       ///< multiplications and additions for all groups; 0 where the solver does not tell
    double flops_done = 0.0;  ///< of those that were computed
    std::size_t resumed = 0;  ///< columns that the sink had already
};

class LinearSolver {
public:
    LinearSolver() = default;
    virtual ~LinearSolver() = default;
    LinearSolver(const LinearSolver&) = delete;
    LinearSolver& operator=(const LinearSolver&) = delete;

    virtual Eigen::Index size() const = 0;
    /// x = K^-1 b for many right-hand sides at once: b and x [size(), m].
    virtual void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const = 0;
    /// b -> what of it K x is equal to: all, where L is K^-1 itself.
    virtual void balance(Eigen::MatrixXd&) const {}
};

/// Columns of L at chosen rows, planned: n nodes, r rows, in groups. A group's blocks are its own, no other gives them.
class Columns {
public:
    using Visit = std::function<void(std::size_t c, std::size_t k)>;
    /// Where the blocks go.
    struct Sink {
        /// Takes L_ri = `block` (m/N) with r = row[k] and i = node[c]. Called by several threads at once.
        std::function<void(std::size_t c, std::size_t k, const Eigen::Matrix3f& block)> take;
        std::function<void(std::size_t group)> done;  ///< all blocks of a group are taken; one call at a time
        std::function<bool(std::size_t group)> have;  ///< true: the group is not computed; asked before any work
    };

    Columns() = default;
    virtual ~Columns() = default;
    Columns(const Columns&) = delete;
    Columns& operator=(const Columns&) = delete;

    virtual std::size_t group_count() const = 0;
    /// Calls visit(c, k) for every block that a group gives, in a fixed order.
    virtual void for_each_block(std::size_t group, const Visit& visit) const = 0;
    /// Computes every block that the sink has not got, each once. The inverse must live on.
    virtual ColumnFacts compute(Progress& progress, const Sink& sink) const = 0;
};

/// Called in this order: analyse(), factorize(), then the others as often as one likes. In one process the number of
/// threads changes no bit of what they give.
class Inverse : public LinearSolver {
public:
    /// Orders K and finds the factor's pattern, or what the solver has in its place. Returns what the machine (of many:
    /// the fullest) will need and has. Throws Error where K is too large to number.
    virtual MemoryNeed analyse(const Stiffness& k, const InverseRequest& request) = 0;
    /// k: that of analyse(); it may go afterwards. Nothing may be asked where the weakest pivot is zero.
    virtual FactorFacts factorize(const Stiffness& k, Progress& progress) = 0;
    /// L_ij of pairs of unknown nodes, in the factor's pattern or not.
    virtual Blocks blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) = 0;
    /// node: [n] unknown nodes whose columns are wanted; row: [r] unknown nodes whose rows are. No node twice.
    virtual std::unique_ptr<Columns> columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                             Precision precision) = 0;

    /// Over many processes all is in double, whatever is asked for, and none has the factor.
    virtual bool is_distributed() const = 0;
    /// From analyse() on, where this process has it.
    virtual std::optional<Supernodes> whole_factor() const { return {}; }
    /// What each process took so far, where there are many.
    virtual std::vector<ProcessCost> processes() const { return {}; }
};

}  // namespace haptable
