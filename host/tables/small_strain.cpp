// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/small_strain.hpp"

#include <nlohmann/json.hpp>
#include <string>

namespace haptable {

std::optional<double> read_small_strain_depth(const TablesFolder& folder) try {
    const auto found = folder.facts().find("small_strain");
    if (found == folder.facts().end() || found->is_null()) return {};
    return found->at("depth_m").get<double>();
} catch (const nlohmann::json::exception& error) {
    folder.fail("tables.json", std::string("is not of haptable-precompute (") + error.what() + ")");
}

}  // namespace haptable
