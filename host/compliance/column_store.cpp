// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/compliance/column_store.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/hash.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

/// Hashes by group, of a journal that begins with this line.
std::map<std::size_t, std::uint64_t> read_journal(const fs::path& file, const std::string& first_line) {
    std::map<std::size_t, std::uint64_t> found;
    std::ifstream in(file);
    std::string line;
    if (!std::getline(in, line) || line != first_line) return found;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        std::size_t group = 0;
        std::uint64_t hash = 0;
        if (words >> group >> std::hex >> hash) found.emplace(group, hash);
    }
    return found;
}

}  // namespace

ColumnReader::ColumnReader(const fs::path& file, const ColumnFormat& format)
    : unit_(static_cast<float>(format.unit_m_per_n)) {
    if (format.half)
        half_.emplace(file);
    else
        single_.emplace(file);
}

ColumnFile::ColumnFile(const fs::path& file, std::size_t node_count, std::size_t row_count, const ColumnFormat& format,
                       bool keep)
    : row_count_(row_count),
      per_unit_(static_cast<float>(1.0 / format.unit_m_per_n)),
      unit_(static_cast<float>(format.unit_m_per_n)) {
    const std::vector<std::size_t> shape{node_count, row_count, 3, 3};
    if (format.half)
        half_.emplace(file, shape, keep);
    else
        single_.emplace(file, shape, keep);
}

std::span<const std::byte> ColumnFile::bytes_of_block(std::size_t i, std::size_t k) const {
    const std::size_t first = 9 * (i * row_count_ + k);
    if (half_) return std::as_bytes(std::span<const Half>(half_->values()).subspan(first, 9));
    return std::as_bytes(std::span<const float>(single_->values()).subspan(first, 9));
}

ColumnStore::ColumnStore(fs::path folder, std::uint64_t key, const Columns& columns, std::size_t node_count,
                         std::size_t row_count, const ColumnFormat& format, ColumnPlaces places)
    : folder_(std::move(folder)), columns_(columns), places_(std::move(places)), done_(columns.group_count(), 0) {
    std::error_code failed;
    fs::create_directories(folder_, failed);
    if (failed) throw Error(fmt::format("{}: cannot be written: {}", folder_.string(), failed.message()));
    file_.emplace(folder_ / "columns.npy", node_count, row_count, format, true);
    const std::string first_line = fmt::format("haptable columns 1 {:016x}", key);
    const auto found = read_journal(folder_ / "journal", first_line);
    // Begun anew: a line that a crash cut off must not spoil the next one.
    journal_.open(folder_ / "journal", std::ios::trunc);
    journal_ << first_line << std::endl;
    for (const auto& [group, hash] : found) {
        if (group >= done_.size() || hash_of(group) != hash) continue;
        write_journal(group, hash);
        ++kept_;
    }
}

void ColumnStore::write_journal(std::size_t group, std::uint64_t hash) {
    journal_ << fmt::format("{} {:016x}\n", group, hash) << std::flush;
    done_[group] = 1;
}

ColumnStore::~ColumnStore() {
    const bool any = std::find(done_.begin(), done_.end(), 1) != done_.end();
    if (!any) discard();
}

/// XXH3 over the group's blocks as they are in the file.
std::uint64_t ColumnStore::hash_of(std::size_t group) const {
    Hash hash;
    columns_.for_each_block(
        group, [&](std::size_t c, std::size_t k) { hash.add_bytes(file_->bytes_of_block(node_of(c), row_of(k))); });
    return hash.digest();
}

void ColumnStore::put(std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri) {
    const std::size_t first = 9 * (node_of(c) * file_->row_count() + row_of(k));
    for (std::size_t e = 0; e < 9; ++e)
        file_->set(first + e, l_ri(static_cast<Eigen::Index>(e / 3), static_cast<Eigen::Index>(e % 3)));
}

Columns::Sink ColumnStore::sink() {
    Columns::Sink sink;
    sink.take = [this](std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri) { put(c, k, l_ri); };
    sink.have = [this](std::size_t group) { return done_[group] != 0; };
    sink.done = [this](std::size_t group) { write_journal(group, hash_of(group)); };
    return sink;
}

double ColumnStore::difference(std::size_t i, const Eigen::MatrixXd& x) const {
    const std::size_t first = 3 * i * static_cast<std::size_t>(x.rows());
    double squared = 0.0;
    for (Eigen::Index e = 0; e < 3 * x.rows(); ++e) {
        const auto stored = static_cast<double>(file_->at(first + static_cast<std::size_t>(e)));
        squared += std::pow(stored - x(e / 3, e % 3), 2);
    }
    return std::sqrt(squared) / x.norm();
}

void ColumnStore::publish(const fs::path& file) {
    std::error_code failed;
    fs::rename(folder_ / "columns.npy", file, failed);
    if (failed) throw Error(fmt::format("{}: cannot be written: {}", file.string(), failed.message()));
    discard();
}

void ColumnStore::discard() {
    journal_.close();
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    std::fill(done_.begin(), done_.end(), 0);
}

}  // namespace haptable
