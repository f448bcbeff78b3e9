// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/pair.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "codegen/bytes.hpp"
#include "codegen/number.hpp"
#include "codegen/polynomial.hpp"
#include "host/base/error.hpp"
#include "host/base/noise.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Rows = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Out = std::back_insert_iterator<std::string>;

static_assert(kClusterPlaces == HAPTABLE_PAIR_CLUSTER && kMostRank == HAPTABLE_PAIR_RANK &&
              kMostLoaded == HAPTABLE_PAIR_PLACES && kDenseForm == HAPTABLE_PAIR_DENSE &&
              kFineForm == HAPTABLE_PAIR_FINE);

float finite_in_pair(double value) {
    return to_float(value, "the coupling of two fingers holds a number that is not finite");
}

std::array<float, 9> in_float(const Rows& block) {
    std::array<float, 9> to{};
    for (std::size_t i = 0; i < 9; ++i) to[i] = finite_in_pair(block.data()[i]);
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

using PairBlocks = std::vector<std::array<float, 9>>;

/// C_kl by its noise, which is that of C_kk and C_ll however far apart k and l lie.
PairBlocks scaled_blocks(const PairTables& pair, const Scale& scale) {
    PairBlocks to;
    std::vector<double> own;  // largest entry of C_kk
    for (std::size_t k = 0, row = 0; k < pair.control_count && row < pair.block.size(); row += ++k) {
        own.push_back(Eigen::Map<const Rows>(pair.block[row + k].data()).cwiseAbs().maxCoeff());
        const Matrix3d s_k = scale.of(k);
        for (std::size_t l = 0; l <= k; ++l) {
            const double size = std::sqrt(own[k] * own[l]);
            const Rows c = Eigen::Map<const Rows>(pair.block[row + l].data()).unaryExpr([size](double entry) {
                return without_noise(entry, size);
            });
            to.push_back(in_float(s_k * c * scale.of(l)));
        }
    }
    return to;
}

void require_finite(const std::vector<float>& values) {
    for (const float value : values) finite_in_pair(value);
}

template <typename Rows_>
void define(const char* type, const char* name, const char* extent, const Rows_& rows, std::string& text) {
    if (rows.empty()) return;
    fmt::format_to(Out(text), "static const {} pair_{}[{}]{} = {{\n", type, name, rows.size(), extent);
    std::size_t column = 0;
    for (const auto& row : rows) {
        if constexpr (std::is_integral_v<std::decay_t<decltype(row)>>) {
            fmt::format_to(Out(text), "{}{}", +row, ++column % 24 == 0 ? ",\n" : ",");
        } else if constexpr (std::is_floating_point_v<std::decay_t<decltype(row)>>) {
            fmt::format_to(Out(text), "    {:#.9g}f,\n", row);
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

/// A force law for two.
struct PairLaw {
    const char* name;
    const haptable_pair_law* law;
    const haptable_pair_bend* bend;
};
#define HAPTABLE_LAW(name) \
    { #name, &haptable_pair_##name, &haptable_pair_bend_##name }
#define HAPTABLE_STIFFENING(name) \
    { "stiffening_" #name, &haptable_pair_stiffening_##name, &haptable_pair_bend_stiffening_##name }
/// By force, whether the tables are packed, whether dents stiffen.
constexpr PairLaw kPairLaw[][2][2] = {
#define HAPTABLE_FORCE_LAW(NAME, WORD, TITLE, FUNCTION, PACKED, ...) \
    {{HAPTABLE_LAW(FUNCTION), HAPTABLE_STIFFENING(FUNCTION)}, {HAPTABLE_LAW(PACKED), HAPTABLE_STIFFENING(PACKED)}},
#include "host/base/laws.inc"
};
#undef HAPTABLE_STIFFENING
#undef HAPTABLE_LAW

const PairLaw& pair_law_of(const Tables& tables, const haptable_model& model) {
    return kPairLaw[static_cast<std::size_t>(tables.force)][tables.precision != Storage::kFloat32]
                   [model.stiffen != nullptr];
}

template <typename T>
const T* rows_or_none(const std::vector<T>& rows) {
    return rows.empty() ? nullptr : rows.data();
}

/// Loads by the servo's patches, which are in another order than the scene's.
void order_loads(const PairClusters& from, const std::vector<std::size_t>& leaf_order, ServoPair& to) {
    if (from.load_begin.size() != leaf_order.size() + 1)
        throw Error(
            fmt::format("coupling_load_begin.npy is of {} patches and the surface has {}: make the tables again",
                        from.load_begin.size() - 1, leaf_order.size()));
    to.clusters.load_share.clear();
    to.load_begin.push_back(0);
    for (const std::size_t patch : leaf_order) {
        for (auto i = static_cast<std::size_t>(from.load_begin[patch]);
             i < static_cast<std::size_t>(from.load_begin[patch + 1]); ++i) {
            to.load_place.push_back(static_cast<std::uint16_t>(from.load_place[i]));
            to.clusters.load_share.push_back(from.load_share[i]);
        }
        to.load_begin.push_back(static_cast<std::uint32_t>(to.load_place.size()));
    }
}

void point_to_clusters(const ServoPair& pair, haptable_pair_model& to) {
    const PairClusters& c = pair.clusters;
    to.place_count = static_cast<std::uint16_t>(c.places());
    to.load_count = static_cast<std::uint16_t>(pair.load_begin.empty() ? 0 : pair.load_begin.size() - 1);
    to.rank = static_cast<std::uint16_t>(c.rank);
    to.scale = c.scale.data();
    to.basis = reinterpret_cast<const std::int16_t(*)[3]>(rows_or_none(c.basis));
    to.core_begin = c.begin.data();
    to.core_step = c.step.data();
    to.core_form = c.form.data();
    to.core = rows_or_none(c.core);
    to.fine_count = static_cast<std::uint32_t>(c.fine.size());
    to.fine = reinterpret_cast<const std::int16_t(*)[9]>(rows_or_none(c.fine));
    to.place = rows_or_none(pair.place);
    to.load_begin = rows_or_none(pair.load_begin);
    to.load_place = rows_or_none(pair.load_place);
    to.load_share = reinterpret_cast<const std::int16_t(*)[6]>(rows_or_none(c.load_share));
}

}  // namespace

ServoPair build_pair(const PairTables& pair, const Tables& tables, const ServoModel& servo) {
    const std::size_t controls = tables.force == ForceLaw::kPressureMask
                                     ? servo.node.size() + tables.compliance.edge_id.size()
                                     : servo.free_count;
    if (pair.control_count != controls)
        throw Error(fmt::format("coupling.npy couples {} places and the surface has {}: make the tables again",
                                pair.control_count, controls));
    const Scale scale(tables, servo);
    ServoPair to;
    to.block = scaled_blocks(pair, scale);
    to.clusters = pair.clusters;
    require_finite(to.clusters.scale);
    require_finite(to.clusters.step);
    to.place.assign(pair.clusters.place.begin(), pair.clusters.place.end());
    if (!pair.clusters.load_begin.empty()) order_loads(pair.clusters, servo.leaf_order, to);
    to.control_count = static_cast<std::uint16_t>(controls);
    to.finger_count = pair.finger_count;
    to.meeting_m = finite_in_pair(pair.meeting_m);
    return to;
}

haptable_pair_model pair_in_memory(const ServoPair& pair, const Tables& tables, const haptable_model& model) {
    haptable_pair_model to{};
    to.model = &model;
    to.law = pair_law_of(tables, model).law;
    if (model.energy != nullptr) {
        to.bend = pair_law_of(tables, model).bend;
        to.energy = haptable_pair_energy;
        if (model.frictionless == nullptr) to.settle = haptable_pair_settle;
    }
    to.cross = pair.is_exact() ? haptable_pair_cross_exact : haptable_pair_cross_clusters;
    to.blocks = pair.is_exact() ? haptable_pair_blocks_exact : haptable_pair_blocks_clusters;
    to.span = haptable_span_of_pair;
    to.meeting_m = pair.meeting_m;
    to.control_count = pair.control_count;
    to.finger_count = pair.finger_count;
    to.block = reinterpret_cast<const float(*)[9]>(pair.block.data());
    if (!pair.is_exact()) point_to_clusters(pair, to);
    to.crc = model.check != nullptr ? haptable_crc_of(&to, to.span) : 0;
    return to;
}

std::string coupling_bytes(const haptable_pair_model& from) {
#define HAPTABLE_LAW(name) &haptable_pair_##name, &haptable_pair_stiffening_##name,
    constexpr const haptable_pair_law* kInOrder[] = {HAPTABLE_PAIR_LAWS(HAPTABLE_LAW)};
#undef HAPTABLE_LAW
    const auto law = static_cast<std::uint32_t>((std::ranges::find(kInOrder, from.law) - std::begin(kInOrder)) / 2);
    const std::uint32_t control_count = from.control_count, place_count = from.place_count,
                        load_count = from.load_count, rank = from.rank, fine_count = from.fine_count;
    const std::uint32_t *const core_begin = from.core_begin, *const load_begin = from.load_begin;
    Bytes bytes;
    bytes.add(law);
    HAPTABLE_PAIR_FIELDS(HAPTABLE_ADD_VALUE, HAPTABLE_ADD_TABLE)
    return bytes.take();
}

std::vector<TableBytes> flash_tables(const ServoPair& pair) {
    std::vector<TableBytes> tables;
    const auto add = [&](const char* name, const auto& rows) {
        if (!rows.empty()) tables.push_back({name, rows.size() * sizeof rows[0]});
    };
    add("pair_block", pair.block);
    const PairClusters& c = pair.clusters;
    add("pair_scale", c.scale);
    add("pair_basis", c.basis);
    add("pair_core_begin", c.begin);
    add("pair_core_step", c.step);
    add("pair_core_form", c.form);
    add("pair_core", c.core);
    add("pair_fine", c.fine);
    add("pair_place", pair.place);
    add("pair_load_begin", pair.load_begin);
    add("pair_load_place", pair.load_place);
    add("pair_load_share", c.load_share);
    return tables;
}

void add_pair_values(const ServoPair& pair, const Tables& tables, const haptable_model& model, TemplateValues& values) {
    const haptable_pair_model to = pair_in_memory(pair, tables, model);
    const PairClusters& c = pair.clusters;
    std::string text, fields;
    define("float", "block", "[9]", pair.block, text);
    define("float", "scale", "", c.scale, text);
    define("int16_t", "basis", "[3]", c.basis, text);
    define("uint32_t", "core_begin", "", c.begin, text);
    define("float", "core_step", "", c.step, text);
    define("uint8_t", "core_form", "", c.form, text);
    define("int8_t", "core", "", c.core, text);
    define("int16_t", "fine", "[9]", c.fine, text);
    define("uint16_t", "place", "", pair.place, text);
    define("uint32_t", "load_begin", "", pair.load_begin, text);
    define("uint16_t", "load_place", "", pair.load_place, text);
    define("int16_t", "load_share", "[6]", c.load_share, text);
    for (const TableBytes& table : flash_tables(pair))
        fmt::format_to(Out(fields), "    .{} = {},\n", table.name.substr(5), table.name);
    const auto flag = [](bool is_set) { return is_set ? "yes" : ""; };
    values["pair_version"] = std::to_string(HAPTABLE_PAIR_VERSION);
    values["pair_tables"] = text;
    values["pair_law"] = pair_law_of(tables, model).name;
    values["pair_energy"] = flag(to.energy != nullptr);
    values["pair_settle"] = flag(to.settle != nullptr);
    values["pair_form"] = pair.is_exact() ? "exact" : "clusters";
    values["pair_crc"] = model.check != nullptr ? fmt::format("{:08x}", to.crc) : "";
    values["pair_meeting_m"] = fmt::format("{:#.9g}", pair.meeting_m);
    values["pair_control_count"] = std::to_string(pair.control_count);
    values["pair_place_count"] = std::to_string(to.place_count);
    values["pair_load_count"] = std::to_string(to.load_count);
    values["pair_rank"] = pair.is_exact() ? "" : std::to_string(to.rank);
    values["pair_fields"] = fields;
    values["points_settle"] = flag(model.energy != nullptr || model.frictionless != nullptr);
    values["pair_fine_count"] = std::to_string(to.fine_count);
    values["pair_finger_count"] = std::to_string(to.finger_count);
}

}  // namespace haptable
