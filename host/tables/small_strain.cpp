// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/small_strain.hpp"

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"

namespace haptable {

std::optional<double> read_small_strain_depth(const std::filesystem::path& folder) try {
    const auto summary = parse_json(read_file(folder / "summary.json"));
    const auto found = summary.find("small_strain");
    if (found == summary.end() || found->is_null()) return {};
    return found->at("depth_m").get<double>();
} catch (const nlohmann::json::exception& error) {
    throw Error((folder / "summary.json").string() + ": is not a summary of haptable-precompute (" + error.what() +
                "): make the tables again");
}

}  // namespace haptable
