// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/page.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/json.hpp"

namespace haptable {

namespace {

std::string escaped(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            default:
                safe += c;
        }
    }
    return safe;
}

std::string table(const Facts& facts) {
    std::string html = fmt::format("<h2>{}</h2>\n<table>\n", escaped(facts.heading));
    for (const auto& [name, value] : facts.rows)
        html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name), escaped(value));
    return html + "</table>\n";
}

constexpr const char* kStyle =
    "body { font: 15px/1.5 \"DejaVu Sans\", sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; "
    "color: #1a202c }\n"
    "table { border-collapse: collapse; font-size: 13px }\n"
    "th, td { border: 1px solid #cbd5e0; padding: 3px 8px; text-align: left; vertical-align: top }\n"
    "th { background: #edf2f7; font-weight: normal }\n"
    "p.note { border-left: 4px solid #c0392b; padding-left: 1em }\n"
    "svg { max-width: 100%; height: auto }\n";

}  // namespace

Facts facts_of(const std::string& heading, const std::string& json) {
    Facts facts{heading, {}};
    const auto summary = nlohmann::ordered_json::parse(json, nullptr, false);
    if (!summary.is_object()) return facts;
    for (const auto& [name, value] : summary.items()) {
        std::string text = json_text(value);
        if (value.is_string()) text = value.get<std::string>();
        if (value.is_number_float()) text = fmt::format("{:.6g}", value.get<double>());
        facts.rows.emplace_back(name, std::move(text));
    }
    return facts;
}

std::string report_page(const std::string& title, const std::string& note, const std::vector<Plot>& plots,
                        const std::vector<Facts>& facts) {
    std::string html = fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n<style>\n{1}</style>"
        "</head><body>\n<h1>{0}</h1>\n",
        escaped(title), kStyle);
    if (!note.empty()) html += fmt::format("<p class=\"note\">{}</p>\n", escaped(note));
    for (const Plot& plot : plots)
        html += fmt::format("<h2>{}</h2>\n<figure>{}</figure>\n", escaped(plot.title), plot.svg);
    for (const Facts& part : facts)
        if (!part.rows.empty()) html += table(part);
    return html + "</body></html>\n";
}

}  // namespace haptable
