// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/scene_options.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;

/// {section, key}; without a point {key, ""}.
std::pair<std::string, std::string> split(std::string_view key) {
    const std::size_t point = key.find('.');
    if (point == std::string_view::npos) return {std::string(key), ""};
    return {std::string(key.substr(0, point)), std::string(key.substr(point + 1))};
}

}  // namespace

SceneOptions::SceneOptions() : SceneOptions(Json::object()) {}

SceneOptions::SceneOptions(Json values) : values_(std::make_shared<const Json>(std::move(values))) {}

bool SceneOptions::has(std::string_view key) const {
    const auto [section, name] = split(key);
    const auto found = values_->find(section);
    return found != values_->end() && (name.empty() || (found->is_object() && found->contains(name)));
}

const Json& SceneOptions::at(std::string_view key) const {
    const auto [section, name] = split(key);
    const Json& found = values_->at(section);
    return name.empty() ? found : found.at(name);
}

double SceneOptions::number(std::string_view key) const { return at(key).get<double>(); }

double SceneOptions::amount(std::string_view key) const {
    if (!has(key) || is_text(key)) return 0.0;
    return at(key).is_boolean() ? static_cast<double>(at(key).get<bool>()) : number(key);
}

std::int64_t SceneOptions::integer(std::string_view key) const { return at(key).get<std::int64_t>(); }

bool SceneOptions::flag(std::string_view key) const { return has(key) && at(key).get<bool>(); }

bool SceneOptions::is_text(std::string_view key) const { return has(key) && at(key).is_string(); }

std::string SceneOptions::text(std::string_view key) const { return at(key).get<std::string>(); }

std::vector<double> SceneOptions::numbers(std::string_view key) const { return at(key).get<std::vector<double>>(); }

void SceneOptions::set(std::string_view key, Json value) {
    const auto [section, name] = split(key);
    Json all = *values_;
    (name.empty() ? all[section] : all[section][name]) = std::move(value);
    values_ = std::make_shared<const Json>(std::move(all));
}

void SceneOptions::refuse(std::string_view key) const {
    throw Error(fmt::format("{} = \"{}\" is not known to this version", key, text(key)));
}

}  // namespace haptable
