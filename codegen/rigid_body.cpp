// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/rigid_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

using nlohmann::json;

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

/// A literal that reads back to the same bits.
std::string literal(float value) {
    if (!std::isfinite(value)) throw Error("body.json holds a number that is not finite: make the tables again");
    return fmt::format("{:.8e}f", value);
}

std::string literal(std::span<const float> values) {
    std::vector<std::string> list;
    for (const float value : values) list.push_back(literal(value));
    return fmt::format("{{{}}}", fmt::join(list, ", "));
}

}  // namespace

std::optional<haptable_body> read_rigid_body(const std::filesystem::path& folder) {
    const std::filesystem::path path = folder / "body.json";
    if (!std::filesystem::exists(path)) return {};
    try {
        return body_of(parse_json(read_file(path)));
    } catch (const json::exception& error) {
        throw Error(fmt::format("{}: {}: make the tables again", path.string(), error.what()));
    }
}

void refuse_free_body(const std::filesystem::path& folder, const char* who) {
    if (!std::filesystem::exists(folder / "body.json")) return;
    throw Error(
        fmt::format("{}: nothing holds its body, and {} cannot move one: remove free = true from [body] of the scene, "
                    "hold the body with [[fixed]] and make the tables again",
                    folder.string(), who));
}

std::string rigid_body_text(const haptable_body& body, const std::string& name) {
    std::string text = fmt::format("const struct haptable_body {} = {{\n", name);
#define HAPTABLE_WRITE(name, ...) text += fmt::format("    .{} = {},\n", #name, literal(body.name));
    HAPTABLE_BODY_FIELDS(HAPTABLE_WRITE, HAPTABLE_WRITE)
    text += fmt::format("    .point_count = {},\n    .point_m = {{", body.point_count);
    for (std::uint32_t i = 0; i < std::max(1U, body.point_count); ++i)
        text += fmt::format("{}{}", i == 0 ? "" : ", ", literal(body.point_m[i]));
    return text + "},\n};\n";
}

}  // namespace haptable
