// SPDX-License-Identifier: GPL-2.0-or-later
// columns.npy while it is made: in a folder of its own that outlives a crash or Ctrl-C, with a journal of what is done.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

#include "host/precompute/column_solver.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

/// What columns.npy holds: entries as float, or as Half in units of `unit_m_per_n`, a power of 2.
struct ColumnFormat {
    bool half = false;
    double unit_m_per_n = 1.0;
};

/// Largest ||column - x|| / ||x|| of a finished file, where x is a solved column of node i at the rows: [3 r, 3].
double column_difference(const std::filesystem::path& file, const ColumnFormat& format, std::size_t i,
                         const Eigen::MatrixXd& x);

/// [n, r, 3, 3]: entry [i, k] is L_ri with r = row k, so that u_r = unit * entry F_i (eq. 8). Mapped into memory: what
/// the machine has no room for is on the disk already. A group of columns counts as done when the journal has its hash,
/// and is taken over from an earlier run of the same key when the file still has that hash.
class ColumnStore {
public:
    /// folder: where to work; key: of everything that decides the file's bytes. Another key's work is thrown away.
    ColumnStore(std::filesystem::path folder, std::uint64_t key, const ColumnSolver& solver, std::size_t node_count,
                std::size_t row_count, const ColumnFormat& format);
    /// Leaves the folder where a group is done, for the next run.
    ~ColumnStore();
    ColumnStore(const ColumnStore&) = delete;
    ColumnStore& operator=(const ColumnStore&) = delete;

    /// Puts blocks into the file and writes the journal.
    ColumnSolver::Sink sink();
    /// Largest ||column - x|| / ||x|| where x is a solved column of node i at the rows: [3 r, 3].
    double difference(std::size_t i, const Eigen::MatrixXd& x) const;
    std::size_t kept_groups() const { return kept_; }  ///< taken over from an earlier run
    /// Renames the file to its place; the folder goes.
    void publish(const std::filesystem::path& file);
    /// The folder goes, whatever is done.
    void discard();

private:
    void put(std::size_t i, std::size_t k, const Eigen::Matrix3f& l_ri);
    float at(std::size_t entry) const;
    std::uint64_t hash_of(std::size_t group) const;
    void read_journal(std::uint64_t key);
    void write_journal(std::size_t group);

    std::filesystem::path folder_;
    const ColumnSolver& solver_;
    std::size_t row_count_;
    float per_unit_ = 1.0F, unit_ = 1.0F;
    std::optional<WritableNpy<float>> single_;
    std::optional<WritableNpy<Half>> half_;
    std::vector<char> done_;  // [groups]
    std::size_t kept_ = 0;
    std::ofstream journal_;
};

}  // namespace haptable
