// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/in_memory.hpp"

#include <algorithm>
#include <cstddef>

#include "codegen/modes.hpp"

namespace haptable {

// std::array<T, k> has the layout of T[k], IndexBox that of struct haptable_box, Hinge that of struct haptable_hinge.
static_assert(sizeof(std::array<float, 3>) == sizeof(float[3]) && sizeof(IndexBox) == sizeof(haptable_box));
static_assert(offsetof(IndexBox, skip) == offsetof(haptable_box, skip) &&
              offsetof(IndexBox, patch) == offsetof(haptable_box, patch));
static_assert(sizeof(Hinge) == sizeof(haptable_hinge) && offsetof(Hinge, ring) == offsetof(haptable_hinge, ring));

namespace {

haptable_compliance compliance_in_memory(const ServoCompliance& from) {
    haptable_compliance to{};
    to.degree = static_cast<std::uint8_t>(from.degree);
    to.edge_count = static_cast<std::uint16_t>(from.edge_count);
    to.vertex = reinterpret_cast<const float(*)[6]>(from.vertex_m_per_n.data());
    to.edge = reinterpret_cast<const float(*)[6]>(from.edge_m_per_n.data());
    to.patch = reinterpret_cast<const float(*)[6]>(from.patch_m_per_n.data());
    to.patch_edge = reinterpret_cast<const std::uint16_t(*)[3]>(from.patch_edge.data());
    return to;
}

}  // namespace

haptable_model model_in_memory(const Tables& tables, const ServoModel& servo) {
    haptable_model model{};
    model.hash = tables.model_hash;
    model.max_force_n = static_cast<float>(tables.max_force_n);
    model.rigid_stiffness_n_per_m = servo.rigid_stiffness_n_per_m;
    model.tolerance_m = servo.tolerance_m;
    model.workspace_limit_m = servo.workspace_limit_m;
    std::copy(servo.index.origin_m.begin(), servo.index.origin_m.end(), model.grid_origin_m);
    model.grid_per_m = servo.index.per_m;
    model.vertex_count = static_cast<std::uint16_t>(servo.vertex_m.size());
    model.free_count = static_cast<std::uint16_t>(servo.free_count);
    model.patch_count = static_cast<std::uint16_t>(servo.patch.size());
    model.box_count = static_cast<std::uint16_t>(servo.index.boxes.size());
    model.hinge_count = static_cast<std::uint16_t>(servo.hinge.size());
    model.vertex_m = reinterpret_cast<const float(*)[3]>(servo.vertex_m.data());
    model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(servo.stiffness_n_per_m.data());
    model.packed = reinterpret_cast<const std::uint16_t(*)[6]>(servo.packed.data());
    model.packed_scale_n_per_m = servo.packed_scale_n_per_m.data();
    model.patch = reinterpret_cast<const std::uint16_t(*)[3]>(servo.patch.data());
    model.neighbour = reinterpret_cast<const std::uint16_t(*)[3]>(servo.neighbour.data());
    model.box = reinterpret_cast<const haptable_box*>(servo.index.boxes.data());
    if (!servo.hinge.empty()) model.hinge = reinterpret_cast<const haptable_hinge*>(servo.hinge.data());
    model.stiffness_limit_n_per_m = static_cast<float>(servo.stiffness.felt_n_per_m);
    model.unpack = servo.packed.empty() ? nullptr : modes_of(tables).unpack.function;
    set_modes(tables, model);
    if (servo.compliance.degree != 0) {
        servo.compliance.in_memory = std::make_shared<haptable_compliance>(compliance_in_memory(servo.compliance));
        model.compliance = servo.compliance.in_memory.get();
    }
    return model;
}

}  // namespace haptable
