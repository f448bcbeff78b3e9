// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/sealed.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"

namespace haptable::test {

namespace {
const std::set<std::string> kReports{"summary.json", "tables.json"};
}

void seal(const std::filesystem::path& folder, nlohmann::json facts) {
    facts["hash"] = nlohmann::json::object();
    facts.erase("tables_hash");
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file() && !kReports.contains(entry.path().filename()))
            facts["hash"][entry.path().filename().string()] = hash_file(entry.path());
    write_file(folder / "tables.json", json_text(facts));
    try {
        facts["tables_hash"] = fmt::format("{:016x}", LoadedScene(read_scene_files(folder)).model().hash);
        write_file(folder / "tables.json", json_text(facts));
    } catch (const Error&) {  // no servo can be made of them
    }
}

void seal(const std::filesystem::path& folder) { seal(folder, parse_json(read_file(folder / "tables.json"))); }

}  // namespace haptable::test
