// SPDX-License-Identifier: GPL-2.0-or-later
// L = K^-1 over the processes of a run: rank 0 leads, and asks as of any Inverse; the others serve.
#pragma once

#include <mpi.h>

#include "host/inverse/inverse.hpp"
#include "host/inverse/mpi/mumps.hpp"

namespace haptable {

/// All calls but serve() are rank 0's. Each begins with a task that is sent to the others, so that an Error between two
/// tasks, or Ctrl-C, leaves nobody waiting. What is found comes to rank 0, which writes it; the others need no files.
class DistributedInverse : public Inverse {
public:
    explicit DistributedInverse(MPI_Comm communicator);
    ~DistributedInverse() override;  ///< rank 0 sends the others home

    bool leads() const { return rank_ == 0; }
    /// What the other ranks do until rank 0 is done.
    void serve();

    MemoryNeed analyse(const Stiffness& k, const InverseRequest& request) override;
    FactorFacts factorize(const Stiffness& k, Progress& progress) override;
    Eigen::Index size() const override { return size_; }
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;
    Blocks blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) override;
    std::unique_ptr<Columns> columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                     Precision precision) override;
    bool is_distributed() const override { return true; }
    std::vector<ProcessCost> processes() const override;

private:
    enum class Task : int { kAnalyse, kFactorise, kSolve, kInvert, kRows, kColumns, kReport, kStop };
    class RankColumns;
    /// Takes the three columns of a group's c-th node at the wanted rows: [3 r, 3], m/N.
    using TakeColumn = std::function<void(std::size_t c, const Eigen::MatrixX3f& column)>;

    void begin(Task task) const;
    Task wait() const;
    void take_part(Task task);
    std::vector<double> gather(double own) const;
    MemoryNeed need_of_fullest_machine() const;
    void share_rows(std::vector<std::int32_t> row);
    void solve_columns(std::vector<std::int32_t> node, const TakeColumn& take);

    MPI_Comm communicator_;
    int rank_ = 0, ranks_ = 1;
    mutable Mumps mumps_;
    Eigen::Index size_ = 0;                   // rank 0's: rows of K, the first of M
    std::vector<std::int32_t> place_of_row_;  // [rows of M] 3 k + component of a wanted row, or -1
    Eigen::Index wanted_rows_ = 0;            // 3 r
};

}  // namespace haptable
