// SPDX-License-Identifier: GPL-2.0-or-later
// Chosen 3x3 blocks of L = K^-1, in the factor's pattern or not, by whatever needs the fewest operations.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/inverse/factor.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/inverse/solve/tree_solver.hpp"

namespace haptable {

/// How blocks that selected inversion does not give are found.
enum class PairSolve {
    kPaths,   ///< L_ij = (L^-1 E_i)^T S (L^-1 E_j): forward solves along the nodes' paths to the root, and products
    kSolves,  ///< pruned solves: forward along the path of the earlier node, back along that of the later
};

/// Plans from the factor's pattern alone: pairs in the pattern by selected inversion and the others by solves, or all
/// by solves; counted operations decide. Nodes are taken kGroup at a time, neighbours in the elimination tree together.
class CompliancePairs {
public:
    /// wanted: pairs of unknown nodes, in any order, each as often as one likes. `only` forces solves of that kind for
    /// all of them (for tests and measurements).
    CompliancePairs(const Supernodes& factor, std::span<const NodePair> wanted, std::optional<PairSolve> only = {});

    /// L_ij in m/N for every wanted pair (row i, column j), in the order asked for, in double. L_ii comes out symmetric
    /// to the last bit, and the number of workers changes none.
    std::vector<Eigen::Matrix3d> compute(Progress& progress, Workers* workers = nullptr) const;

    double flops() const { return flops_; }  ///< multiplications and additions of compute()
    double bytes(int workers = 1) const;     ///< workspace of compute(), beside the factor and the answer
    std::string method() const;              ///< "selected inversion", "path solves", "selected inversion and ..."

private:
    static constexpr std::size_t kGroup = 128;
    static constexpr double kMostPathBytes = 2e9;  ///< path solves keep groups; beyond this they are not taken

    /// A pair once, the node that is earlier in the tree first: L_(later, earlier).
    struct Unique {
        std::int32_t earlier = 0, later = 0;
    };
    /// Nodes that are solved for together.
    struct Group {
        std::vector<std::int32_t> node;       // in the order of the tree
        std::vector<std::int32_t> path;       // supernodes from them to the root, ascending
        std::vector<std::int32_t> back;       // supernodes from their partners to the root
        std::vector<std::int32_t> all;        // either
        std::vector<std::int32_t> partner;    // groups that hold their later nodes, ascending
        std::vector<std::size_t> pair;        // unique pairs whose earlier node is here
        std::vector<std::size_t> pair_begin;  // [partner + 1] pairs of one partner: `pair` is sorted by partner
    };
    struct Plan {
        std::vector<std::size_t> solved;  // unique pairs that the groups find
        std::vector<Group> group;
        std::vector<std::int32_t> group_of, column_of;  // [unknown nodes] or -1
        PairSolve way = PairSolve::kSolves;
        double flops = 0.0;
        double bytes = 0.0;  // of one worker's solves, or of all groups' paths that are held at once
    };
    void find_unique(std::span<const NodePair> wanted);
    Plan plan(std::vector<std::size_t> solved, std::optional<PairSolve> only) const;
    void make_groups(Plan& plan) const;
    void find_partners(Plan& plan) const;
    void find_paths(Plan& plan) const;
    void choose(Plan& plan, std::optional<PairSolve> only) const;
    int active(const Group& group, std::int32_t s) const;
    double columns_of(std::span<const std::int32_t> supernodes) const;
    double forward_flops(const Group& group) const;
    void forward(const Group& group, std::span<const std::int32_t> room, TreeSolver<double>& x) const;
    void by_solves(Progress& progress, Workers& workers, std::vector<Eigen::Matrix3d>& block) const;
    void solve(const Group& group, TreeSolver<double>& x, std::vector<Eigen::Matrix3d>& block) const;
    void by_paths(Progress& progress, Workers& workers, std::vector<Eigen::Matrix3d>& block) const;
    void multiply(const Group& a, const TreeSolver<double>& x, std::size_t partner, const TreeSolver<double>& y,
                  std::vector<Eigen::Matrix3d>& block) const;

    Supernodes factor_;
    EliminationTree tree_;
    std::vector<Unique> unique_;
    std::vector<std::size_t> unique_of_;  // [wanted]
    std::vector<char> transposed_;        // [wanted]
    std::vector<std::size_t> inverted_;   // unique pairs by selected inversion
    std::optional<SelectedInversion> inversion_;
    Plan plan_;
    double flops_ = 0.0;
};

}  // namespace haptable
