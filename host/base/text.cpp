// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace haptable {

std::string lower(std::string_view text) {
    std::string to(text);
    std::transform(to.begin(), to.end(), to.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return to;
}

std::string upper(std::string_view text) {
    std::string to(text);
    std::transform(to.begin(), to.end(), to.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return to;
}

std::vector<std::string> split(std::string_view text, char between) {
    std::vector<std::string> parts;
    if (text.empty()) return parts;
    for (std::size_t begin = 0, end = 0; end != text.npos; begin = end + 1) {
        end = text.find(between, begin);
        parts.emplace_back(text.substr(begin, end == text.npos ? end : end - begin));
    }
    return parts;
}

std::string human_bytes(std::uintmax_t bytes) {
    const auto size = static_cast<double>(bytes);
    if (bytes < 10'000) return fmt::format("{} B", bytes);
    if (bytes < 10'000'000) return fmt::format("{:.1f} kB", size / 1e3);
    return bytes < 10'000'000'000 ? fmt::format("{:.1f} MB", size / 1e6) : fmt::format("{:.1f} GB", size / 1e9);
}

}  // namespace haptable
