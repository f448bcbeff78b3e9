// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/manual.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/json.hpp"
#include "host/base/text.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/read_options.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;

const SectionKey& section_of(std::string_view name) {
    for (const SectionKey& section : scene_sections())
        if (name == section.name) return section;
    throw Error(fmt::format("there is no section {} in a scene", name));
}

// ---- the page ------------------------------------------------------------------------------------------------------

/// "[mesh]" or "[[fixed]]".
std::string header_of(std::string_view section) {
    return fmt::format(fmt::runtime(section_of(section).is_list ? "[[{}]]" : "[{}]"), section);
}

std::string quoted(const std::string& code) { return "`" + code + "`"; }

std::string range_text(const Key& key) {
    const auto& [least, most, above, below] = key.range;
    if (least == -Range::kNone) return "";
    if (most == Range::kNone) return above ? fmt::format("above {:g}", least) : fmt::format("{:g} or more", least);
    if (above) return fmt::format("above {:g}, at most {:g}", least, most);
    return fmt::format("{:g} to {}{:g}", least, below ? "below " : "", most);
}

std::string number_text(double value) { return fmt::format("{:g}", value); }

std::string default_text(const Key& key) {
    if (key.required) return "required";
    if (*key.fallback_text != '\0' || key.fallback.is_null()) return key.fallback_text;
    if (key.fallback.is_number_integer()) return std::to_string(key.fallback.get<std::int64_t>());
    if (key.fallback.is_number()) return number_text(key.fallback.get<double>());
    if (!key.fallback.is_array()) return quoted(json_text(key.fallback));
    std::vector<std::string> numbers;
    for (const Json& one : key.fallback) numbers.push_back(number_text(one.get<double>()));
    return fmt::format("[{}]", fmt::join(numbers, ", "));
}

std::string meaning(const Key& key) {
    std::vector<std::string> facts;
    if (*key.unit != '\0') facts.emplace_back(key.unit);
    if (const std::string range = range_text(key); !range.empty()) facts.push_back(range);
    std::vector<std::string> words;
    for (const char* one : key.words) words.push_back(quoted(fmt::format("\"{}\"", one)));
    if (!words.empty() && std::string_view(key.name) != "model")
        facts.push_back(fmt::format("{}", fmt::join(words, ", ")));
    const bool is_flag = key.type == KeyType::kFlag && *key.means != '`';
    if (is_flag) return "`true`: " + std::string(key.means);
    return facts.empty() ? key.means : fmt::format("{}; {}", fmt::join(facts, ", "), key.means);
}

/// What sections have the same key in common: one row for all of them.
std::vector<const Key*> alike(const Key& key) {
    std::vector<const Key*> all;
    for (const Key& other : scene_keys())
        if (std::string_view(other.name) == key.name && default_text(other) == default_text(key) &&
            meaning(other) == meaning(key))
            all.push_back(&other);
    return all;
}

std::string key_row(const Key& key, const std::vector<const Key*>& all) {
    std::string cell =
        *key.section == '\0' ? quoted(key.name) : quoted(fmt::format("{} {}", header_of(key.section), key.name));
    if (all.size() > 1) {
        std::vector<std::string> headers;
        for (const Key* other : all) headers.push_back(quoted(header_of(other->section)));
        cell = fmt::format("{} of {}", quoted(key.name), fmt::join(headers, ", "));
    }
    return fmt::format("| {} | {} | {} |\n", cell, default_text(key), meaning(key));
}

std::string key_table(const std::vector<std::string>& sections) {
    std::string text = "| key | default | meaning |\n|---|---|---|\n";
    for (const std::string& given : sections) {
        const std::string section = given == "scene" ? "" : given;
        if (!section.empty())
            text += fmt::format("| {} | {} | {} |\n", quoted(header_of(section)),
                                section_of(section).required ? "required" : "", section_of(section).means);
        for (const Key* key : keys_of(section_of(section).name))
            if (const auto all = alike(*key); all.front() == key) text += key_row(*key, all);
    }
    return text;
}

// ---- the schema ----------------------------------------------------------------------------------------------------

constexpr const char* kNamePattern = "^[A-Za-z][A-Za-z0-9_-]{0,63}$";

