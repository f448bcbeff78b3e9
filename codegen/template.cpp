// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/template.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include "host/base/error.hpp"

namespace haptable {

namespace {

const std::string& value_of(std::string_view name, const TemplateValues& values) {
    const auto found = values.find(name);
    if (found == values.end()) throw Error("a template asks for @" + std::string(name) + "@, which has no value");
    return found->second;
}

bool is_name(std::string_view text) {
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
}

/// An @ that begins no place stays.
std::string filled_line(std::string_view line, const TemplateValues& values) {
    std::string text;
    for (;;) {
        const std::size_t begin = line.find('@');
        const std::size_t end = begin == line.npos ? line.npos : line.find('@', begin + 1);
        if (end == line.npos) return text.append(line);
        const std::string_view name = line.substr(begin + 1, end - begin - 1);
        text.append(line.substr(0, begin));
        text.append(is_name(name) ? value_of(name, values) : std::string(line.substr(begin, end - begin)));
        line.remove_prefix(is_name(name) ? end + 1 : end);
    }
}

bool is_place_alone(std::string_view line) {
    return line.size() > 2 && line.front() == '@' && line.back() == '@' && is_name(line.substr(1, line.size() - 2));
}

}  // namespace

std::string filled(std::string_view text, const TemplateValues& values) {
    constexpr std::string_view kIf = "@if ";
    std::string to;
    std::vector<bool> is_kept{true};  // by depth
    for (std::size_t end = 0; !text.empty(); text.remove_prefix(end)) {
        end = std::min(text.find('\n'), text.size() - 1) + 1;
        const bool has_newline = text[end - 1] == '\n';
        const std::string_view line = text.substr(0, has_newline ? end - 1 : end);
        const bool all_kept = std::all_of(is_kept.begin(), is_kept.end(), [](bool kept) { return kept; });
        if (line.starts_with(kIf)) {
            // What is left out anyway asks for nothing.
            is_kept.push_back(all_kept && !value_of(line.substr(kIf.size()), values).empty());
        } else if (line == "@else") {
            is_kept.back() = !is_kept.back();
        } else if (line == "@end") {
            is_kept.pop_back();
        } else if (all_kept) {
            const std::string whole = filled_line(line, values);
            to += whole;
            const bool ends = is_place_alone(line) && (whole.empty() || whole.back() == '\n');
            if (has_newline && !ends) to += '\n';
        }
    }
    return to;
}

}  // namespace haptable
