// SPDX-License-Identifier: GPL-2.0-or-later
// Where the programs of a session are, and the making of those that a scene still lacks.
#pragma once

#include <filesystem>
#include <string>

namespace haptable {

struct Places {
    std::filesystem::path programs;  ///< folder of haptable-device and the others: that of this program
    std::filesystem::path build;     ///< above it; of installed programs build/ in the current folder
    std::filesystem::path scene;     ///< build/<name>: tables and servo
    std::filesystem::path image;     ///< of the servo on a target; empty: on the host
};

/// Those of a scene's session; `target` may be empty. What is missing, or older than the
/// scene's file, is made, in sight unless `quiet`: with `make` where the current folder is haptable's, with
/// haptable-build, in build/ here, where the programs are installed; elsewhere an Error says the command.
Places find_places(const std::filesystem::path& scene_file, const std::string& name, const std::string& target,
                   bool quiet);

}  // namespace haptable
