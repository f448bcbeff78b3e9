// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/rigid_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

namespace {

using nlohmann::json;

constexpr const char* kFile = "body.json";

void take(const json& value, std::span<float> numbers) {
    if (value.size() != numbers.size()) throw json::other_error::create(501, "has other than its numbers", &value);
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = value.at(i).get<float>();
}

haptable_body body_of(const json& file) {
    haptable_body body{};
#define HAPTABLE_TAKE_VALUE(name) file.at(#name).get_to(body.name);
#define HAPTABLE_TAKE_VECTOR(name, size) take(file.at(#name), body.name);
    HAPTABLE_BODY_FIELDS(HAPTABLE_TAKE_VALUE, HAPTABLE_TAKE_VECTOR)
    const json& points = file.at("point_m");
    if (points.size() > HAPTABLE_BODY_POINTS) throw json::other_error::create(501, "has too many points", &points);
    for (const json& point : points) take(point, body.point_m[body.point_count++]);
    return body;
}

constexpr const char* kMotionKey[] = {
#define HAPTABLE_KEY(PART, KEY, ...) KEY,
    HAPTABLE_RIGID_MOVERS(HAPTABLE_KEY)};

/// The last that the scene chooses.
std::uint32_t motion_of(const SceneOptions& options) {
    std::uint32_t motion = HAPTABLE_RIGID_MOTIONS - 1;
    while (motion > 0 && !options.flag(kMotionKey[motion])) --motion;
    return motion;
}

/// It weighs something, in every direction, and nothing of it feeds a motion.
void require_sound(const TablesFolder& folder, const haptable_body& body) {
    const auto require = [&folder](const char* key, std::span<const float> values, float least) {
        for (const float value : values)
            if (!(value >= least && std::isfinite(value)))
                folder.fail(kFile, fmt::format("{} holds {}: finite, at least {:g}", key, value, least));
    };
    constexpr float kLeast = -std::numeric_limits<float>::max();
    // NOLINTBEGIN(bugprone-macro-parentheses): names that are declared
#define HAPTABLE_REQUIRE_VALUE(name) require(#name, {&body.name, 1}, kLeast);
#define HAPTABLE_REQUIRE_VECTOR(name, size) require(#name, body.name, kLeast);
    // NOLINTEND(bugprone-macro-parentheses)
    HAPTABLE_BODY_FIELDS(HAPTABLE_REQUIRE_VALUE, HAPTABLE_REQUIRE_VECTOR)
    require("point_m", {&body.point_m[0][0], std::size(body.point_m) * 3}, kLeast);
    require("mass_kg", {&body.mass_kg, 1}, std::numeric_limits<float>::min());
    const float* const j = body.inertia_kg_m2;
    const auto at = [j](std::size_t i) { return static_cast<double>(j[i]); };
    if (!is_definite({at(0), at(3), at(5), at(3), at(1), at(4), at(5), at(4), at(2)}))
        folder.fail(kFile, "inertia_kg_m2 is not positive definite");
    for (const auto& [key, values] : {std::pair{"stiffness_n_per_m", std::span(body.stiffness_n_per_m)},
                                      {"damping_n_s_per_m", std::span(body.damping_n_s_per_m)},
                                      {"turn_stiffness_n_m", std::span(body.turn_stiffness_n_m)},
                                      {"turn_damping_n_m_s", std::span(body.turn_damping_n_m_s)}})
        require(key, values, 0.0F);
    require("floor_stiffness_n_per_m", {&body.floor_stiffness_n_per_m, 1}, 0.0F);
    require("floor_damping_n_s_per_m", {&body.floor_damping_n_s_per_m, 1}, 0.0F);
    require("floor_friction", {&body.floor_friction, 1}, 0.0F);
    for (const auto& [key, v] : {std::pair{"floor_normal", body.floor_normal}, {"floor_along", body.floor_along}})
        if (!(std::abs(std::hypot(v[0], v[1], v[2]) - 1.0F) < 1e-3F))
            folder.fail(kFile, fmt::format("{} has length {}, not 1", key, std::hypot(v[0], v[1], v[2])));
}

/// A literal that reads back to the same bits.
std::string finite_literal(float value) {
    if (!std::isfinite(value)) throw Error("body.json holds a number that is not finite: make the tables again");
    return fmt::format("{:.8e}f", value);
}

std::string finite_literal(std::span<const float> values) {
    std::vector<std::string> list;
    for (const float value : values) list.push_back(finite_literal(value));
    return fmt::format("{{{}}}", fmt::join(list, ", "));
}

}  // namespace

std::optional<haptable_body> read_rigid_body(const TablesFolder& folder) {
    if (!folder.has(kFile)) return {};
    try {
        haptable_body body = body_of(parse_json(read_file(folder.file(kFile))));
        require_sound(folder, body);
        body.motion = motion_of(folder.options());
        body.crc = haptable_crc_of(&body, haptable_span_of_body);
        return body;
    } catch (const json::exception& error) {
        folder.fail(kFile, error.what());
    }
}

void refuse_free_body(const TablesFolder& folder, const char* who) {
    if (!folder.has(kFile)) return;
    throw Error(
        fmt::format("{}: nothing holds its body, and {} cannot move one: remove free = true from [body] of the scene, "
                    "hold the body with [[fixed]] and make the tables again",
                    folder.text(), who));
}

std::string rigid_body_fields(const haptable_body& body) {
    std::string text;
#define HAPTABLE_WRITE(name, ...) text += fmt::format("    .{} = {},\n", #name, finite_literal(body.name));
    HAPTABLE_BODY_FIELDS(HAPTABLE_WRITE, HAPTABLE_WRITE)
    text += fmt::format("    .point_count = {},\n    .point_m = {{", body.point_count);
    for (std::uint32_t i = 0; i < std::max(1U, body.point_count); ++i)
        text += fmt::format("{}{}", i == 0 ? "" : ", ", finite_literal(body.point_m[i]));
    text += "},\n";
    if (body.motion > 0) text += fmt::format("    .motion = {},\n", body.motion);
    return text + fmt::format("    .crc = 0x{:08x}u,\n", body.crc);
}

const char* rigid_part_of(const haptable_body& body) {
    static constexpr const char* kPart[] = {
#define HAPTABLE_PART(PART, ...) #PART,
        HAPTABLE_RIGID_MOVERS(HAPTABLE_PART)};
    return kPart[body.motion];
}

}  // namespace haptable
