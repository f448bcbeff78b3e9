// SPDX-License-Identifier: GPL-2.0-or-later
// What became of many strokes over one body in one mode: counted, kept in a file, and taken from there.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/strokes/judge.hpp"

namespace haptable {

/// A stroke that broke something.
struct Broken {
    std::uint64_t number;
    Verdict verdict;  ///< of one that was kept in a file only `tick`
};

struct Tally {
    std::size_t strokes = 0, ticks = 0, contact_ticks = 0;
    std::size_t both_ticks = 0;                 ///< two fingers in contact, or more
    std::size_t limits = 0;                     ///< of walks, slides and boxes
    std::array<std::size_t, kFaults> faulty{};  ///< strokes with each fault
    double most_given = 0.0;                    ///< given over stored, the worst stroke that met no clamp
    double most_area = 0.0;                     ///< by which area coordinates miss a sum of 1
    // By design (docs/CONTACT.md):
    std::size_t clamped = 0;                  ///< strokes that met max_force: their energy is judged until then
    std::size_t behind = 0, long_behind = 0;  ///< strokes in contact out of the god-object's sight; of over 20 ticks
    std::size_t passed = 0;                   ///< motions of a tick through the body that were not felt
    double cpu_s = 0.0;                       ///< that the strokes and their judge took
    std::vector<Broken> broken;               ///< ascending

    void add(std::uint64_t number, const Stroke& stroke, const Verdict& verdict);
    void add(const Tally& other);
};

Tally sum_of(const std::vector<Tally>& tallies);

nlohmann::ordered_json to_json(const Tally& tally);

/// Keeps it, beside and then renamed. key: of all that the counts depend on.
void write_tally(const std::filesystem::path& file, const std::string& key, const Tally& tally);
/// What was kept there under that key; none where there is no such file, or one of another key. Throws Error that names
/// the file where it is damaged.
std::optional<Tally> read_tally(const std::filesystem::path& file, const std::string& key);

}  // namespace haptable
