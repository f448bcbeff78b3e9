// SPDX-License-Identifier: GPL-2.0-or-later
// A Markdown page with markers: "<!-- topic -->" and "<!-- /topic -->", and between them what numbers.json says.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/report/numbers.hpp"

namespace haptable {

/// From the first letter of the first marker to the last of the second; between them [inside, inside_end).
struct Marker {
    std::string topic;
    std::size_t begin = 0, inside = 0, inside_end = 0, end = 0;
};

/// The pairs of markers, in the page's order. Comments without an end of that name are none.
std::vector<Marker> find_markers(const std::string& text);

/// Every topic on standard output, "name: " and then as a page shows it.
void print_topics(const Numbers& numbers);

/// A topic as a page shows it: a table on lines of its own, or the text of a number.
std::string to_markdown(const nlohmann::ordered_json& topic);

struct Page {
    std::filesystem::path path;
    std::string text;
};

/// The page with its markers filled. Throws Error for a marker that numbers.json has no number for.
std::string fill(const Page& page, const nlohmann::ordered_json& topics);

/// What is wrong, one line each: a marker without its number or with another one, a number on no page or on two, and
/// one that a page quotes though another page owns it. A number is told by its digits, four or more of them.
std::vector<std::string> find_faults(const std::vector<Page>& pages, const nlohmann::ordered_json& topics);

/// The rows of a table for a plot: values as they were measured; texts, and the first cell, in quotes.
std::string to_plot_data(const nlohmann::ordered_json& topic);

/// A table in Markdown: which commands measured which topics, on which machine.
std::string runs(const nlohmann::ordered_json& topics);

}  // namespace haptable
