// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/numbers/numbers.hpp"

#include <fmt/format.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;

/// The processors that measured, for times mean little without them.
std::string machine() {
    std::ifstream file("/proc/cpuinfo");
    const unsigned processors = std::thread::hardware_concurrency();
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            return fmt::format("{} x {}", processors, line.substr(std::min(line.find(':') + 2, line.size())));
    return "unknown";
}

Json to_json(const Number& number) {
    Json json;
    if (number.value.size() == 1)
        json["value"] = number.value[0];
    else
        json["value"] = number.value;
    json["text"] = number.text;
    return json;
}

Json to_json(const Cell& cell) {
    const auto* number = std::get_if<Number>(&cell);
    return number == nullptr ? Json(std::get<std::string>(cell)) : to_json(*number);
}

/// What a cell or number of the JSON must be for a page to quote it.
void require_number(const Json& json, const std::string& where) {
    const bool is_number = json.is_object() && json.contains("value") && json.contains("text") &&
                           json["text"].is_string() && (json["value"].is_number() || json["value"].is_array());
    if (!json.is_string() && !is_number)
        throw Error(where + ": is neither a text nor a value with a text; measure it again");
}

void require_topic(const Json& topic, const std::string& where) {
    if (!topic.is_object()) throw Error(where + ": is no topic with a command; measure it again");
    if (!topic.contains("rows")) return require_number(topic, where);
    for (const Json& row : topic["rows"]) {
        if (row.size() != topic["columns"].size())
            throw Error(fmt::format("{}: a row has {} cells, and there are {} columns", where, row.size(),
                                    topic["columns"].size()));
        for (const Json& cell : row) require_number(cell, where);
    }
}

std::string text_of(const Json& cell) {
    return cell.is_string() ? cell.get<std::string>() : cell.at("text").get<std::string>();
}

std::string row_of(const std::vector<std::string>& cells) { return fmt::format("| {} |\n", fmt::join(cells, " | ")); }

}  // namespace

std::string thousands(std::uint64_t n) {
    std::string text = fmt::format("{}", n);
    for (std::size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
    return text;
}

Number number(double value, std::string text) { return {{value}, std::move(text)}; }

Number seconds(double s) {
    if (s < 1e-6) return {{s}, fmt::format("{:.3g} ns", s * 1e9)};
    if (s < 1e-3) return {{s}, fmt::format("{:.3g} us", s * 1e6)};
    return {{s}, s < 1.0 ? fmt::format("{:.3g} ms", s * 1e3) : fmt::format("{:.3g} s", s)};
}

Number count(std::uint64_t n) { return {{static_cast<double>(n)}, thousands(n)}; }

Number error_of(double relative) { return {{relative}, fmt::format("{:.1e}", relative)}; }

Numbers::Numbers(std::string command) : command_(std::move(command)), topics_(std::make_unique<Json>(Json::object())) {}
Numbers::~Numbers() = default;
Numbers::Numbers(Numbers&&) noexcept = default;
Numbers& Numbers::operator=(Numbers&&) noexcept = default;

void Numbers::add(const std::string& topic, const Number& number) {
    Json& json = (*topics_)[topic] = {{"command", command_}, {"machine", machine()}};
    json.update(to_json(number));
}

void Numbers::add(const std::string& topic, const NumberTable& table) {
    Json& json = (*topics_)[topic] = {{"command", command_}, {"machine", machine()}, {"columns", table.columns}};
    json["rows"] = Json::array();
    for (const auto& row : table.rows) {
        Json& cells = json["rows"].emplace_back(Json::array());
        for (const Cell& cell : row) cells.push_back(to_json(cell));
    }
    require_topic(json, topic);
}

void Numbers::write(const std::filesystem::path& file) const {
    std::filesystem::create_directories(std::filesystem::absolute(file).parent_path());
    write_file(file, to_text(*topics_));
}

std::string to_text(const Json& topics) {
    const std::map<std::string, Json> sorted = topics.get<std::map<std::string, Json>>();
    std::vector<std::string> blocks;
    for (const auto& [name, topic] : sorted) {
        std::vector<std::string> lines;
        for (const auto& [key, value] : topic.items()) {
            std::vector<std::string> rows;
            if (key == "rows")
                for (const Json& row : value) rows.push_back("   " + json_text(row));
            lines.push_back(fmt::format(
                "  \"{}\": {}", key, rows.empty() ? json_text(value) : fmt::format("[\n{}]", fmt::join(rows, ",\n"))));
        }
        blocks.push_back(fmt::format(" \"{}\": {{\n{}}}", name, fmt::join(lines, ",\n")));
    }
    return fmt::format("{{\n{}\n}}\n", fmt::join(blocks, ",\n"));
}

Json read_numbers(const std::filesystem::path& file) try {
    Json topics = Json::parse(read_file(file));
    if (!topics.is_object()) throw Error(file.string() + ": holds no topics; measure again with make bench");
    for (const auto& [name, topic] : topics.items()) require_topic(topic, file.string() + ": " + name);
    return topics;
} catch (const Json::exception& error) {
    throw Error(fmt::format("{}: is no JSON: {}; measure again with make bench", file.string(), error.what()));
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

}  // namespace haptable
