// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/installed.hpp"

namespace haptable {

namespace fs = std::filesystem;

fs::path program_folder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path find_part(const std::string& name) {
    const fs::path above = program_folder().parent_path();
    for (const char* folder : {"lib/haptable", "share/haptable", "lib"})
        if (fs::path part = above / folder / name; fs::exists(part)) return part;
    return {};
}

bool is_installed() { return fs::exists(program_folder() / "haptable-build"); }

fs::path scenes_folder() { return is_installed() ? fs::path("build") : fs::proximate(program_folder().parent_path()); }

}  // namespace haptable
