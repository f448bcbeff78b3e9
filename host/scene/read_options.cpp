// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/read_options.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/text.hpp"
#include "host/scene/keys.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;

// ---- a value -------------------------------------------------------------------------------------------------------

void check_range(const Section& section, const Key& key, double value) {
    const auto& [least, most, above, below] = key.range;
    if ((above ? value > least : value >= least) && (below ? value < most : value <= most)) return;
    const bool is_whole = key.type == KeyType::kInteger;
    const std::string is = is_whole ? fmt::format("{}", static_cast<std::int64_t>(value)) : fmt::format("{}", value);
    const char* const unit = is_whole && *key.unit != '\0' ? " (bytes)" : "";
    if (!is_whole && least >= 0.0 && value <= 0.0 && (least > 0.0 || above))
        section.fail(key.name, fmt::format("is {} and must be greater than 0", is));
    if (!is_whole && least == 0.0 && value < 0.0)
        section.fail(key.name, fmt::format("is {} and must not be less than 0", is));
    if (*key.beyond != '\0' && is_whole)
        section.fail(key.name, fmt::format(fmt::runtime(key.beyond), static_cast<std::int64_t>(value)));
    if (*key.beyond != '\0') section.fail(key.name, fmt::format(fmt::runtime(key.beyond), value));
    if (above && most == Range::kNone)
        section.fail(key.name, fmt::format("is {} and must be greater than {}{}", is, least, unit));
    if (most == Range::kNone) section.fail(key.name, fmt::format("is {} and must be {} or more", is, least));
    if (above) section.fail(key.name, fmt::format("is {} and must lie above {} and be at most {}", is, least, most));
    section.fail(key.name, fmt::format("is {}{}{} and must lie in {}..{}", is, is_whole || *key.unit == '\0' ? "" : " ",
                                       is_whole ? "" : key.unit, least, most));
}

Names words_of(const Key& key) { return {key.words.begin(), key.words.end()}; }

/// A number, or a word that may stand for it; "off" is 0.
Json read_number(const Section& section, const Key& key) {
    if (key.words.empty() || !section.find(key.name)->is_string()) {
        const double value = section.number(key.name);
        check_range(section, key, value);
        return value;
    }
    if (key.words.size() > 1) return section.choice(key.name, words_of(key));
    const std::string text = section.text(key.name), off = key.words.front();
    if (text != off) section.fail(key.name, fmt::format("is \"{}\": give a number above 0, or \"{}\"", text, off));
    return 0.0;
}

std::string read_text(const Section& section, const Key& key) {
    std::string text = section.text(key.name);
    if (text.empty() && std::string_view(key.name) == "group")
        section.fail("group", "is empty; name a group of the mesh file");
    if (text.empty() && std::string_view(key.name) == "file")
        section.fail("file", "is empty; name a mesh file, relative to the scene");
    return text;
}

std::vector<double> read_direction(const Section& section, const Key& key) {
    const bool down = std::string_view(key.section) == "gravity";
    std::vector<double> v = section.numbers(key.name, 3, down ? "a direction, [0, 0, -1]" : "a direction, [0, 0, 1]");
    if (std::all_of(v.begin(), v.end(), [](double x) { return x == 0.0; }))
        section.fail(key.name, "is 0, which is no direction");
    return v;
}

std::vector<double> read_box(const Section& section, const Key& key) {
    std::vector<double> box = section.numbers(key.name, 6, "six numbers: xmin ymin zmin xmax ymax zmax (m)");
    for (std::size_t c = 0; c < 3; ++c)
        if (box[c] > box[c + 3])
            section.fail(key.name, fmt::format("{}min {} is greater than {}max {}; swap them", "xyz"[c], box[c],
                                               "xyz"[c], box[c + 3]));
    return box;
}

std::vector<double> read_three(const Section& section, const Key& key) {
    std::vector<double> three(3);
    if (key.type == KeyType::kOneOrThree && !section.find(key.name)->is_array())
        std::fill(three.begin(), three.end(), section.number(key.name));
    else
        three = section.numbers(key.name, 3, "three numbers: x y z");
    for (const double value : three) check_range(section, key, value);
    return three;
}

std::vector<double> read_six(const Section& section, const Key& key) {
    std::vector<double> six = section.numbers(key.name, 6, "six: along x, y, z, then about them");
    for (const double value : six)
        if (!(value >= 0.0)) section.fail(key.name, fmt::format("has {}, and none may be less than 0", value));
    return six;
}

