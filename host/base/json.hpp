// SPDX-License-Identifier: GPL-2.0-or-later
// JSON's parser and writer, compiled once: each costs a file that instantiates it 1 to 2 s.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace haptable {

/// What a text says. Throws nlohmann::json::parse_error.
nlohmann::json parse_json(std::string_view text);
/// The same; discarded (json.is_discarded()) where the text is no JSON.
nlohmann::json parse_json_or_discard(std::string_view text);
/// In one line, or with `indent` blanks a level.
std::string json_text(const nlohmann::json& json, int indent = -1);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace haptable
