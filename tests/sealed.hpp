// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace haptable::test {

/// Makes tables.json that of the folder's files as they are now: their hashes and, where a servo can be made of them,
/// its tables_hash. So does who changes tables and means to be believed.
void seal(const std::filesystem::path& folder);
/// The same with other facts.
void seal(const std::filesystem::path& folder, nlohmann::json facts);

}  // namespace haptable::test
