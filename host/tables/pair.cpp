// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/pair.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <span>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

template <std::size_t k>
void write_rows(const fs::path& path, const std::vector<std::size_t>& shape,
                const std::vector<std::array<double, k>>& rows) {
    const double* first = rows.empty() ? nullptr : rows.front().data();
    write_npy<double>(path, shape, std::span<const double>(first, k * rows.size()));
}

template <std::size_t k>
std::vector<std::array<double, k>> read_rows(const fs::path& path, std::size_t count) {
    const Array<double> array = read_npy<double>(path);
    if (array.values.size() != k * count)
        throw Error(fmt::format("{}: has {} numbers where {} belong: make the tables again", path.string(),
                                array.values.size(), k * count));
    std::vector<std::array<double, k>> rows(count);
    for (std::size_t i = 0; i < array.values.size(); ++i) rows[i / k][i % k] = array.values[i];
    return rows;
}

/// Near pairs as they stand in a row: ascending, and none above the diagonal.
void check_near(const fs::path& path, const PairTables& tables) {
    for (std::size_t k = 0; k < tables.control_count; ++k)
        for (std::uint32_t i = tables.near_begin[k]; i < tables.near_begin[k + 1]; ++i)
            if (tables.near[i] < 0 || static_cast<std::size_t>(tables.near[i]) > k ||
                (i > tables.near_begin[k] && tables.near[i - 1] >= tables.near[i]))
                throw Error(fmt::format("{}: entry {} is out of order: make the tables again", path.string(), i));
}

void read_low_rank(const fs::path& folder, PairTables& tables) {
    for (const std::int32_t begin : read_npy<std::int32_t>(folder / "coupling_begin.npy").values)
        tables.near_begin.push_back(static_cast<std::uint32_t>(begin));
    tables.near = read_npy<std::int32_t>(folder / "coupling_near.npy").values;
    bool ascends = tables.near_begin.size() == tables.control_count + 1 && tables.near_begin.front() == 0 &&
                   tables.near_begin.back() == tables.near.size();
    for (std::size_t k = 0; ascends && k < tables.control_count; ++k)
        ascends = tables.near_begin[k] <= tables.near_begin[k + 1];
    if (!ascends)
        throw Error((folder / "coupling_begin.npy").string() +
                    ": does not fit coupling_near.npy: make the tables "
                    "again");
    check_near(folder / "coupling_near.npy", tables);
    tables.block = read_rows<9>(folder / "coupling.npy", tables.near.size());
    tables.column = read_rows<3>(folder / "coupling_far.npy", tables.control_count * tables.rank);
}

}  // namespace

std::size_t pair_bytes(const PairTables& tables) {
    if (tables.is_exact()) return 36 * tables.block.size();
    return 20 * tables.near.size() + 4 * tables.near_begin.size() + 6 * tables.column.size();
}

void write_pair(const PairTables& tables, const fs::path& folder) {
    write_rows(folder / "coupling.npy", {tables.block.size(), 3, 3}, tables.block);
    if (tables.is_exact()) return;
    const std::vector<std::int32_t> begin(tables.near_begin.begin(), tables.near_begin.end());
    write_npy<std::int32_t>(folder / "coupling_begin.npy", {begin.size()}, begin);
    write_npy<std::int32_t>(folder / "coupling_near.npy", {tables.near.size()}, tables.near);
    write_rows(folder / "coupling_far.npy", {tables.control_count, tables.rank, 3}, tables.column);
}

std::optional<PairTables> read_pair(const fs::path& folder) {
    using nlohmann::json;
    const fs::path path = folder / "summary.json";
    try {
        const json contact = parse_json(read_file(path)).at("contact");
        if (contact.value("fingers", 1) == 1) return {};
        const json& pair = contact.at("pair");
        PairTables tables;
        pair.at("meeting_m").get_to(tables.meeting_m);
        pair.at("controls").get_to(tables.control_count);
        pair.at("rank").get_to(tables.rank);
        const std::size_t n = tables.control_count;
        if (tables.is_exact())
            tables.block = read_rows<9>(folder / "coupling.npy", n * (n + 1) / 2);
        else
            read_low_rank(folder, tables);
        return tables;
    } catch (const json::exception& error) {
        throw Error(path.string() + ": is not a summary of haptable-precompute (" + error.what() +
                    "): make the tables again");
    }
}

}  // namespace haptable
