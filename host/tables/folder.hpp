// SPDX-License-Identifier: GPL-2.0-or-later
// The folder of a scene's tables: its facts, and its files, each with the bytes that tables.json has the hash of.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/base/scene_options.hpp"

namespace haptable {

/// What tables.json has as its facts_hash: of all else that it says.
std::string hash_facts(nlohmann::json facts);

/// Every reader of tables opens their files through it. Copies share what was checked; any number of threads may ask.
class TablesFolder {
public:
    /// Reads tables.json. Throws Error where it is not there, is not of haptable-precompute, or names a file
    /// outside of the folder.
    TablesFolder(std::filesystem::path path);  // NOLINT(google-explicit-constructor): a folder is what its path names
    /// The folder where tables.json and all files that it names are as they were written; else none.
    static std::optional<TablesFolder> if_whole(const std::filesystem::path& path);

    const std::filesystem::path& path() const;
    std::string text() const { return path().string(); }
    const nlohmann::json& facts() const;  ///< tables.json
    /// options.json, as precompute has written it. Throws Error where it is missing or damaged.
    SceneOptions options() const;
    /// Hashes of what the tables were made from, and of all parts of the servo's tables. 0: not yet known.
    std::uint64_t model_hash() const;
    std::uint64_t tables_hash() const;

    /// True where tables.json names the file.
    bool has(const std::string& name) const;
    /// The path of a file. At the first call for it its bytes are read whole. Throws Error that names the file where it
    /// is missing, no regular file, or not what was written.
    std::filesystem::path file(const std::string& name) const;
    /// Throws Error: the file, what is wrong with it, and that the tables must be made again.
    [[noreturn]] void fail(const std::string& name, const std::string& what) const;

private:
    struct Content;
    std::shared_ptr<Content> content_;
};

}  // namespace haptable
