// SPDX-License-Identifier: GPL-2.0-or-later
// tables.json: what programs must know of tables beside their bytes. precompute alone writes and reads all of it;
// TablesFolder reads the hashes.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/precompute/summary.hpp"

namespace haptable {

/// "float" | "double".
std::string name_of(Precision precision);

/// Moduli and Poisson's ratio.
nlohmann::ordered_json to_json(const Material& material);

/// The text that --check prints: the audit and, in "body", what fixes each body, where that is known.
std::string to_json(const Audit& audit, const std::vector<Support>& supports,
                    const std::optional<GravityFacts>& gravity = {});

/// What tables.json and summary.json share: identity, audit, checks, and how L was found.
nlohmann::ordered_json facts_of(const Scene& scene, const Body& body, const Summary& summary);

/// The text of tables.json: these facts, the shape of the coupling, the hash of every file. tables_hash 0: not yet
/// known, and left out.
std::string tables_text(nlohmann::ordered_json facts, const Summary& summary, const std::string& summary_hash);

/// True where the folder holds, complete, what this program would compute: tables.json names the same identity and
/// scene, and every file has the hash that it gives. needs_code: as C too.
bool is_current(const std::filesystem::path& folder, const Scene& scene, const Identity& identity, bool needs_code);

/// What an earlier run told.
struct EarlierFacts {
    TablesFolder folder;  ///< whole
    double tolerance = 0.0, column_tolerance = 0.0;
    InverseSummary inverse;
};
/// Where the folder holds, complete and undamaged, tables of the same body, made by the same program.
std::optional<EarlierFacts> read_earlier(const std::filesystem::path& folder, const Identity& identity);

/// The warnings of the run that made this folder.
std::vector<std::string> kept_warnings(const std::filesystem::path& folder);

}  // namespace haptable
