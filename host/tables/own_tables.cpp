// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/own_tables.hpp"

#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"

namespace haptable {

std::vector<std::string> own_tables_in(const std::filesystem::path& folder) {
    std::error_code none;
    if (std::filesystem::exists(folder / ".haptable", none) || !std::filesystem::exists(folder / "summary.json", none))
        return {};
    const auto summary = parse_json_or_discard(read_file(folder / "summary.json"));
    if (!summary.is_object() || !summary.contains("hash") || !summary["hash"].is_object()) return {};
    std::vector<std::string> files{"summary.json"};
    for (const auto& [file, hash] : summary["hash"].items()) {
        if (!std::filesystem::exists(folder / file, none) || hash != hash_file(folder / file)) return {};
        files.push_back(file);
    }
    return files;
}

}  // namespace haptable