Json list_schema(Json items, std::size_t count) {
    return {{"type", "array"}, {"items", std::move(items)}, {"minItems", count}, {"maxItems", count}};
}

Json number_schema(const Key& key) {
    Json schema{{"type", key.type == KeyType::kInteger ? "integer" : "number"}};
    const auto& [least, most, above, below] = key.range;
    const auto whole = [&](double value) {
        return key.type == KeyType::kInteger ? Json(static_cast<std::int64_t>(value)) : Json(value);
    };
    if (least != -Range::kNone) schema[above ? "exclusiveMinimum" : "minimum"] = whole(least);
    if (most != Range::kNone) schema[below ? "exclusiveMaximum" : "maximum"] = whole(most);
    return schema;
}

Json either(Json a, Json b) { return {{"anyOf", {std::move(a), std::move(b)}}}; }

/// A material's key, whatever its law.
Json law_schema(std::string_view name) {
    Json number{{"type", "number"}}, text{{"type", "string"}, {"minLength", 1}};
    Json three = list_schema(number, 3);
    if (name == "axes" || name == "around") return list_schema(three, 2);
    if (name == "axes_field") return list_schema(text, 2);
    if (name == "direction") return three;
    if (name == "direction_field") return text;
    return either(number, three);
}

Json value_schema(const Key& key) {
    Json number = number_schema(key);
    switch (key.type) {
        case KeyType::kNumber:
            return key.words.empty() ? number : either(number, {{"enum", key.words}});
        case KeyType::kInteger:
            return number;
        case KeyType::kFlag:
            return {{"type", "boolean"}};
        case KeyType::kText:
            return {{"type", "string"}, {"minLength", 1}};
        case KeyType::kWord:
            return {{"enum", key.words}};
        case KeyType::kThree:
        case KeyType::kDirection:
            return list_schema(number, 3);
        case KeyType::kOneOrThree:
            return either(number, list_schema(number, 3));
        case KeyType::kSix:
        case KeyType::kBox:
            return list_schema(number, 6);
        case KeyType::kNodes:
            return {{"type", "array"},
                    {"items", {{"type", "integer"}, {"minimum", 0}}},
                    {"uniqueItems", true},
                    {"maxItems", 1000}};
        case KeyType::kByLaw:
            return law_schema(key.name);
    }
    return {};
}

/// Without a page's marks: of a link its text, of code what it says.
std::string plain(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const std::size_t close = text[i] == '[' ? text.find_first_of("[]", i + 1) : std::string_view::npos;
        if (close != std::string_view::npos && text.substr(close, 2) == "](") {
            out += text.substr(i + 1, close - i - 1);
            i = std::min(text.find(')', close), text.size());
        } else if (text[i] != '`') {
            out += text[i];
        }
    }
    return out;
}

Json key_schema(const Key& key) {
    Json schema = value_schema(key);
    schema["description"] = plain(*key.unit != '\0' ? fmt::format("{}; {}", key.unit, key.means) : key.means);
    if (!key.fallback.is_null()) schema["default"] = key.fallback;
    return schema;
}

/// What a table must have so that a condition holds: with a section's name in front, what the scene must have.
class Conditions {
public:
    /// `inside`: the section whose table is described; empty for the whole scene.
    Json of(std::string_view text, std::string_view inside) const {
        const std::size_t end = text.find_first_of("=>"), point = text.find('.');
        const std::string section(text.substr(0, point));
        Json table = Json::object();
        bool holds_without = false;
        if (point != std::string_view::npos) {
            const std::string key(text.substr(point + 1, end - point - 1));
            if (end != std::string_view::npos) {
                const Json wanted = text[end] == '>' ? Json{{"type", "number"}, {"exclusiveMinimum", 0}}
                                                     : Json{{"const", value_of(text.substr(end + 1))}};
                table["properties"] = {{key, wanted}};
                holds_without = holds_by_default(section + "." + key, wanted);
            }
            if (!holds_without) table["required"] = {key};
        }
        if (section == inside) return table;
        if (section_of(section).is_list) table = {{"contains", table}};
        Json scene{{"properties", {{section, table}}}};
        if (!holds_without) scene["required"] = {section};
        return scene;
    }

private:
    static Json value_of(std::string_view text) {
        if (text == "true") return true;
        return text.find_first_not_of("0123456789") == std::string_view::npos ? Json(std::stoi(std::string(text)))
                                                                              : Json(text);
    }
    bool holds_by_default(const std::string& key, const Json& wanted) const {
        if (!defaults_.has(key)) return false;
        const Json& value = defaults_.at(key);
        return wanted.contains("const") ? value == wanted["const"] : value.is_number() && value.get<double>() > 0.0;
    }
    SceneOptions defaults_ = default_options();
};

