// SPDX-License-Identifier: GPL-2.0-or-later
// Where the programs find what belongs to them: in a build as after make install.
#pragma once

#include <filesystem>
#include <string>

namespace haptable {

/// This program's own folder.
std::filesystem::path program_folder();

/// A file or folder that comes with the programs: ../lib/haptable/NAME or ../share/haptable/NAME from the program's
/// folder where it is installed, ../lib/NAME in a build. The first of these that exists; empty where none does.
std::filesystem::path find_part(const std::string& name);

/// Whether haptable-build is beside this program: in a build it is not.
bool is_installed();

/// Where the folders of scenes are, each by its scene's name: in a build the one above the program's; of installed
/// programs build/ in the current folder.
std::filesystem::path scenes_folder();

}  // namespace haptable
