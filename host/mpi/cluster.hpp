// SPDX-License-Identifier: GPL-2.0-or-later
// The processes of a run: rank 0 leads it and is the SpreadSolver of precompute(), the others serve.
#pragma once

#include <mpi.h>

#include <string>

#include "host/inverse/inverse.hpp"
#include "host/mpi/mumps.hpp"
#include "host/precompute/column_store.hpp"

namespace haptable {

/// All calls but serve() are rank 0's. Each begins with a task that is sent to the others, so that an Error between two
/// tasks, or Ctrl-C, leaves nobody waiting.
class Cluster : public SpreadSolver {
public:
    explicit Cluster(MPI_Comm communicator);
    ~Cluster() override;  ///< rank 0 sends the others home

    bool leads() const { return rank_ == 0; }
    /// What the other ranks do until rank 0 is done.
    void serve();

    Eigen::Index size() const override { return mumps_.size(); }
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;
    void factorize(const Eigen::SparseMatrix<double>& k, Summary& summary) override;
    std::vector<Eigen::Matrix3d> blocks(std::span<const NodePair> wanted) override;
    std::size_t write_columns(const ColumnTask& task, Progress& progress) override;
    void write_blocks(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
                      std::span<const double> values) override;
    void report(Summary& summary) override;

private:
    enum class Task : int { kAnalyse, kFactorise, kSolve, kInvert, kBlocks, kOpen, kColumns, kClose, kReport, kStop };
    /// Nodes of columns that are solved for together.
    static constexpr int kNodesAtOnce = 64;

    void begin(Task task) const;
    Task wait() const;
    void take_part(Task task);
    void agree(const std::string& failed) const;
    double missing_bytes() const;
    std::vector<double> gather(double own) const;
    void open_columns(std::string path, std::vector<std::int32_t> place_of_row, const ColumnFormat& format);
    void write_slice(std::string path, std::int64_t header_bytes, std::span<const double> values);
    std::uint64_t solve_columns(std::vector<std::int32_t> place, std::span<const std::int32_t> unknown_node);
    void make_columns(const ColumnTask& task);
    std::vector<std::int32_t> order_along_tree(std::span<const std::int32_t> node) const;
    void find_senders();
    std::vector<float> exchange(int own_nodes, int count) const;
    std::string write(std::span<const float> received, std::span<const std::int32_t> own_place);
    void close_columns();
    int nodes_of(int rank, int count) const { return (count - rank + ranks_ - 1) / ranks_; }

    MPI_Comm communicator_;
    int rank_ = 0, ranks_ = 1;
    mutable Mumps mumps_;
    // While columns are written:
    MPI_File file_ = MPI_FILE_NULL;
    ColumnFormat format_;
    MPI_Offset header_bytes_ = 0;
    std::size_t row_count_ = 0;
    std::uint64_t written_hash_ = 0;          // of the group's own columns
    std::vector<std::int32_t> place_of_row_;  // [unknowns] 3 k + component of a wanted row, or -1
    std::vector<std::int32_t> own_row_;       // places in the local solution of wanted rows
    std::vector<std::int32_t> sent_row_;      // 3 k + component, rank by rank
    std::vector<int> sent_count_;             // [ranks] of them
};

}  // namespace haptable
