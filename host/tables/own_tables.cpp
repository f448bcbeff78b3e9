// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/own_tables.hpp"

#include <nlohmann/json.hpp>

#include "host/tables/folder.hpp"

namespace haptable {

std::vector<std::string> own_tables_in(const std::filesystem::path& folder) {
    std::error_code none;
    if (std::filesystem::exists(folder / ".haptable", none)) return {};
    const auto whole = TablesFolder::if_whole(folder);
    if (!whole) return {};
    std::vector<std::string> files{"summary.json", "tables.json"};
    for (const auto& [file, hash] : whole->facts().at("hash").items()) files.push_back(file);
    return files;
}

}  // namespace haptable
