// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/error.hpp"

namespace haptable {

namespace {

/// Levenshtein's distance: the fewest letters to insert, remove or change.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t change = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({change, diagonal + 1, row[j] + 1});
        }
    }
    return row.back();
}

/// None: it is not three finite numbers.
std::optional<std::array<double, 3>> vector_of(const toml::node& node) {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->size() != 3) return {};
    std::array<double, 3> vector{};
    for (std::size_t c = 0; c < 3; ++c) {
        const std::optional<double> value = (*list)[c].value<double>();
        if (!value || (*list)[c].is_boolean() || !std::isfinite(*value)) return {};
        vector[c] = *value;
    }
    return vector;
}

}  // namespace

/// "; did you mean side?", or the list of what there is where nothing is near.
std::string suggest(std::string_view wrong, const Names& known) {
    std::string_view best;
    std::size_t least = std::max<std::size_t>(2, wrong.size() / 3) + 1;
    for (std::string_view name : known)
        if (const std::size_t distance = edit_distance(wrong, name); distance < least) {
            least = distance;
            best = name;
        }
    if (!best.empty()) return fmt::format("; did you mean {}?", best);
    return fmt::format("; known here: {}", fmt::join(known, ", "));
}

std::string_view type_name(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return node.is_array_of_tables() ? "a list of tables" : "a list";
        case toml::node_type::string:
            return "a text";
        case toml::node_type::integer:
            return "a whole number";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "true or false";
        default:
            return "a date or time";
    }
}
void Section::require_known(const Names& known) const {
    for (const auto& [key, node] : table_) {
        const std::string_view text = key.str();
        if (std::find(known.begin(), known.end(), text) == known.end())
            fail(text, "unknown key" + suggest(text, known));
    }
}

void Section::fail(std::string_view key, const std::string& what) const {
    throw Error(fmt::format("{}:{}: {}: {}", file_.string(), line(key), full(key), what));
}

double Section::number(std::string_view key) const {
    const toml::node* node = find(key);
    if (node == nullptr) missing(key, "a number");
    const std::optional<double> value = node->value<double>();
    if (!value || node->is_boolean()) fail(key, fmt::format("must be a number, not {}", type_name(*node)));
    if (!std::isfinite(*value)) fail(key, "must be a finite number");
    return *value;
}

std::int64_t Section::integer(std::string_view key) const {
    const toml::node* node = find(key);
    if (node == nullptr) missing(key, "a whole number");
    if (!node->is_integer()) fail(key, fmt::format("must be a whole number, not {}", type_name(*node)));
    return node->as_integer()->get();
}

bool Section::flag(std::string_view key) const {
    const toml::node* node = find(key);
    if (node == nullptr) missing(key, "true or false");
    if (!node->is_boolean()) fail(key, fmt::format("must be true or false, not {}", type_name(*node)));
    return node->as_boolean()->get();
}

std::string Section::text(std::string_view key) const {
    const toml::node* node = find(key);
    if (node == nullptr) missing(key, "a text");
    if (!node->is_string()) fail(key, fmt::format("must be a text in quotes, not {}", type_name(*node)));
    return node->as_string()->get();
}

std::string Section::choice(std::string_view key, const Names& have) const {
    std::string value = text(key);
    if (std::find(have.begin(), have.end(), value) != have.end()) return value;
    fail(key, fmt::format("\"{}\" is not known{}", value, suggest(value, have)));
}

std::vector<double> Section::numbers(std::string_view key, std::size_t count, std::string_view example) const {
    if (!has(key)) missing(key, example);
    const toml::array* list = table_.get_as<toml::array>(key);
    if (list == nullptr || list->size() != count) fail(key, fmt::format("must be {}", example));
    std::vector<double> values;
    for (const toml::node& entry : *list) {
        const std::optional<double> value = entry.value<double>();
        if (!value || entry.is_boolean() || !std::isfinite(*value))
            fail(key, fmt::format("entry {} must be a finite number", values.size()));
        values.push_back(*value);
    }
    return values;
}

std::array<std::array<double, 3>, 2> Section::two_vectors(std::string_view key, std::string_view example) const {
    const toml::array* list = table_.get_as<toml::array>(key);
    if (list == nullptr || list->size() != 2) fail(key, fmt::format("must be {}", example));
    std::array<std::array<double, 3>, 2> vectors{};
    for (std::size_t k = 0; k < 2; ++k) {
        const std::optional<std::array<double, 3>> vector = vector_of((*list)[k]);
        if (!vector) fail(key, fmt::format("must be {}", example));
        vectors[k] = *vector;
    }
    return vectors;
}

std::array<std::string, 2> Section::two_texts(std::string_view key, std::string_view example) const {
    const toml::array* list = table_.get_as<toml::array>(key);
    std::array<std::string, 2> texts;
    for (std::size_t k = 0; k < 2; ++k) {
        const toml::value<std::string>* text = list == nullptr || list->size() != 2 ? nullptr : (*list)[k].as_string();
        if (text == nullptr || text->get().empty()) fail(key, fmt::format("must be {}", example));
        texts[k] = text->get();
    }
    return texts;
}

Section Section::section(std::string_view key, bool required) const {
    static const toml::table empty;
    const toml::node* node = find(key);
    if (node == nullptr && required) fail(key, fmt::format("is missing; add a table [{}]", key));
    if (node != nullptr && !node->is_table())
        fail(key, fmt::format("must be one table, [{}], not {}", key, type_name(*node)));
    return {file_, full(key), node == nullptr ? empty : *node->as_table()};
}

std::vector<Section> Section::sections(std::string_view key) const {
    std::vector<Section> all;
    const toml::node* node = find(key);
    if (node == nullptr) return all;
    if (!node->is_array_of_tables())
        fail(key, fmt::format("must be a list of tables, [[{}]] with two brackets, not {}", key, type_name(*node)));
    for (const toml::node& entry : *node->as_array()) all.push_back(Section(file_, full(key), *entry.as_table()));
    return all;
}

int Section::line(std::string_view key) const {
    const auto entry = key.empty() ? table_.end() : table_.find(key);
    const toml::source_region& source = entry != table_.end() ? entry->first.source() : table_.source();
    return std::max(1, static_cast<int>(source.begin.line));
}

std::string Section::full(std::string_view key) const {
    return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

void Section::missing(std::string_view key, std::string_view type) const {
    fail(key, fmt::format("is missing; give {}", type));
}

}  // namespace haptable
