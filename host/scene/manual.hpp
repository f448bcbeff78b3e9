// SPDX-License-Identifier: GPL-2.0-or-later
// The keys of a scene for people and editors, as the table has them (keys.hpp).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace haptable {

/// A page whose tables of keys are made anew: what stands between "<!-- keys: SECTION... -->" and "<!-- end -->", where
/// "scene" is what stands outside of all sections. Throws Error where a mark has no end or names no section.
std::string with_keys(std::string_view page);

/// JSON Schema (draft 7) of a scene file: types, ranges, words, and which keys need or exclude each other.
std::string scene_schema();

}  // namespace haptable
