// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/owner.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/own_folder.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// What scene.path in the folder says: whose tables they are.
std::string owner_of(const fs::path& folder) {
    const fs::path note = folder / "scene.path";
    if (!fs::exists(note)) return "";
    std::string owner = read_text(note);
    while (!owner.empty() && (owner.back() == '\n' || owner.back() == '\r')) owner.pop_back();
    return owner;
}

/// Whether another scene file of this name is still there.
bool is_another(const fs::path& owner, const Scene& scene) {
    std::error_code failed;
    if (owner.empty() || !fs::is_regular_file(owner, failed) || fs::equivalent(owner, scene.file, failed)) return false;
    try {
        return read_scene(owner).name == scene.name;
    } catch (const Error&) {
        return false;  // a scene that cannot be read has no tables to lose
    }
}

}  // namespace

void require_own(const fs::path& folder, const Scene& scene) {
    const std::string owner = owner_of(folder);
    if (owner != scene.file.string() && is_another(owner, scene))
        throw Error(
            fmt::format("{}: name: \"{}\" is the name of {} too, whose tables are in {}: give one of them "
                        "another name, or remove that folder",
                        scene.file.string(), scene.name, owner, folder.string()));
}

void note_owner(const fs::path& folder, const Scene& scene) {
    if (owner_of(folder) == scene.file.string()) return;
    write_file(OwnFolder(folder, kTables).file("scene.path"), scene.file.string() + "\n");
}

}  // namespace haptable