std::string_view section_in(std::string_view condition) { return condition.substr(0, condition.find_first_of(".=>")); }

/// A rule of one section's tables stands there, another at the scene.
Json rule_schema(const Rule& rule, std::string_view inside) {
    const Conditions conditions;
    Json others = Json::array();
    for (const std::string& one : split(rule.other, '|')) others.push_back(conditions.of(one, inside));
    Json wanted = rule.kind == Rule::kExcludes ? Json{{"not", others[0]}}
                  : rule.kind == Rule::kOneOf  ? Json{{"oneOf", others}}
                                               : Json{{"anyOf", others}};
    if (std::string_view(rule.subject) == inside) return wanted;
    return {{"if", conditions.of(rule.subject, inside)}, {"then", std::move(wanted)}};
}

std::string_view place_of(const Rule& rule) {
    const std::string_view section = section_in(rule.subject);
    for (const std::string& one : split(rule.other, '|'))
        if (section_in(one) != section) return "";
    return section;
}

/// The schema of the law that most scenes have; a material's reader judges the others.
Json isotropic_schema() {
    const Json young = number_schema({.range = kModulus});
    const Json poisson = number_schema({.range = {.least = -1.0, .most = 0.5, .above = true, .below = true}});
    const Json values{{"properties", {{"young", young}, {"poisson", poisson}}}, {"required", {"young", "poisson"}}};
    return {{"if", {{"properties", {{"law", {{"const", "isotropic"}}}}}}}, {"then", values}};
}

Json table_schema(const SectionKey& section) {
    Json schema{{"type", "object"},
                {"description", plain(section.means)},
                {"additionalProperties", false},
                {"properties", Json::object()}};
    Json required = Json::array(), rules = Json::array();
    for (const Key* key : keys_of(section.name)) {
        schema["properties"][key->name] = key_schema(*key);
        if (std::string_view(key->name) == "name") schema["properties"]["name"]["pattern"] = kNamePattern;
        if (key->required) required.push_back(key->name);
    }
    for (const Rule& rule : scene_rules())
        if (place_of(rule) == section.name) rules.push_back(rule_schema(rule, section.name));
    if (schema["properties"].contains("law")) rules.push_back(isotropic_schema());
    if (!required.empty()) schema["required"] = required;
    if (!rules.empty()) schema["allOf"] = rules;
    return schema;
}

}  // namespace

std::string with_keys(std::string_view page) {
    constexpr std::string_view kBegin = "<!-- keys: ", kClose = " -->\n", kEnd = "<!-- end -->";
    std::string out;
    for (;;) {
        const std::size_t mark = page.find(kBegin);
        if (mark == std::string_view::npos) return out + std::string(page);
        const std::size_t close = page.find(kClose, mark), end = page.find(kEnd, mark);
        if (close == std::string_view::npos || end == std::string_view::npos || end < close)
            throw Error("a table of keys has no \"<!-- end -->\"");
        std::istringstream names{std::string(page.substr(mark + kBegin.size(), close - mark - kBegin.size()))};
        std::vector<std::string> sections;
        for (std::string name; names >> name;) sections.push_back(name);
        out += page.substr(0, close + kClose.size());
        out += "\n" + key_table(sections) + "\n";
        out += kEnd;
        page.remove_prefix(end + kEnd.size());
    }
}

std::string scene_schema() {
    Json schema = table_schema(section_of(""));
    for (const SectionKey& section : scene_sections()) {
        if (*section.name == '\0') continue;
        const Json table = table_schema(section);
        schema["properties"][section.name] = section.is_list ? Json{{"type", "array"}, {"items", table}} : table;
        if (section.required) schema["required"].push_back(section.name);
    }
    Json whole{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "A scene of haptable"}};
    whole.update(schema);
    return json_text(whole, 1) + "\n";
}

}  // namespace haptable
