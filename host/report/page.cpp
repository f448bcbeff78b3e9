// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "host/base/error.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& cell) {
    return cell.is_string() ? cell.get<std::string>() : cell.at("text").get<std::string>();
}

std::string row_of(const std::vector<std::string>& cells) { return fmt::format("| {} |\n", fmt::join(cells, " | ")); }

/// The numbers in a text, without the commas between thousands: of four digits or more, zeros at either end not
/// counted. Fewer meet by chance; so do years.
std::set<std::string> long_numbers(const std::string& text) {
    static const std::regex kNumber(R"([0-9]+(,[0-9]{3})*(\.[0-9]+)?)");
    std::set<std::string> found;
    for (std::sregex_iterator at(text.begin(), text.end(), kNumber), end; at != end; ++at) {
        std::string digits = at->str();
        digits.erase(std::remove(digits.begin(), digits.end(), ','), digits.end());
        const std::size_t first = digits.find_first_not_of("0.");
        if (first == std::string::npos) continue;
        const std::size_t last = digits.find_last_not_of("0.");
        const auto significant =
            last + 1 - first -
            static_cast<std::size_t>(digits.substr(first, last - first).find('.') != std::string::npos);
        const bool is_year = at->length() == 4 && digits == at->str() && digits.find('.') == std::string::npos;
        if (significant >= 4 && !is_year) found.insert(digits);
    }
    return found;
}

std::set<std::string> quoted_numbers(const Json& topic) {
    if (!topic.contains("rows")) return long_numbers(text_of(topic));
    std::set<std::string> all;
    for (const Json& row : topic.at("rows"))
        for (const Json& cell : row)
            if (cell.is_object()) all.merge(long_numbers(text_of(cell)));
    return all;
}

std::string without_markers(const Page& page) {
    std::string rest;
    std::size_t at = 0;
    for (const Marker& marker : find_markers(page.text)) {
        rest += page.text.substr(at, marker.begin - at);
        at = marker.end;
    }
    return rest + page.text.substr(at);
}

/// Topics by the pages that show them.
std::map<std::string, std::vector<const Page*>> owners(const std::vector<Page>& pages) {
    std::map<std::string, std::vector<const Page*>> owner;
    for (const Page& page : pages)
        for (const Marker& marker : find_markers(page.text)) owner[marker.topic].push_back(&page);
    return owner;
}

void find_stale(const Page& page, const Json& topics, std::vector<std::string>& faults) {
    for (const Marker& marker : find_markers(page.text)) {
        const auto topic = topics.find(marker.topic);
        if (topic == topics.end())
            faults.push_back(fmt::format("{}: the marker {} has no number; measure it (make bench), or remove it",
                                         page.path.string(), marker.topic));
        else if (page.text.substr(marker.inside, marker.inside_end - marker.inside) != to_markdown(*topic))
            faults.push_back(fmt::format("{}: {} is not what numbers.json says; fill the page with make report",
                                         page.path.string(), marker.topic));
    }
}

void find_quotes(const Page& page, const std::string& topic, const Page& owner, const std::set<std::string>& numbers,
                 std::vector<std::string>& faults) {
    if (page.path == owner.path) return;
    const std::set<std::string> here = long_numbers(without_markers(page));
    std::vector<std::string> both;
    std::set_intersection(here.begin(), here.end(), numbers.begin(), numbers.end(), std::back_inserter(both));
    if (!both.empty())
        faults.push_back(fmt::format("{}: quotes {}, of {}, which stands on {}: link to it", page.path.string(),
                                     fmt::join(both, ", "), topic, owner.path.string()));
}

}  // namespace

std::vector<Marker> find_markers(const std::string& text) {
    static const std::regex kBegin(R"(<!-- ([a-z][a-z0-9-]*) -->)");
    std::vector<Marker> markers;
    for (std::sregex_iterator at(text.begin(), text.end(), kBegin), last; at != last; ++at) {
        Marker marker;
        marker.topic = (*at)[1];
        marker.begin = static_cast<std::size_t>(at->position());
        marker.inside = marker.begin + static_cast<std::size_t>(at->length());
        const std::string close = fmt::format("<!-- /{} -->", marker.topic);
        marker.inside_end = text.find(close, marker.inside);
        if (marker.inside_end == std::string::npos) continue;
        marker.end = marker.inside_end + close.size();
        markers.push_back(marker);
    }
    return markers;
}

std::string to_markdown(const Json& topic) {
    if (!topic.contains("rows")) return text_of(topic);
    const auto columns = topic.at("columns").get<std::vector<std::string>>();
    std::string text = "\n" + row_of(columns) + "|";
    for (std::size_t k = 0; k < columns.size(); ++k) text += "---|";
    text += "\n";
    for (const Json& row : topic.at("rows")) {
        std::vector<std::string> cells;
        for (const Json& cell : row) cells.push_back(text_of(cell));
        text += row_of(cells);
    }
    return text;
}

void print_topics(const Numbers& numbers) {
    for (const auto& [topic, json] : numbers.json().items()) fmt::print("{}: {}\n", topic, to_markdown(json));
}

std::string fill(const Page& page, const Json& topics) {
    std::string filled;
    std::size_t at = 0;
    for (const Marker& marker : find_markers(page.text)) {
        const auto topic = topics.find(marker.topic);
        if (topic == topics.end())
            throw Error(fmt::format("{}: the marker {} has no number; measure it (make bench), or remove it",
                                    page.path.string(), marker.topic));
        filled += page.text.substr(at, marker.inside - at) + to_markdown(*topic);
        at = marker.inside_end;
    }
    return filled + page.text.substr(at);
}

std::vector<std::string> find_faults(const std::vector<Page>& pages, const Json& topics) {
    std::vector<std::string> faults;
    for (const Page& page : pages) find_stale(page, topics, faults);
    const auto owner = owners(pages);
    for (const auto& [name, topic] : topics.items()) {
        const auto found = owner.find(name);
        const std::size_t places = found == owner.end() ? 0 : found->second.size();
        if (places != 1)
            faults.push_back(
                fmt::format("numbers.json: {} stands in {} places of the pages, and must in one", name, places));
        else
            for (const Page& page : pages)
                find_quotes(page, name, *found->second.front(), quoted_numbers(topic), faults);
    }
    return faults;
}

std::string to_plot_data(const Json& topic) {
    std::string text;
    for (const Json& row : topic.at("rows")) {
        std::vector<std::string> values;
        for (const Json& cell : row)
            values.push_back(&cell != &row.front() && cell.is_object() ? json_text(cell.at("value"))
                                                                       : fmt::format("\"{}\"", text_of(cell)));
        text += fmt::format("{}\n", fmt::join(values, " "));
    }
    return text;
}

std::string runs(const Json& topics) {
    std::map<std::pair<std::string, std::string>, std::vector<std::string>> measured;
    for (const auto& [name, topic] : topics.items())
        measured[{topic.value("command", "unknown"), topic.value("machine", "unknown")}].push_back(name);
    std::string text = row_of({"command", "machine", "topics of docs/numbers.json"}) + "|---|---|---|\n";
    for (const auto& [run, names] : measured)
        text += row_of({"`" + run.first + "`", run.second, fmt::format("{}", fmt::join(names, ", "))});
    return text;
}

}  // namespace haptable
