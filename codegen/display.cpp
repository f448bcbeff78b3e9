// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/display.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "codegen/template.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/tables/columns.hpp"

namespace haptable {

namespace {

constexpr float kSteps = 32767.0F;

std::size_t row_of(const Tables& tables, std::int32_t node) {
    const auto at = std::find(tables.row_id.begin(), tables.row_id.end(), node);
    if (at == tables.row_id.end())
        throw Error(fmt::format("{}: tables.display_rows: node {} has no columns", tables.scene_file, node));
    return static_cast<std::size_t>(at - tables.row_id.begin());
}

/// A vertex' blocks in steps of its largest entry / 32767.
void pack(std::span<const std::array<float, 9>> blocks, Display& display) {
    float most = 0.0F;
    for (const auto& block : blocks)
        for (const float value : block) most = std::max(most, std::abs(value));
    const float scale = most > 0.0F ? most / kSteps : 1.0F;
    display.packed_scale.push_back(scale);
    for (const auto& block : blocks) {
        auto& packed = display.packed.emplace_back();
        for (std::size_t i = 0; i < 9; ++i)
            packed[i] = static_cast<std::int16_t>(std::clamp(std::round(block[i] / scale), -kSteps, kSteps));
    }
}

template <typename Rows>
std::string rows_text(const Rows& rows) {
    std::string text;
    for (const auto& row : rows) text += fmt::format("    {{{}}},\n", fmt::join(row, ", "));
    return text;
}

/// Floats as literals that read back to the same bits.
std::vector<std::vector<std::string>> literals(std::span<const std::array<float, 9>> rows) {
    std::vector<std::vector<std::string>> texts;
    for (const auto& row : rows) {
        auto& text = texts.emplace_back();
        for (const float value : row) text.push_back(fmt::format("{:.8e}f", value));
    }
    return texts;
}

// Each begins with a line's end.
constexpr const char* kHeader =
#include "codegen/display.h.in"
    ;
constexpr const char* kSource =
#include "codegen/display.c.in"
    ;

TemplateValues values_of(const Tables& tables, std::uint64_t tables_hash, const Display& display) {
    std::string rest_m, scale;
    for (const auto& p : display.rest_m)
        rest_m += fmt::format("    {{{:.8e}f, {:.8e}f, {:.8e}f}},\n", p[0], p[1], p[2]);
    for (const float value : display.packed_scale) scale += fmt::format("    {:.8e}f,\n", value);
    return {{"version", kVersion},
            {"scene_file", tables.scene_file},
            {"hash", fmt::format("{:016x}", tables_hash)},
            {"rows", std::to_string(display.node.size())},
            {"vertices", std::to_string(tables.node_id.size())},
            {"bytes", std::to_string(display.bytes())},
            {"blocks", std::to_string(std::max(display.packed.size(), display.column.size()))},
            {"node", fmt::format("{}", fmt::join(display.node, ", "))},
            {"rest_m", rest_m},
            {"packed", rows_text(display.packed)},
            {"scale", scale},
            {"column", rows_text(literals(display.column))}};
}

}  // namespace

std::size_t Display::bytes() const {
    return node.size() * 4 + rest_m.size() * 12 + column.size() * 36 + packed.size() * 18 + packed_scale.size() * 4;
}

Display build_display(const TablesFolder& folder, const Tables& tables) {
    Display display;
    std::vector<std::size_t> row;
    for (const std::int32_t node : tables.display_rows) {
        row.push_back(row_of(tables, node));
        const auto& p = tables.position[static_cast<std::size_t>(node)];
        display.node.push_back(static_cast<std::uint32_t>(node));
        display.rest_m.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])});
    }
    const MappedColumns columns(tables, folder);
    std::vector<std::array<float, 9>> blocks(row.size());
    // The servo's free vertices stand in table order, as the columns do.
    for (std::size_t vertex = 0; vertex < tables.node_id.size(); ++vertex) {
        for (std::size_t r = 0; r < row.size(); ++r)
            for (std::size_t k = 0; k < 9; ++k) blocks[r][k] = columns.at(columns.block(vertex, row[r]) + k);
        if (tables.display_precision == Storage::kInt16)
            pack(blocks, display);
        else
            display.column.insert(display.column.end(), blocks.begin(), blocks.end());
    }
    return display;
}

haptable_deformation display_in_memory(const Tables& tables, std::uint64_t tables_hash, const Display& display) {
    haptable_deformation deformation{};
    deformation.model_hash = tables_hash;
    deformation.row_count = static_cast<std::uint16_t>(display.node.size());
    deformation.free_count = static_cast<std::uint16_t>(tables.node_id.size());
    deformation.node = display.node.data();
    deformation.rest_m = reinterpret_cast<const float(*)[3]>(display.rest_m.data());
    deformation.add = display.packed.empty() ? haptable_column_float32 : haptable_column_int16;
    deformation.column_m_per_n = reinterpret_cast<const float(*)[9]>(display.column.data());
    deformation.packed = reinterpret_cast<const std::int16_t(*)[9]>(display.packed.data());
    deformation.packed_scale_m_per_n = display.packed_scale.data();
    return deformation;
}

std::size_t write_display(const TablesFolder& folder, const Tables& tables, std::uint64_t tables_hash) {
    const Display display = build_display(folder, tables);
    const TemplateValues values = values_of(tables, tables_hash, display);
    write_file(folder.path() / "display.h", filled(kHeader + 1, values));
    write_file(folder.path() / "display.c", filled(kSource + 1, values));
    return display.bytes();
}

}  // namespace haptable
