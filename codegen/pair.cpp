// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/pair.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "codegen/polynomial.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Out = std::back_insert_iterator<std::string>;

float finite(double value) {
    const auto narrow = static_cast<float>(value);
    if (!std::isfinite(narrow)) throw Error("the coupling of two fingers holds a number that is not finite");
    return narrow;
}

std::array<float, 9> in_float(const Rows& block) {
    std::array<float, 9> to{};
    for (std::size_t i = 0; i < 9; ++i) to[i] = finite(block.data()[i]);
    return to;
}

/// S of a control where the force is interpolated, else 1.
class Scale {
public:
    Scale(const Tables& tables, const ServoModel& servo)
        : is_stiffness_(tables.force == ForceLaw::kInterpolated), servo_(servo) {}
    Matrix3d of(std::size_t control) const {
        return is_stiffness_ ? Matrix3d(symmetric(servo_.stiffness_n_per_m[control])) : Matrix3d::Identity();
    }

private:
    bool is_stiffness_;
    const ServoModel& servo_;
};

using Blocks = std::vector<std::array<float, 9>>;

Blocks scaled_blocks(const PairTables& pair, const Scale& scale) {
    Blocks to;
    for (std::size_t k = 0, i = 0; k < pair.control_count; ++k) {
        const Matrix3d s_k = scale.of(k);
        const std::size_t first = pair.is_exact() ? 0 : pair.near_begin[k];
        const std::size_t count = pair.is_exact() ? k + 1 : pair.near_begin[k + 1] - first;
        for (std::size_t j = 0; j < count; ++j, ++i) {
            const std::size_t l = pair.is_exact() ? j : static_cast<std::size_t>(pair.near[first + j]);
            to.push_back(in_float(s_k * Eigen::Map<const Rows>(pair.block[i].data()) * scale.of(l)));
        }
    }
    return to;
}

std::vector<std::array<float, 3>> scaled_columns(const PairTables& pair, const Scale& scale) {
    std::vector<std::array<float, 3>> to;
    for (std::size_t k = 0; k < pair.control_count; ++k) {
        const Matrix3d s_k = scale.of(k);
        for (std::size_t r = 0; r < pair.rank; ++r) {
            const Eigen::Vector3d v = s_k * Eigen::Map<const Eigen::Vector3d>(pair.column[k * pair.rank + r].data());
            to.push_back({finite(v[0]), finite(v[1]), finite(v[2])});
        }
    }
    return to;
}

/// In 16 bits: integers and their step.
template <std::size_t k>
float in_steps(const std::vector<std::array<float, k>>& rows, std::vector<std::array<std::int16_t, k>>& to) {
    constexpr float kMost = 32767.0F;
    float largest = 0.0F;
    for (const auto& row : rows)
        for (const float value : row) largest = std::max(largest, std::abs(value));
    const float step = largest > 0.0F ? largest / kMost : 1.0F;
    for (const auto& row : rows) {
        auto& steps = to.emplace_back();
        for (std::size_t i = 0; i < k; ++i) steps[i] = static_cast<std::int16_t>(std::lround(row[i] / step));
    }
    return step;
}

template <typename Rows_>
void define(const char* type, const char* name, const char* extent, const Rows_& rows, std::string& text) {
    if (rows.empty()) return;
    fmt::format_to(Out(text), "static const {} pair_{}[{}]{} = {{\n", type, name, rows.size(), extent);
    for (const auto& row : rows) {
        if constexpr (std::is_integral_v<std::decay_t<decltype(row)>>) {
            fmt::format_to(Out(text), "    {},\n", row);
        } else {
            text += "    {";
            for (std::size_t i = 0; i < row.size(); ++i) {
                if (i > 0) text += ", ";
                if constexpr (std::is_integral_v<std::decay_t<decltype(row[i])>>)
                    fmt::format_to(Out(text), "{}", row[i]);
                else
                    fmt::format_to(Out(text), "{:#.9g}f", row[i]);
            }
            text += "},\n";
        }
    }
    text += "};\n\n";
}

