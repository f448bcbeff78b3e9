// SPDX-License-Identifier: GPL-2.0-or-later
// A folder of tables as OwnFolder has it: OwnFolder(folder, kTables, own_tables_in(folder)).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/own_folder.hpp"

namespace haptable {

/// The files of a folder without a mark that its tables.json names by their hash, and the reports; empty where one
/// differs.
std::vector<std::string> own_tables_in(const std::filesystem::path& folder);

}  // namespace haptable
