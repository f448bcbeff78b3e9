// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/sealed.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"

namespace haptable::test {

void seal(const std::filesystem::path& folder, nlohmann::json summary) {
    summary["hash"] = nlohmann::json::object();
    summary.erase("tables_hash");
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename() != "summary.json")
            summary["hash"][entry.path().filename().string()] = hash_file(entry.path());
    write_file(folder / "summary.json", json_text(summary));
    try {
        summary["tables_hash"] = fmt::format("{:016x}", LoadedScene(read_scene_files(folder)).model().hash);
        write_file(folder / "summary.json", json_text(summary));
    } catch (const Error&) {  // no servo can be made of them
    }
}

void seal(const std::filesystem::path& folder) { seal(folder, parse_json(read_file(folder / "summary.json"))); }

}  // namespace haptable::test
