// SPDX-License-Identifier: GPL-2.0-or-later
// L = K^-1 in this process: CHOLMOD's factor, selected inversion of it, pruned solves with it.
#pragma once

#include "host/base/workers.hpp"
#include "host/inverse/factor.hpp"

namespace haptable {

/// A K that comes again, as of one body in another mode, is neither ordered nor factorised again.
class CholmodInverse : public Inverse {
public:
    /// threads: 0: all processors, one for less than 10,000 nodes.
    explicit CholmodInverse(int threads = 0) : threads_(threads) {}

    MemoryNeed analyse(const Stiffness& k, const InverseRequest& request) override;
    FactorFacts factorize(const Stiffness& k, Progress& progress) override;
    Eigen::Index size() const override { return factor_->size(); }
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override { factor_->solve(b, x); }
    /// Pairs in the factor's pattern by selected inversion; with others among them, in double by what needs the fewest
    /// operations (pairs.hpp).
    Blocks blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) override;
    std::unique_ptr<Columns> columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                     Precision precision) override;
    bool is_distributed() const override { return false; }
    std::optional<Supernodes> whole_factor() const override { return factor_->supernodes(); }

private:
    bool in_pattern(std::span<const NodePair> wanted) const;

    int threads_;
    std::optional<Workers> workers_;
    std::optional<Factor> factor_;
    std::uint64_t of_ = 0;  ///< the hash of its K
    bool is_factorized_ = false;
};

}  // namespace haptable
