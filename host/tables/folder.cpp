// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/folder.hpp"

#include <charconv>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/hash.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFacts = "tables.json";
constexpr const char* kOptions = "options.json";

/// A name alone: no way out of the folder.
bool is_plain(const std::string& name) {
    return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos;
}

bool is_regular(const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored);
}

/// 16 hex digits; 0 where there are none.
std::uint64_t hash_in(const nlohmann::json& facts, const char* key, const fs::path& path) {
    const auto text = facts.find(key);
    if (text == facts.end()) return 0;
    const std::string digits = text->is_string() ? text->get<std::string>() : "";
    std::uint64_t hash = 0;
    const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), hash, 16);
    if (failed != std::errc() || end != digits.data() + digits.size())
        throw Error(path.string() + ": " + key + " is not hexadecimal: make the tables again");
    return hash;
}

}  // namespace

std::string hash_facts(nlohmann::json facts) {
    facts.erase("facts_hash");
    Hash hash;
    hash.add(json_text(facts));
    return hash.text();
}

struct TablesFolder::Content {
    fs::path path;
    nlohmann::json facts;
    std::uint64_t model_hash = 0, tables_hash = 0;
    std::map<std::string, std::string> hash;  ///< by file
    std::mutex lock;                          ///< of what follows
    std::set<std::string> checked;
};

TablesFolder::TablesFolder(fs::path path) : content_(std::make_shared<Content>()) {
    content_->path = std::move(path);
    const fs::path file = content_->path / kFacts;
    std::error_code ignored;
    if (!fs::exists(file, ignored))
        throw Error(file.string() + ": is not there: make the tables with haptable-precompute");
    if (!is_regular(file)) fail(kFacts, "is no file");
    nlohmann::json& facts = content_->facts;
    facts = parse_json_or_discard(read_file(file));
    const auto hashes = facts.is_object() ? facts.find("hash") : facts.end();
    if (!facts.is_object() || hashes == facts.end() || !hashes->is_object())
        fail(kFacts, "is not of haptable-precompute");
    for (const auto& [name, hash] : hashes->items()) {
        if (!is_plain(name))
            fail(kFacts, "names " + json_text(nlohmann::json(name)) + ", which is no file of its folder");
        content_->hash[name] = hash.is_string() ? hash.get<std::string>() : "";
    }
    content_->model_hash = hash_in(facts, "model_hash", file);
    content_->tables_hash = hash_in(facts, "tables_hash", file);
}

std::optional<TablesFolder> TablesFolder::if_whole(const fs::path& path) try {
    TablesFolder folder(path);
    if (folder.facts().value("facts_hash", nlohmann::json()) != hash_facts(folder.facts())) return {};
    for (const auto& [name, hash] : folder.content_->hash) folder.file(name);
    return folder;
} catch (const Error&) {
    return {};
}

const fs::path& TablesFolder::path() const { return content_->path; }

const nlohmann::json& TablesFolder::facts() const { return content_->facts; }

SceneOptions TablesFolder::options() const {
    const nlohmann::json values = parse_json_or_discard(read_file(file(kOptions)));
    if (!values.is_object()) fail(kOptions, "is not JSON");
    return SceneOptions(values);
}

std::uint64_t TablesFolder::model_hash() const { return content_->model_hash; }

std::uint64_t TablesFolder::tables_hash() const { return content_->tables_hash; }

bool TablesFolder::has(const std::string& name) const { return content_->hash.contains(name); }

fs::path TablesFolder::file(const std::string& name) const {
    fs::path path = content_->path / name;
    const auto hash = content_->hash.find(name);
    if (hash == content_->hash.end()) fail(name, "is missing: tables.json does not name it");
    const std::lock_guard guard(content_->lock);
    if (content_->checked.contains(name)) return path;
    if (!is_regular(path)) fail(name, "is missing");
    if (hash_file(path) != hash->second) fail(name, "is not the file that was written with tables.json");
    content_->checked.insert(name);
    return path;
}

void TablesFolder::fail(const std::string& name, const std::string& what) const {
    throw Error((content_->path / name).string() + ": " + what + ": make the tables again");
}

}  // namespace haptable
