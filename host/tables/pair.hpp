// SPDX-License-Identifier: GPL-2.0-or-later
// What couples two fingers on one body: the files of a scene with [contact] fingers = 2.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace haptable {

/// C_kl = w_k^T L w_l of controls k, l, m/N. The controls are the servo's vertices that are free; under a mask all its
/// vertices (free ones first), then the edges of edge_id.npy, each with its own weights w. n controls, rank r.
struct PairTables {
    double meeting_m = 0.0;  ///< fingers nearer than this meet
    std::size_t control_count = 0;
    std::size_t rank = 0;  ///< 0: every pair has its block
    /// Pairs k >= l in a row by k: all of them [n (n + 1) / 2], C_kl; or near ones, what Phi_k Phi_l^T lacks of C_kl.
    std::vector<std::array<double, 9>> block;
    std::vector<std::uint32_t> near_begin;      ///< [n + 1]; empty where all stand
    std::vector<std::int32_t> near;             ///< l of each near block, ascending in a row
    std::vector<std::array<double, 3>> column;  ///< Phi, [n r]: rows of a control, one vector a column

    bool is_exact() const { return rank == 0; }
};

/// Bytes of these in the servo's tables: all pairs in float32; what is near and far in 16 bits.
std::size_t pair_bytes(const PairTables& tables);

/// coupling.npy, and for a low rank coupling_begin.npy, coupling_near.npy, coupling_far.npy.
void write_pair(const PairTables& tables, const std::filesystem::path& folder);

/// None where the folder's scene has one finger. Throws Error that names the file: missing, damaged or not fitting.
std::optional<PairTables> read_pair(const std::filesystem::path& folder);

}  // namespace haptable