/// Mesh nodes, each once.
std::vector<std::int32_t> read_nodes(const Section& section, const Key& key) {
    const toml::array* list = section.find(key.name)->as_array();
    if (list == nullptr) section.fail(key.name, "must be a list of mesh nodes, like [0, 12, 57]");
    if (list->size() > 1000)
        section.fail(key.name, fmt::format("names {} nodes, and a target's display has at most 1000", list->size()));
    std::vector<std::int32_t> nodes;
    for (const toml::node& entry : *list) {
        const std::int64_t node = entry.is_integer() ? entry.as_integer()->get() : -1;
        if (node < 0 || node > std::numeric_limits<std::int32_t>::max())
            section.fail(key.name, "must be a list of mesh nodes, whole numbers from 0 on");
        if (std::find(nodes.begin(), nodes.end(), node) != nodes.end())
            section.fail(key.name, fmt::format("names node {} twice", node));
        nodes.push_back(static_cast<std::int32_t>(node));
    }
    return nodes;
}

constexpr const char* kPointList = "must be a list of points, like [[-0.004, 0, 0], [0.004, 0, 0]], m about the handle";

/// A number of points, or their places.
Json read_points(const Section& section, const Key& key) {
    const toml::array* list = section.find(key.name)->as_array();
    const std::int64_t count = list != nullptr ? static_cast<std::int64_t>(list->size()) : section.integer(key.name);
    check_range(section, key, static_cast<double>(count));
    if (list == nullptr) return count;
    Json points = Json::array();
    for (const toml::node& entry : *list) {
        const toml::array* point = entry.as_array();
        if (point == nullptr || point->size() != 3) section.fail(key.name, kPointList);
        Json place = Json::array();
        for (const toml::node& part : *point) {
            const std::optional<double> value = part.value<double>();
            if (!value || !std::isfinite(*value)) section.fail(key.name, kPointList);
            place.push_back(*value);
        }
        points.push_back(std::move(place));
    }
    return points;
}

Json read_integer(const Section& section, const Key& key) {
    const std::int64_t value = section.integer(key.name);
    check_range(section, key, static_cast<double>(value));
    return value;
}

/// As it stands.
Json as_json(const toml::node& node) {
    if (const toml::array* list = node.as_array()) {
        Json all = Json::array();
        for (const toml::node& entry : *list) all.push_back(as_json(entry));
        return all;
    }
    if (const toml::table* table = node.as_table()) {
        Json all = Json::object();
        for (const auto& [key, entry] : *table) all[std::string(key.str())] = as_json(entry);
        return all;
    }
    if (node.is_string()) return node.as_string()->get();
    if (const std::optional<double> value = node.value<double>()) return *value;
    return {};
}

Json read_value(const Section& section, const Key& key) {
    switch (key.type) {
        case KeyType::kNumber:
            return read_number(section, key);
        case KeyType::kInteger:
            return read_integer(section, key);
        case KeyType::kFlag:
            return section.flag(key.name);
        case KeyType::kText:
            return read_text(section, key);
        case KeyType::kWord:
            return section.choice(key.name, words_of(key));
        case KeyType::kThree:
        case KeyType::kOneOrThree:
            return read_three(section, key);
        case KeyType::kSix:
            return read_six(section, key);
        case KeyType::kDirection:
            return read_direction(section, key);
        case KeyType::kBox:
            return read_box(section, key);
        case KeyType::kNodes:
            return read_nodes(section, key);
        case KeyType::kPoints:
            return read_points(section, key);
        case KeyType::kByLaw:
            return as_json(*section.find(key.name));
    }
    return {};
}

// ---- a section -----------------------------------------------------------------------------------------------------

/// A table of the file and what it says.
struct Read {
    std::string name;
    Section section;
    Json values;
};

/// Into `options`, where the section is one table and not of a list.
Json read_values(const Section& section, std::string_view name, SceneOptions* options) {
    Json values = Json::object();
    for (const Key* key : keys_of(name)) {
        Json value;
        if (section.has(key->name) || key->required)
            value = read_value(section, *key);
        else
            value = fallback_of(*key, options != nullptr ? *options : SceneOptions());
        if (value.is_null()) continue;
        values[key->name] = value;
        if (options != nullptr) options->set(name.empty() ? key->name : fmt::format("{}.{}", name, key->name), value);
    }
    return values;
}