const char* law_of(ForceLaw force) {
    static constexpr const char* kLaw[] = {"interpolated", "consistent", "pressure_mask"};
    return kLaw[static_cast<std::size_t>(force)];
}

}  // namespace

ServoPair build_pair(const PairTables& pair, const Tables& tables, const ServoModel& servo) {
    const std::size_t controls = tables.force == ForceLaw::kPressureMask
                                     ? servo.node.size() + tables.compliance.edge_id.size()
                                     : servo.free_count;
    if (pair.control_count != controls)
        throw Error(fmt::format("coupling.npy couples {} places and the surface has {}: make the tables again",
                                pair.control_count, controls));
    if (tables.force != ForceLaw::kInterpolated && !servo.packed.empty())
        throw Error("two fingers read a compliance in float32: remove precision in [tables]");
    const Scale scale(tables, servo);
    ServoPair to;
    Blocks blocks = scaled_blocks(pair, scale);
    if (pair.is_exact()) {
        to.block = std::move(blocks);
    } else {
        to.near_step = in_steps(blocks, to.near_block);
        to.column_step = in_steps(scaled_columns(pair, scale), to.column);
    }
    to.near_begin = pair.near_begin;
    to.near.assign(pair.near.begin(), pair.near.end());
    to.control_count = static_cast<std::uint16_t>(controls);
    to.rank = static_cast<std::uint16_t>(pair.rank);
    to.meeting_m = finite(pair.meeting_m);
    return to;
}

haptable_pair_model pair_in_memory(const ServoPair& pair, const Tables& tables, const haptable_model& model) {
    static constexpr const haptable_pair_law* kLaw[] = {&haptable_pair_interpolated, &haptable_pair_consistent,
                                                        &haptable_pair_pressure_mask};
    static constexpr const haptable_pair_bend* kBend[] = {
        &haptable_pair_bend_interpolated, &haptable_pair_bend_consistent, &haptable_pair_bend_pressure_mask};
    haptable_pair_model to{};
    to.model = &model;
    to.law = kLaw[static_cast<std::size_t>(tables.force)];
    if (model.energy != nullptr) {
        to.bend = kBend[static_cast<std::size_t>(tables.force)];
        to.energy = haptable_pair_energy;
        if (model.frictionless == nullptr) to.settle = haptable_pair_settle;
        to.track = haptable_pair_track;
    }
    to.cross = pair.rank == 0 ? haptable_pair_cross_exact : haptable_pair_cross_low_rank;
    to.far = pair.rank == 0 ? nullptr : haptable_pair_far_low_rank;
    to.blocks = pair.rank == 0 ? haptable_pair_blocks_exact : haptable_pair_blocks_low_rank;
    to.check = model.check != nullptr ? haptable_pair_check_crc : nullptr;
    if (model.frictionless != nullptr) {
        pair.freed_in_memory.push_back(std::make_shared<haptable_freed>());
        to.freed = pair.freed_in_memory.back().get();
    }
    to.meeting_m = pair.meeting_m;
    to.control_count = pair.control_count;
    to.rank = pair.rank;
    to.block = reinterpret_cast<const float(*)[9]>(pair.block.data());
    to.near_begin = pair.near_begin.data();
    to.near = pair.near.data();
    to.near_block = reinterpret_cast<const std::int16_t(*)[9]>(pair.near_block.data());
    to.column = reinterpret_cast<const std::int16_t(*)[3]>(pair.column.data());
    to.near_step = pair.near_step;
    to.column_step = pair.column_step;
    to.crc = to.check != nullptr ? haptable_pair_crc(&to) : 0;
    return to;
}

