// SPDX-License-Identifier: GPL-2.0-or-later
// A scene's servo as a folder that other projects take in: its tables, the firmware, and a manifest of their kind.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace haptable {

/// What the firmware and a scene's tables are, wherever they are exported: names of files, ascending.
struct ServoSources {
    std::vector<std::filesystem::path> sources;  ///< *.c
    std::vector<std::filesystem::path> headers;  ///< *.h
};

/// The firmware in `firmware`, without its ports, and model.* (and display.*) of `tables`. Throws Error where one of
/// them is missing.
ServoSources servo_sources(const std::filesystem::path& firmware, const std::filesystem::path& tables);

/// The kinds that there are: folders of templates beside the programs (packaging/boards).
std::vector<std::string> export_kinds();

/// Writes the folder `out`, whole or not at all: src/ with all sources, and the templates of `kind` with the scene's
/// values. Throws Error for a kind that there is not, and where `out` is there already.
void export_servo(const std::filesystem::path& tables, const std::string& kind, const std::filesystem::path& out);

}  // namespace haptable