std::vector<Read> read_sections(const Section& root, SceneOptions& options) {
    std::vector<Read> all;
    const auto read = [&](const Section& section, const SectionKey& of, SceneOptions* into) {
        Names known;
        for (const Key* key : keys_of(of.name)) known.emplace_back(key->name);
        if (*of.name == '\0')
            for (const SectionKey& other : scene_sections())
                if (*other.name != '\0') known.emplace_back(other.name);
        section.require_known(known);
        all.push_back({of.name, section, read_values(section, of.name, into)});
    };
    for (const SectionKey& of : scene_sections()) {
        if (*of.name == '\0') {
            read(root, of, &options);
        } else if (of.is_list) {
            const std::size_t first = all.size();
            for (const Section& section : root.sections(of.name)) read(section, of, nullptr);
            Json list = Json::array();
            for (std::size_t i = first; i < all.size(); ++i) list.push_back(all[i].values);
            if (!list.empty()) options.set(of.name, std::move(list));
        } else if (root.has(of.name) || !of.is_optional) {
            read(root.section(of.name, of.required), of, &options);
        }
    }
    return all;
}

// ---- rules between keys --------------------------------------------------------------------------------------------

/// "section", "section.key", "section.key=value" or "section.key>number".
struct Condition {
    explicit Condition(std::string_view text) {
        const std::size_t end = text.find_first_of("=>"), point = text.find('.');
        section = text.substr(0, point);
        if (point != std::string_view::npos) key = text.substr(point + 1, end - point - 1);
        if (end == std::string_view::npos) return;
        is_above = text[end] == '>';
        value = text.substr(end + 1);
    }
    std::string_view section, key, value;
    bool is_above = false;
};

bool is_value(const Json& json, const Condition& wanted) {
    if (wanted.is_above) return json.is_number() && json.get<double>() > std::stod(std::string(wanted.value));
    return json.is_string() ? json.get<std::string>() == wanted.value : json.dump() == wanted.value;
}

/// In the table that a rule speaks of, else in the only one of that name.
bool holds(const Condition& wanted, const Read& here, const std::vector<Read>& all) {
    const auto of_name = [&](const Read& read) { return read.name == wanted.section; };
    const auto found = std::find_if(all.begin(), all.end(), of_name);
    const Read* const read = of_name(here) ? &here : found != all.end() ? &*found : nullptr;
    if (read == nullptr || wanted.key.empty()) return read != nullptr;
    if (!wanted.value.empty())
        return read->values.contains(wanted.key) && is_value(read->values[std::string(wanted.key)], wanted);
    const toml::node* given = read->section.find(wanted.key);
    return given != nullptr && !(given->is_array() && given->as_array()->empty());
}

std::size_t count_of(std::string_view alternatives, const Read& here, const std::vector<Read>& all) {
    std::size_t count = 0;
    for (const std::string& one : split(alternatives, '|')) count += holds(Condition(one), here, all) ? 1 : 0;
    return count;
}

void check_rule(const Rule& rule, const std::vector<Read>& all) {
    const Condition subject(rule.subject);
    for (const Read& here : all) {
        if (here.name != subject.section || !holds(subject, here, all)) continue;
        const std::size_t count = count_of(rule.other, here, all);
        const bool is_kept = rule.kind == Rule::kNeeds   ? count > 0
                             : rule.kind == Rule::kOneOf ? count == 1
                                                         : count == 0;
        if (!is_kept) here.section.fail(*rule.at != '\0' ? Condition(rule.at).key : subject.key, rule.error);
    }
}

}  // namespace

SceneOptions read_options(const Section& root) {
    SceneOptions options;
    const std::vector<Read> all = read_sections(root, options);
    for (const Rule& rule : scene_rules()) check_rule(rule, all);
    return options;
}

SceneOptions default_options() {
    SceneOptions options;
    for (const SectionKey& section : scene_sections()) {
        if (section.is_list || section.is_optional) continue;
        for (const Key* key : keys_of(section.name))
            if (Json value = fallback_of(*key, options); !value.is_null())
                options.set(fmt::format("{}.{}", section.name, key->name), std::move(value));
    }
    return options;
}

}  // namespace haptable
