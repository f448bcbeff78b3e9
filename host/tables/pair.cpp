// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/pair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "host/tables/npy.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

template <std::size_t k, typename T>
void write_rows(const fs::path& path, const std::vector<std::size_t>& shape,
                const std::vector<std::array<T, k>>& rows) {
    const T* first = rows.empty() ? nullptr : rows.front().data();
    write_npy<T>(path, shape, std::span<const T>(first, k * rows.size()));
}

template <typename T>
void write_all(const fs::path& path, const std::vector<T>& values) {
    write_npy<T>(path, {values.size()}, values);
}

[[noreturn]] void fail(const TablesFolder& folder, const char* name) {
    folder.fail(name, "does not fit the coupling's other files");
}

template <typename T>
std::vector<T> read_all(const TablesFolder& folder, const char* name, std::size_t count) {
    std::vector<T> values = read_npy<T>(folder.file(name)).values;
    if (values.size() != count) fail(folder, name);
    return values;
}

template <std::size_t k, typename T>
std::vector<std::array<T, k>> read_rows(const TablesFolder& folder, const char* name, std::size_t count) {
    const std::vector<T> values = read_all<T>(folder, name, k * count);
    std::vector<std::array<T, k>> rows(count);
    for (std::size_t i = 0; i < values.size(); ++i) rows[i / k][i % k] = values[i];
    return rows;
}

std::vector<std::int32_t> read_places(const TablesFolder& folder, const char* name, std::size_t count,
                                      std::size_t places) {
    std::vector<std::int32_t> values = read_all<std::int32_t>(folder, name, count);
    for (const std::int32_t place : values)
        if (place < 0 || static_cast<std::size_t>(place) >= places) fail(folder, name);
    return values;
}

/// What each patch loads: begins ascend, and no patch has more than the servo's room.
void read_loads(const TablesFolder& folder, PairClusters& to) {
    constexpr const char* kBegin = "coupling_load_begin.npy";
    to.load_begin = read_npy<std::int32_t>(folder.file(kBegin)).values;
    if (to.load_begin.size() < 2 || to.load_begin.front() != 0) fail(folder, kBegin);
    for (std::size_t p = 0; p + 1 < to.load_begin.size(); ++p)
        if (to.load_begin[p + 1] < to.load_begin[p] ||
            to.load_begin[p + 1] - to.load_begin[p] > static_cast<std::int32_t>(kMostLoaded))
            fail(folder, kBegin);
    const auto count = static_cast<std::size_t>(to.load_begin.back());
    to.load_place = read_places(folder, "coupling_load_place.npy", count, to.places());
    to.load_share = read_rows<6, std::int16_t>(folder, "coupling_load_share.npy", count);
}

void read_forms(const TablesFolder& folder, PairClusters& to) {
    const std::size_t cores = core_count(to.places());
    to.form = read_all<std::uint8_t>(folder, "coupling_form.npy", cores);
    for (const std::uint8_t form : to.form)
        if (form < kDenseForm && form > to.rank) fail(folder, "coupling_form.npy");
    to.step = read_all<float>(folder, "coupling_step.npy", cores);
    CoreBegins begins = core_begins(to.form, to.places());
    to.begin = std::move(begins.begin);
    to.core = read_all<std::int8_t>(folder, "coupling_core.npy", to.begin.back());
    to.fine = read_rows<9, std::int16_t>(folder, "coupling_fine.npy", begins.fine);
}

PairClusters read_clusters(const TablesFolder& folder, std::size_t controls, std::size_t places, std::size_t rank,
                           bool is_loaded) {
    if (rank > kMostRank || places == 0) fail(folder, "tables.json");
    PairClusters to;
    to.rank = rank;
    to.scale = read_all<float>(folder, "coupling_scale.npy", places);
    for (const float scale : to.scale)
        if (!(scale >= 0.0F && std::isfinite(scale)))
            folder.fail("coupling_scale.npy", fmt::format("{} is no scale: it is not negative", scale));
    to.basis = read_rows<3, std::int16_t>(folder, "coupling_basis.npy", places * rank);
    read_forms(folder, to);
    if (is_loaded)
        read_loads(folder, to);
    else
        to.place = read_places(folder, "coupling_place.npy", controls, places);
    return to;
}

bool is_zero(const std::array<double, 9>& block) {
    return std::all_of(block.begin(), block.end(), [](double entry) { return entry == 0.0; });
}

