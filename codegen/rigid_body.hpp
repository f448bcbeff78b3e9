// SPDX-License-Identifier: GPL-2.0-or-later
// The table of a body that is not held: firmware/haptable_body.h.
#pragma once

#include <optional>
#include <string>

#include "firmware/haptable_body.h"
#include "host/tables/folder.hpp"

namespace haptable {

/// body.json of a precompute folder; none where the body is held. Throws Error that names the file and what it lacks.
std::optional<haptable_body> read_rigid_body(const TablesFolder& folder);

/// Throws Error where nothing holds the folder's body: for `who`, which knows no body that moves.
void refuse_free_body(const TablesFolder& folder, const char* who);

/// Its fields, as model.c has them.
std::string rigid_body_fields(const haptable_body& body);

/// What moves it: haptable_part_...
const char* rigid_part_of(const haptable_body& body);

}  // namespace haptable
