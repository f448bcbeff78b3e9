// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/pair.hpp"

#include <fmt/format.h>

#include <algorithm>
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

template <typename T>
void write_all(const fs::path& path, const std::vector<T>& values) {
    write_npy<T>(path, {values.size()}, values);
}

template <std::size_t k>
void write_steps(const fs::path& path, const std::vector<std::size_t>& shape,
                 const std::vector<std::array<std::int16_t, k>>& rows) {
    const std::int16_t* first = rows.empty() ? nullptr : rows.front().data();
    write_npy<std::int16_t>(path, shape, std::span<const std::int16_t>(first, k * rows.size()));
}

[[noreturn]] void fail(const fs::path& path) {
    throw Error(path.string() + ": does not fit the coupling's other files: make the tables again");
}

template <std::size_t k>
std::vector<std::array<std::int16_t, k>> read_steps(const fs::path& path, std::size_t count) {
    const Array<std::int16_t> array = read_npy<std::int16_t>(path);
    if (array.values.size() != k * count) fail(path);
    std::vector<std::array<std::int16_t, k>> rows(count);
    for (std::size_t i = 0; i < array.values.size(); ++i) rows[i / k][i % k] = array.values[i];
    return rows;
}

template <typename T>
std::vector<T> read_all(const fs::path& path, std::size_t count) {
    std::vector<T> values = read_npy<T>(path).values;
    if (values.size() != count) fail(path);
    return values;
}

std::vector<std::int32_t> read_places(const fs::path& path, std::size_t count, std::size_t places) {
    std::vector<std::int32_t> values = read_all<std::int32_t>(path, count);
    for (const std::int32_t place : values)
        if (place < 0 || static_cast<std::size_t>(place) >= places) fail(path);
    return values;
}

/// What each patch loads: begins ascend, and no patch has more than the servo's room.
void read_loads(const fs::path& folder, PairClusters& to) {
    const fs::path path = folder / "coupling_load_begin.npy";
    to.load_begin = read_npy<std::int32_t>(path).values;
    if (to.load_begin.size() < 2 || to.load_begin.front() != 0) fail(path);
    for (std::size_t p = 0; p + 1 < to.load_begin.size(); ++p)
        if (to.load_begin[p + 1] < to.load_begin[p] ||
            to.load_begin[p + 1] - to.load_begin[p] > static_cast<std::int32_t>(kMostLoaded))
            fail(path);
    const auto count = static_cast<std::size_t>(to.load_begin.back());
    to.load_place = read_places(folder / "coupling_load_place.npy", count, to.places());
    to.load_share = read_steps<6>(folder / "coupling_load_share.npy", count);
}

void read_forms(const fs::path& folder, PairClusters& to) {
    const std::size_t cores = core_count(to.places());
    const fs::path path = folder / "coupling_form.npy";
    to.form = read_all<std::uint8_t>(path, cores);
    for (const std::uint8_t form : to.form)
        if (form < kDenseForm && form > to.rank) fail(path);
    to.step = read_all<float>(folder / "coupling_step.npy", cores);
    to.begin = core_begins(to.form, to.places());
    to.core = read_all<std::int8_t>(folder / "coupling_core.npy", to.begin.back());
}

PairClusters read_clusters(const fs::path& folder, std::size_t controls, std::size_t places, std::size_t rank,
                           bool is_loaded) {
    if (rank > kMostRank || places == 0) fail(folder / "summary.json");
    PairClusters to;
    to.rank = rank;
    to.scale = read_all<float>(folder / "coupling_scale.npy", places);
    to.basis = read_steps<3>(folder / "coupling_basis.npy", places * rank);
    read_forms(folder, to);
    if (is_loaded)
        read_loads(folder, to);
    else
        to.place = read_places(folder / "coupling_place.npy", controls, places);
    return to;
}

}  // namespace

std::vector<std::uint32_t> core_begins(const std::vector<std::uint8_t>& form, std::size_t places) {
    std::vector<std::uint32_t> begin{0};
    for (std::size_t i = 0, core = 0; i < cluster_count(places); ++i)
        for (std::size_t j = 0; j <= i; ++j, ++core) {
            const std::size_t rows = std::min<std::size_t>(kClusterPlaces, places - kClusterPlaces * i);
            const std::size_t dense = 9 * kClusterPlaces * rows;
            const std::size_t bytes = form[core] == kTwiceForm   ? 2 * dense
                                      : form[core] == kDenseForm ? dense
                                                                 : std::size_t{form[core]} * form[core];
            begin.push_back(begin.back() + static_cast<std::uint32_t>(bytes));
        }
    return begin;
}

std::size_t pair_bytes(const PairTables& tables) {
    if (tables.is_exact()) return 36 * tables.block.size();
    const PairClusters& c = tables.clusters;
    return 4 * c.scale.size() + 6 * c.basis.size() + 4 * c.step.size() + c.form.size() + c.core.size() +
           4 * c.begin.size() + 2 * c.place.size() + 4 * c.load_begin.size() + 14 * c.load_place.size();
}

void write_pair(const PairTables& tables, const fs::path& folder) {
    if (tables.is_exact()) return write_rows(folder / "coupling.npy", {tables.block.size(), 3, 3}, tables.block);
    const PairClusters& c = tables.clusters;
    write_all(folder / "coupling_scale.npy", c.scale);
    write_steps(folder / "coupling_basis.npy", {c.places(), c.rank, 3}, c.basis);
    write_all(folder / "coupling_step.npy", c.step);
    write_all(folder / "coupling_form.npy", c.form);
    write_all(folder / "coupling_core.npy", c.core);
    if (c.load_begin.empty()) return write_all(folder / "coupling_place.npy", c.place);
    write_all(folder / "coupling_load_begin.npy", c.load_begin);
    write_all(folder / "coupling_load_place.npy", c.load_place);
    write_steps(folder / "coupling_load_share.npy", {c.load_place.size(), 6}, c.load_share);
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
        const std::size_t n = tables.control_count, places = pair.at("clustered");
        if (places == 0)
            tables.block = read_rows<9>(folder / "coupling.npy", n * (n + 1) / 2);
        else
            tables.clusters = read_clusters(folder, n, places, pair.at("rank"), pair.at("loads") != 0);
        return tables;
    } catch (const json::exception& error) {
        throw Error(path.string() + ": is not a summary of haptable-precompute (" + error.what() +
                    "): make the tables again");
    }
}

}  // namespace haptable
