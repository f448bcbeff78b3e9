// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/display.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

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
        throw Error(
            fmt::format("{}: tables.display_rows: node {} has no columns: it is fixed, or lies inside (columns = "
                        "\"all\" keeps those)",
                        tables.scene_file, node));
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

std::string header_text() {
    return "/* The display's tables of this scene: see model.h for where they come from. */\n"
           "#ifndef HAPTABLE_DISPLAY_H\n#define HAPTABLE_DISPLAY_H\n\n#include \"haptable_deformation.h\"\n\n";
}

std::string source_text(const Tables& tables, std::uint64_t tables_hash, const Display& display) {
    std::string text =
        fmt::format("/* haptable {}, {}: {} rows of {} vertices, {} bytes of flash */\n#include \"display.h\"\n\n",
                    kVersion, tables.scene_file, display.node.size(), tables.node_id.size(), display.bytes());
    text += fmt::format("static const uint32_t display_node[{}] = {{{}}};\n\n", display.node.size(),
                        fmt::join(display.node, ", "));
    text += fmt::format("static const float display_rest_m[{}][3] = {{\n", display.rest_m.size());
    for (const auto& p : display.rest_m) text += fmt::format("    {{{:.8e}f, {:.8e}f, {:.8e}f}},\n", p[0], p[1], p[2]);
    text += "};\n\n";
    const bool packed = !display.packed.empty();
    if (packed) {
        text += fmt::format("static const int16_t display_packed[{}][9] = {{\n{}}};\n\n", display.packed.size(),
                            rows_text(display.packed));
        text += fmt::format("static const float display_scale_m_per_n[{}] = {{\n", display.packed_scale.size());
        for (const float scale : display.packed_scale) text += fmt::format("    {:.8e}f,\n", scale);
        text += "};\n\n";
    } else {
        text += fmt::format("static const float display_column_m_per_n[{}][9] = {{\n{}}};\n\n", display.column.size(),
                            rows_text(literals(display.column)));
    }
    text += fmt::format(
        "const struct haptable_deformation HAPTABLE_DISPLAY = {{\n    .model_hash = 0x{:016x}ULL,\n"
        "    .row_count = {},\n    .free_count = {},\n    .node = display_node,\n    .rest_m = display_rest_m,\n",
        tables_hash, display.node.size(), tables.node_id.size());
    text += packed ? "    .add = haptable_column_int16,\n    .packed = display_packed,\n"
                     "    .packed_scale_m_per_n = display_scale_m_per_n,\n};\n"
                   : "    .add = haptable_column_float32,\n    .column_m_per_n = display_column_m_per_n,\n};\n";
    return text;
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
    write_file(folder.path() / "display.h",
               header_text() + fmt::format("#define HAPTABLE_DISPLAY_ROWS {}\n\n"
                                           "extern const struct haptable_deformation HAPTABLE_DISPLAY;\n\n#endif\n",
                                           display.node.size()));
    write_file(folder.path() / "display.c", source_text(tables, tables_hash, display));
    return display.bytes();
}

}  // namespace haptable
