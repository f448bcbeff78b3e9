// SPDX-License-Identifier: GPL-2.0-or-later
// columns.npy while it is made: in a folder of its own that outlives a crash or Ctrl-C, with a journal of what is done.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/inverse/inverse.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

/// What columns.npy holds: entries as float, or as Half in units of `unit_m_per_n`, a power of 2.
struct ColumnFormat {
    bool half = false;
    double unit_m_per_n = 1.0;
};

/// A finished columns.npy: its entries as floats, m/N.
class ColumnReader {
public:
    ColumnReader(const std::filesystem::path& file, const ColumnFormat& format);
    float at(std::size_t entry) const {
        return half_ ? unit_ * to_float(half_->values()[entry]) : single_->values()[entry];
    }

private:
    std::optional<MappedNpy<float>> single_;
    std::optional<MappedNpy<Half>> half_;
    float unit_;
};

/// columns.npy in work, [n, r, 3, 3]: entry [i, k] is L_ri with r = row k, so that u_r = unit * entry F_i (eq. 8).
/// Mapped into memory: what the machine has no room for is on the disk already.
class ColumnFile {
public:
    /// keep: a file of this shape and format keeps its entries.
    ColumnFile(const std::filesystem::path& file, std::size_t node_count, std::size_t row_count,
               const ColumnFormat& format, bool keep);
    std::size_t row_count() const { return row_count_; }
    void set(std::size_t entry, float m_per_n) {
        if (half_)
            half_->values()[entry] = to_half(m_per_n * per_unit_);
        else
            single_->values()[entry] = m_per_n;
    }
    float at(std::size_t entry) const {
        return half_ ? unit_ * to_float(half_->values()[entry]) : single_->values()[entry];
    }
    /// The nine entries of a block as they are in the file.
    std::span<const std::byte> bytes_of_block(std::size_t i, std::size_t k) const;

private:
    std::size_t row_count_;
    float per_unit_, unit_;
    std::optional<WritableNpy<float>> single_;
    std::optional<WritableNpy<Half>> half_;
};

/// Where a solver's nodes and rows stand in the table; empty: it has them all, in the table's order.
struct ColumnPlaces {
    std::vector<std::size_t> node, row;
};

/// A ColumnFile that is filled by an inverse. A group of columns is done when the journal, a text file that a crash
/// cuts off at worst, has its hash; it is taken over from an earlier run of the same key when the file still has that
/// hash.
class ColumnStore {
public:
    /// folder: where to work; key: of everything that decides the file's bytes. Another key's work is thrown away.
    ColumnStore(std::filesystem::path folder, std::uint64_t key, const Columns& columns, std::size_t node_count,
                std::size_t row_count, const ColumnFormat& format, ColumnPlaces places = {});
    /// Leaves the folder where a group is done, for the next run.
    ~ColumnStore();
    ColumnStore(const ColumnStore&) = delete;
    ColumnStore& operator=(const ColumnStore&) = delete;

    /// Puts blocks into the file and writes the journal.
    Columns::Sink sink();
    /// Largest ||column - x|| / ||x|| where x is a solved column of node i at the rows: [3 r, 3].
    double difference(std::size_t i, const Eigen::MatrixXd& x) const;
    ColumnFile& file() { return *file_; }
    std::size_t kept_groups() const { return kept_; }  ///< taken over from an earlier run
    /// Renames the file to its place; the folder goes.
    void publish(const std::filesystem::path& file);
    /// The folder goes, whatever is done.
    void discard();

private:
    std::size_t node_of(std::size_t c) const { return places_.node.empty() ? c : places_.node[c]; }
    std::size_t row_of(std::size_t k) const { return places_.row.empty() ? k : places_.row[k]; }
    void put(std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri);
    std::uint64_t hash_of(std::size_t group) const;
    void write_journal(std::size_t group, std::uint64_t hash);

    std::filesystem::path folder_;
    const Columns& columns_;
    ColumnPlaces places_;
    std::optional<ColumnFile> file_;
    std::vector<char> done_;  // [groups]
    std::size_t kept_ = 0;
    std::ofstream journal_;
};

}  // namespace haptable