/// A load on a control moves it along, and two loads together give no work: of C the diagonal blocks are positive
/// definite (zero where a control is held still), and every minor of two rows is not negative.
void require_definite(const TablesFolder& folder, const std::vector<std::array<double, 9>>& block, std::size_t n) {
    constexpr double kRounding = 1e-6;  // of blocks in double
    const auto place = [](std::size_t k, std::size_t l) { return k * (k + 1) / 2 + l; };
    for (std::size_t k = 0; k < n; ++k) {
        const auto& own = block[place(k, k)];
        if (!is_definite(own) && !is_zero(own))
            folder.fail("coupling.npy",
                        fmt::format("the block of place {} is not positive definite: it would pull", k));
        for (std::size_t l = 0; l < k; ++l)
            for (std::size_t e = 0; e < 9; ++e) {
                const double both = own[4 * (e / 3)] * block[place(l, l)][4 * (e % 3)], c = block[place(k, l)][e];
                if (!(c * c <= (1.0 + kRounding) * both))
                    folder.fail("coupling.npy",
                                fmt::format("places {} and {} couple by more than they give: two fingers there would "
                                            "pull",
                                            k, l));
            }
    }
}

}  // namespace

CoreBegins core_begins(const std::vector<std::uint8_t>& form, std::size_t places) {
    CoreBegins to;
    std::size_t core = 0;
    for (std::size_t i = 0, pair = 0; i < cluster_count(places); ++i)
        for (std::size_t j = 0; j <= i; ++j, ++pair) {
            const std::size_t blocks =
                kClusterPlaces * std::min<std::size_t>(kClusterPlaces, places - kClusterPlaces * i);
            std::size_t& next = form[pair] == kFineForm ? to.fine : core;
            to.begin.push_back(static_cast<std::uint32_t>(next));
            next += form[pair] == kFineForm    ? blocks
                    : form[pair] == kDenseForm ? 9 * blocks
                                               : std::size_t{form[pair]} * form[pair];
        }
    to.begin.push_back(static_cast<std::uint32_t>(core));
    return to;
}

std::size_t pair_bytes(const PairTables& tables) {
    if (tables.is_exact()) return 36 * tables.block.size();
    const PairClusters& c = tables.clusters;
    return 4 * c.scale.size() + 6 * c.basis.size() + 4 * c.step.size() + c.form.size() + c.core.size() +
           18 * c.fine.size() + 4 * c.begin.size() + 2 * c.place.size() + 4 * c.load_begin.size() +
           14 * c.load_place.size();
}

void write_pair(const PairTables& tables, const fs::path& folder) {
    if (tables.is_exact()) return write_rows(folder / "coupling.npy", {tables.block.size(), 3, 3}, tables.block);
    const PairClusters& c = tables.clusters;
    write_all(folder / "coupling_scale.npy", c.scale);
    write_rows(folder / "coupling_basis.npy", {c.places(), c.rank, 3}, c.basis);
    write_all(folder / "coupling_step.npy", c.step);
    write_all(folder / "coupling_form.npy", c.form);
    write_all(folder / "coupling_core.npy", c.core);
    write_rows(folder / "coupling_fine.npy", {c.fine.size(), 9}, c.fine);
    if (c.load_begin.empty()) return write_all(folder / "coupling_place.npy", c.place);
    write_all(folder / "coupling_load_begin.npy", c.load_begin);
    write_all(folder / "coupling_load_place.npy", c.load_place);
    write_rows(folder / "coupling_load_share.npy", {c.load_place.size(), 6}, c.load_share);
}

std::optional<PairTables> read_pair(const TablesFolder& folder) {
    using nlohmann::json;
    try {
        const std::int64_t fingers = folder.options().integer("contact.fingers");
        if (fingers == 1 && !folder.options().has("tool")) return {};
        const json& pair = folder.facts().at("pair");
        PairTables tables;
        tables.finger_count = static_cast<std::uint16_t>(fingers);
        pair.at("meeting_m").get_to(tables.meeting_m);
        if (!(tables.meeting_m >= 0.0 && std::isfinite(tables.meeting_m)))
            folder.fail("tables.json", fmt::format("meeting_m = {} is no distance", tables.meeting_m));
        pair.at("controls").get_to(tables.control_count);
        const std::size_t n = tables.control_count, places = pair.at("clustered");
        if (places == 0) {
            tables.block = read_rows<9, double>(folder, "coupling.npy", n * (n + 1) / 2);
            require_definite(folder, tables.block, n);
        } else
            tables.clusters = read_clusters(folder, n, places, pair.at("rank"), pair.at("loads") != 0);
        return tables;
    } catch (const json::exception& error) {
        folder.fail("tables.json", fmt::format("is not of haptable-precompute ({})", error.what()));
    }
}

}  // namespace haptable
