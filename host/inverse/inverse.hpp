// SPDX-License-Identifier: GPL-2.0-or-later
// What precompute asks of K^-1. Two answer: the factor of this process, and one that is spread over many (host/mpi).
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "host/base/progress.hpp"

namespace haptable {

struct NodePair;
struct Summary;

/// What columns.npy holds: entries as float, or as Half in units of `unit_m_per_n`, a power of 2.
struct ColumnFormat {
    bool half = false;
    double unit_m_per_n = 1.0;
};

/// Columns to be solved for and written into columns.npy of a folder that outlives a run that is cut short.
struct ColumnTask {
    std::filesystem::path folder;
    std::uint64_t key = 0;               ///< of all that decides the entries; another key's work is thrown away
    std::size_t node_count = 0;          ///< of the table
    std::span<const std::int32_t> node;  ///< unknown nodes that are wanted
    std::span<const std::size_t> place;  ///< theirs in the table
    std::span<const std::int32_t> row;   ///< [r] unknown nodes: all rows of the table
    ColumnFormat format;
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
};

/// A solver whose factor is nowhere whole: it gives the wanted parts of L = K^-1 itself.
class SpreadSolver : public LinearSolver {
public:
    /// k: symmetric with both triangles stored, three rows a node. Fills in the summary's factor, memory and method.
    /// Throws Error where the factor does not fit or k is not positive definite.
    virtual void factorize(const Eigen::SparseMatrix<double>& k, Summary& summary) = 0;
    /// L_ij in m/N of pairs of unknown nodes (row i, column j), no pair twice.
    virtual std::vector<Eigen::Matrix3d> blocks(std::span<const NodePair> wanted) = 0;
    /// Makes the file with the columns of the nodes: L_ri of all rows r. Entries of other nodes are left open. Returns
    /// how many columns were there already, finished by a run of the same key.
    virtual std::size_t write_columns(const ColumnTask& task, Progress& progress) = 0;
    /// Writes a .npy file of float64, each process its slice. values: product of the shape many, a multiple of 9.
    virtual void write_blocks(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
                              std::span<const double> values) = 0;
    /// Processor time and peak memory of every process so far.
    virtual void report(Summary& summary) = 0;
};

}  // namespace haptable
