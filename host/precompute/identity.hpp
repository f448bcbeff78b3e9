// SPDX-License-Identifier: GPL-2.0-or-later
// Hashes of what decides the tables: they tie tables, servo and messages together, and tell what of an earlier run
// still holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "host/body/body.hpp"

namespace haptable {

/// What two runs must have in common for one to stand in for the other.
struct Identity {
    std::uint64_t model_hash = 0;                    ///< of all that decides the tables
    std::uint64_t body_hash = 0;                     ///< of what decides the factor: mesh, fixed nodes, material
    double tolerance = 0.0, column_tolerance = 0.0;  ///< as asked for
    std::string drawing;  ///< "columns", "solves" (columns are over the budget, the factor is kept) or "none"
};

/// With the scene's name, this version and the hash of this program's own bytes: a tool that was built anew may compute
/// otherwise.
nlohmann::ordered_json to_json(const Scene& scene, const Identity& identity);

/// options.json: every key of the scene with its value, and the scene file's name.
std::string options_text(const Scene& scene);

/// XXH3 (64 bits) of all that decides the tables: version, mesh, fixed nodes, touchable patches, material, and the text
/// of the options that change them. Names, paths and times are not in it: equal content gives equal hashes.
std::uint64_t hash_model(const Scene& scene, const Body& body);

/// XXH3 of what decides K and its factor.
std::uint64_t hash_body(const Scene& scene, const Body& body);

/// XXH3 of all that decides what is solved for columns.npy, and how: nodes and rows are unknowns.
std::uint64_t hash_work(const Scene& scene, const Identity& identity, const std::string& precision, double unit_m_per_n,
                        std::span<const std::int32_t> node, std::span<const std::int32_t> row);

/// XXH3 of this program's own bytes, 16 hex digits.
std::string program_hash();

}  // namespace haptable
