// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haptable {

/// ASCII.
std::string lower(std::string_view text);
std::string upper(std::string_view text);

/// "9999 B", "10.0 kB" and so on, to GB.
std::string human_bytes(std::uintmax_t bytes);

/// The parts of the text, empty ones too; none of an empty text.
std::vector<std::string> split(std::string_view text, char between);

/// True where the whole text is a number, which value then is. Not of a locale.
template <typename Number>
bool read_number(std::string_view text, Number& value) {
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    return failed == std::errc() && end == text.data() + text.size();
}

}  // namespace haptable
