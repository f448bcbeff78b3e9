// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/summary_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/json.hpp"

namespace haptable {

namespace {

std::string to_text(const SummaryLines::Value& value) {
    if (const auto* number = std::get_if<double>(&value)) return fmt::format("{:.4g}", *number);
    if (const auto* count = std::get_if<std::int64_t>(&value)) return std::to_string(*count);
    return std::get<std::string>(value);
}

}  // namespace

std::string SummaryLines::table() const {
    std::size_t width = 0;
    for (const auto& line : lines_) width = std::max(width, line.first.size());
    std::string text;
    for (const auto& [key, value] : lines_) text += fmt::format("  {:<{}}  {}\n", key, width, to_text(value));
    return text;
}

std::string SummaryLines::json() const {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const auto& [key, value] : lines_) std::visit([&, &name = key](const auto& v) { object[name] = v; }, value);
    return json_text(object, 2) + "\n";
}

void SummaryLines::print(bool as_json, bool quiet) const {
    if (as_json)
        std::fputs(json().c_str(), stdout);
    else if (!quiet)
        std::fputs(table().c_str(), stdout);
}

}  // namespace haptable