std::string coupling_bytes(const haptable_pair_model& from) {
    std::string bytes;
    const auto add = [&](const auto* rows, std::size_t count) {
        bytes.append(reinterpret_cast<const char*>(rows), count * sizeof *rows);
    };
    const auto add_table = [&](const auto* rows, std::size_t count) {
        const auto length = static_cast<std::uint32_t>(count);
        add(&length, 1);
        if (count > 0) add(rows, count);
    };
    const haptable_pair_law* const laws[] = {&haptable_pair_interpolated, &haptable_pair_consistent,
                                             &haptable_pair_pressure_mask};
    const auto law = static_cast<std::uint32_t>(std::find(std::begin(laws), std::end(laws), from.law) - laws);
    const int control_count = from.control_count, rank = from.rank;
    const std::uint32_t* const near_begin = from.near_begin;
    add(&law, 1);
// NOLINTBEGIN(bugprone-macro-parentheses): names that are declared
#define HAPTABLE_ADD_VALUE(type, name) add(&from.name, 1);
#define HAPTABLE_ADD_TABLE(type, name, count) add_table(from.name, static_cast<std::size_t>(count));
    // NOLINTEND(bugprone-macro-parentheses)
    HAPTABLE_PAIR_FIELDS(HAPTABLE_ADD_VALUE, HAPTABLE_ADD_TABLE)
    return bytes;
}

std::vector<TableBytes> flash_tables(const ServoPair& pair) {
    std::vector<TableBytes> tables;
    const auto add = [&](const char* name, const auto& rows) {
        if (!rows.empty()) tables.push_back({name, rows.size() * sizeof rows[0]});
    };
    add("pair_block", pair.block);
    add("pair_near_begin", pair.near_begin);
    add("pair_near", pair.near);
    add("pair_near_block", pair.near_block);
    add("pair_column", pair.column);
    return tables;
}

std::string pair_text(const ServoPair& pair, const Tables& tables, const haptable_model& model,
                      const std::string& name) {
    const haptable_pair_model to = pair_in_memory(pair, tables, model);
    std::string text = fmt::format(
        "/* Two fingers: what couples two places. */\n#include \"haptable_pair.h\"\n\n"
        "#if HAPTABLE_PAIR_VERSION != {}\n"
        "#error \"these tables are for another version of haptable's servo: make them again\"\n#endif\n\n",
        HAPTABLE_PAIR_VERSION);
    define("float", "block", "[9]", pair.block, text);
    define("uint32_t", "near_begin", "", pair.near_begin, text);
    define("uint16_t", "near", "", pair.near, text);
    define("int16_t", "near_block", "[9]", pair.near_block, text);
    define("int16_t", "column", "[3]", pair.column, text);
    if (to.freed != nullptr) text += "static struct haptable_freed freed_of_second;\n\n";
    fmt::format_to(Out(text), "const struct haptable_pair_model {}_pair = {{\n    .model = &{},\n", name, name);
    fmt::format_to(Out(text), "    .law = &haptable_pair_{},\n", law_of(tables.force));
    if (to.energy != nullptr)
        fmt::format_to(Out(text), "    .bend = &haptable_pair_bend_{},\n    .energy = haptable_pair_energy,\n",
                       law_of(tables.force));
    if (to.freed != nullptr) text += "    .freed = &freed_of_second,\n";
    if (to.settle != nullptr) text += "    .settle = haptable_pair_settle,\n";
    if (to.track != nullptr) text += "    .track = haptable_pair_track,\n";
    const char* rank = pair.rank == 0 ? "exact" : "low_rank";
    fmt::format_to(Out(text), "    .cross = haptable_pair_cross_{0},\n    .blocks = haptable_pair_blocks_{0},\n", rank);
    if (pair.rank != 0) text += "    .far = haptable_pair_far_low_rank,\n";
    if (to.check != nullptr)
        fmt::format_to(Out(text), "    .check = haptable_pair_check_crc,\n    .crc = 0x{:08x}u,\n", to.crc);
    fmt::format_to(Out(text), "    .meeting_m = {:#.9g}f,\n    .control_count = {},\n    .rank = {},\n", pair.meeting_m,
                   pair.control_count, pair.rank);
    if (pair.rank != 0)
        fmt::format_to(Out(text), "    .near_step = {:#.9g}f,\n    .column_step = {:#.9g}f,\n", pair.near_step,
                       pair.column_step);
    for (const TableBytes& table : flash_tables(pair))
        fmt::format_to(Out(text), "    .{} = {},\n", table.name.substr(5), table.name);
    return text + "};\n";
}

}  // namespace haptable
