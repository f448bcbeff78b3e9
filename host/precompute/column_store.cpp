// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/column_store.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

/// ||column - x|| / ||x||, where value(e) is entry e of a column: [r, 3, 3].
template <typename Value>
double distance(const Eigen::MatrixXd& x, Value value) {
    double squared = 0.0;
    for (Eigen::Index e = 0; e < 3 * x.rows(); ++e) {
        const double expected = x(e / 3, e % 3);
        squared += std::pow(static_cast<double>(value(static_cast<std::size_t>(e))) - expected, 2);
    }
    return std::sqrt(squared) / x.norm();
}

}  // namespace

ColumnReader::ColumnReader(const fs::path& file, const ColumnFormat& format)
    : unit_(static_cast<float>(format.unit_m_per_n)) {
    if (format.half)
        half_.emplace(file);
    else
        single_.emplace(file);
}

double ColumnReader::difference(std::size_t i, const Eigen::MatrixXd& x) const {
    const std::size_t first = i * static_cast<std::size_t>(3 * x.rows());
    return distance(x, [&](std::size_t e) { return at(first + e); });
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

ColumnJournal::ColumnJournal(fs::path file, std::uint64_t key)
    : file_(std::move(file)), first_line_(fmt::format("haptable columns 1 {:016x}", key)) {
    std::ifstream in(file_);
    std::string line;
    if (!std::getline(in, line) || line != first_line_) return;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        std::size_t group = 0;
        std::uint64_t hash = 0;
        if (words >> group >> std::hex >> hash) found_.emplace(group, hash);
    }
}

void ColumnJournal::begin() {
    out_.open(file_, std::ios::trunc);
    out_ << first_line_ << std::endl;
}

void ColumnJournal::add(std::size_t group, std::uint64_t hash) {
    out_ << fmt::format("{} {:016x}\n", group, hash) << std::flush;
}

ColumnStore::ColumnStore(fs::path folder, std::uint64_t key, const Columns& columns, std::size_t node_count,
                         std::size_t row_count, const ColumnFormat& format, ColumnPlaces places)
    : folder_(std::move(folder)),
      columns_(columns),
      places_(std::move(places)),
      done_(columns.group_count(), 0),
      journal_(folder_ / "journal", key) {
    std::error_code failed;
    fs::create_directories(folder_, failed);
    if (failed) throw Error(fmt::format("{}: cannot be written: {}", folder_.string(), failed.message()));
    file_.emplace(folder_ / "columns.npy", node_count, row_count, format, true);
    journal_.begin();
    for (const auto& [group, hash] : journal_.found()) {
        if (group >= done_.size() || hash_of(group) != hash) continue;
        done_[group] = 1;
        ++kept_;
        journal_.add(group, hash);
    }
}

ColumnStore::~ColumnStore() {
    const bool any = std::find(done_.begin(), done_.end(), 1) != done_.end();
    if (!any) discard();
}

/// XXH3 over the group's blocks as they are in the file.
std::uint64_t ColumnStore::hash_of(std::size_t group) const {
    XXH3_state_t* state = XXH3_createState();
    XXH3_64bits_reset(state);
    columns_.for_each_block(group, [&](std::size_t c, std::size_t k) {
        const std::span<const std::byte> block = file_->bytes_of_block(node_of(c), row_of(k));
        XXH3_64bits_update(state, block.data(), block.size());
    });
    const std::uint64_t hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return hash;
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
    sink.done = [this](std::size_t group) {
        journal_.add(group, hash_of(group));
        done_[group] = 1;
    };
    return sink;
}

double ColumnStore::difference(std::size_t i, const Eigen::MatrixXd& x) const {
    return distance(x, [&](std::size_t e) { return file_->at(9 * i * file_->row_count() + e); });
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
