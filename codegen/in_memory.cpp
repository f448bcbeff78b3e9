// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/in_memory.hpp"

#include <algorithm>

#include "codegen/laws.hpp"
#include "codegen/model_bytes.hpp"
#include "firmware/haptable_scene.h"
#include "host/base/hash.hpp"

namespace haptable {

namespace {

/// std::array<T, k> has the layout of T[k].
template <typename Row, typename Value>
const Row* as_rows(const std::vector<Value>& values) {
    static_assert(sizeof(Row) == sizeof(Value));
    return values.empty() ? nullptr : reinterpret_cast<const Row*>(values.data());
}

#define HAPTABLE_COPY(type, name) to.name = from.name;
#define HAPTABLE_POINT(type, name, count) to.name = as_rows<type>(from.name);
#define HAPTABLE_LEAVE(...)

haptable_compliance compliance_in_memory(const ServoCompliance& from) {
    haptable_compliance to{};
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_COPY, HAPTABLE_POINT)
    to.span = haptable_span_of_compliance;
    return to;
}

/// An earlier model of the same tables goes on to point to what it has.
void keep_in_memory(const haptable_compliance& made, std::shared_ptr<haptable_compliance>& kept) {
#define HAPTABLE_SAME(type, name, ...) &&kept->name == made.name
    const bool is_same = kept != nullptr HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_SAME, HAPTABLE_SAME);
#undef HAPTABLE_SAME
    if (!is_same) kept = std::make_shared<haptable_compliance>(made);
}

/// A model with its tables, and nothing else yet.
haptable_model tables_in_memory(const ServoTables& from) {
    haptable_model to{};
    HAPTABLE_MODEL_FIELDS(HAPTABLE_LEAVE, HAPTABLE_POINT, HAPTABLE_LEAVE, HAPTABLE_LEAVE)
    return to;
}
#undef HAPTABLE_COPY
#undef HAPTABLE_POINT
#undef HAPTABLE_LEAVE

std::uint64_t hash_of(const haptable_model& model, const Tables& tables, const ServoModel& servo) {
    Hash hash;
    hash.add(std::span<const std::uint64_t>(&tables.model_hash, 1));
    hash.add(model_bytes(model));
    hash.add(std::span<const std::int32_t>(servo.node));
    return hash.digest();
}

}  // namespace

haptable_model model_in_memory(const Tables& tables, const ServoModel& servo) {
    haptable_model model = tables_in_memory(servo);
    model.max_force_n = static_cast<float>(tables.max_force_n);
    model.rigid_stiffness_n_per_m = servo.rigid_stiffness_n_per_m;
    model.tolerance_m = servo.tolerance_m;
    model.workspace_limit_m = servo.workspace_limit_m;
    std::copy(servo.grid_origin_m.begin(), servo.grid_origin_m.end(), model.grid_origin_m);
    model.grid_per_m = servo.grid_per_m;
    model.vertex_count = static_cast<std::uint16_t>(servo.vertex_m.size());
    model.free_count = static_cast<std::uint16_t>(servo.free_count);
    model.patch_count = static_cast<std::uint16_t>(servo.patch.size());
    model.box_count = static_cast<std::uint16_t>(servo.box.size());
    model.hinge_count = static_cast<std::uint16_t>(servo.hinge.size());
    model.packed_count = static_cast<std::uint32_t>(servo.packed.size());
    model.scale_count = static_cast<std::uint32_t>(servo.packed_scale.size());
    haptable_model_surface(&model);
    model.stiffness_limit_n_per_m = static_cast<float>(servo.stiffness.felt_n_per_m);
    if (!servo.packed.empty()) model.unpack = unpack_of(tables.precision);
    if (!servo.reads_stiffness()) model.stiffness_n_per_m = nullptr;
    set_laws(tables, model);
    model.term_count = static_cast<std::uint8_t>(servo.term.size());
    model.relaxation_reach_m = servo.relaxation_reach_m;
    haptable_lay_out(&model);
    if (servo.compliance.degree != 0) {
        haptable_compliance compliance = compliance_in_memory(servo.compliance);
        if (!servo.reads_compliance()) compliance.vertex = compliance.edge = compliance.patch = nullptr;
        keep_in_memory(compliance, servo.compliance.in_memory);
        model.compliance = servo.compliance.in_memory.get();
    }
    model.crc = model.check ? haptable_crc_of(&model, haptable_span_of_model) : 0;
    model.hash = hash_of(model, tables, servo);
    return model;
}

}  // namespace haptable
