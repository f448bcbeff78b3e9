// SPDX-License-Identifier: GPL-2.0-or-later
// What couples two places of a body: the files of a scene with [contact] fingers = 2 and more, or [tool].
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/tables/folder.hpp"

namespace haptable {

/// The servo's numbers (haptable_pair.h): places of a cluster, the most vectors of a basis, the most places that a
/// patch loads; forms of a core beside its rank.
constexpr std::size_t kClusterPlaces = 8, kMostRank = 12, kMostLoaded = 48;
constexpr std::uint8_t kDenseForm = 254, kFineForm = 255;

/// Clusters of m places; pairs of clusters I >= J.
constexpr std::size_t cluster_count(std::size_t places) { return (places + kClusterPlaces - 1) / kClusterPlaces; }
constexpr std::size_t core_count(std::size_t places) { return cluster_count(places) * (cluster_count(places) + 1) / 2; }

/// A symmetric matrix of 3x3 blocks A_ij over places in clusters of kClusterPlaces, as the servo holds it
/// (struct haptable_pair_model): m places, r vectors of each, c pairs of clusters I >= J in a row by I.
struct PairClusters {
    std::size_t rank = 0;                            ///< r
    std::vector<float> scale;                        ///< [m]
    std::vector<std::array<std::int16_t, 3>> basis;  ///< [m r], in 1/32767
    std::vector<float> step;                         ///< [c]
    std::vector<std::uint8_t> form;                  ///< [c]: rank of the core, kDenseForm or kFineForm
    std::vector<std::int8_t> core;
    std::vector<std::array<std::int16_t, 9>> fine;  ///< blocks of the cores of kFineForm
    std::vector<std::uint32_t> begin;  ///< [c + 1]: where in `core` each begins, or in `fine`; the last: all of `core`

    /// Either which place each control is [n], or what each patch loads: places, and of each the share of every control
    /// in 1/32767.
    std::vector<std::int32_t> place;
    std::vector<std::int32_t> load_begin;  ///< [p + 1]
    std::vector<std::int32_t> load_place;
    std::vector<std::array<std::int16_t, 6>> load_share;

    std::size_t places() const { return scale.size(); }
    bool operator==(const PairClusters&) const = default;
};

/// Where the cores of these forms begin over m places, and how many numbers and fine blocks they are.
struct CoreBegins {
    std::vector<std::uint32_t> begin;  ///< [c + 1]
    std::size_t fine = 0;
};
CoreBegins core_begins(const std::vector<std::uint8_t>& form, std::size_t places);

/// C_kl = w_k^T L w_l of controls k, l, m/N. The controls are the servo's vertices that are free; under a mask all its
/// vertices (free ones first), then the edges of edge_id.npy, each with its own weights w. n controls.
struct PairTables {
    double meeting_m = 0.0;  ///< fingers nearer than this meet
    std::size_t control_count = 0;
    std::uint16_t finger_count = 2;  ///< of a tool 1
    /// Either all pairs k >= l in a row by k, C_kl [n (n + 1) / 2]; or
    std::vector<std::array<double, 9>> block;
    /// clusters of places, as the force asks for it: S_k C_kl S_l (interpolated), else C_kl.
    PairClusters clusters;

    bool is_exact() const { return clusters.scale.empty(); }
};

/// Bytes of these in the servo's tables.
std::size_t pair_bytes(const PairTables& tables);

/// coupling.npy; or coupling_scale.npy, _basis, _step, _form, _core, with _place or _load_begin, _load_place,
/// _load_share.
void write_pair(const PairTables& tables, const std::filesystem::path& folder);

/// None where the folder's scene has one finger. Throws Error that names the file: missing, damaged or not fitting.
std::optional<PairTables> read_pair(const TablesFolder& folder);

}  // namespace haptable
