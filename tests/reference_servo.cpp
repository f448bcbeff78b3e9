// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/reference_servo.hpp"

#include <stdint.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace haptable::test::reference {

// haptable.h declares these with C linkage: other names, or they would be the float ones.
#define haptable_servo_init reference_init
#define haptable_servo_begin reference_begin
#define haptable_servo_step reference_step
#define haptable_servo_watch reference_watch
#define haptable_servo_buttons reference_buttons
#define haptable_god_object_nearest reference_god_object_nearest
#define haptable_god_object_least_energy reference_god_object_least_energy
#define haptable_force_interpolated reference_force_interpolated
#define haptable_force_consistent reference_force_consistent
#define haptable_force_consistent_packed reference_force_consistent_packed
#define haptable_force_pressure_mask reference_force_pressure_mask
#define haptable_force_pressure_mask_packed reference_force_pressure_mask_packed
#define haptable_force_of_least_energy reference_force_of_least_energy
#define haptable_energy_interpolated reference_energy_interpolated
#define haptable_energy_consistent reference_energy_consistent
#define haptable_energy_consistent_packed reference_energy_consistent_packed
#define haptable_energy_pressure_mask reference_energy_pressure_mask
#define haptable_energy_pressure_mask_packed reference_energy_pressure_mask_packed
#define haptable_god_object_friction reference_god_object_friction
#define haptable_unpack_float16 reference_unpack_float16
#define haptable_unpack_int16 reference_unpack_int16
#define haptable_release_slew reference_release_slew
#define haptable_passivity_control reference_passivity_control
#define haptable_god_object_grab reference_god_object_grab
#define haptable_plausible_motion reference_plausible_motion
#define haptable_limit_force reference_limit_force
#define haptable_limit_rate reference_limit_rate
#define haptable_limit_mean reference_limit_mean
#define haptable_resume_ramp reference_resume_ramp
#define haptable_check_crc reference_check_crc
#define haptable_crc_of reference_crc_of
#define haptable_span_of_model reference_span_of_model
#define haptable_span_of_compliance reference_span_of_compliance
#define haptable_touches reference_touches
#define haptable_hinges_of_table reference_hinges_of_table
#define haptable_slivers_of_patches reference_slivers_of_patches
#define haptable_slivers_of_corners reference_slivers_of_corners
#define haptable_model_surface reference_model_surface
#define haptable_relaxed_of reference_relaxed_of
#define haptable_freed_of reference_freed_of
#define haptable_stiffening reference_stiffening
#define haptable_stiffened_of reference_stiffened_of
#define haptable_pair_relaxation_stiffening reference_pair_relaxation_stiffening
#define haptable_release_slew_stiffening reference_release_slew_stiffening
#define haptable_relaxation_stiffening reference_relaxation_stiffening
#define haptable_relaxation_held_stiffening reference_relaxation_held_stiffening
#define haptable_relaxation reference_relaxation
#define haptable_relaxation_held reference_relaxation_held
#define haptable_init reference_scene_init
#define haptable_step reference_scene_step
#define haptable_watch reference_scene_watch
#define haptable_check reference_scene_check
#define haptable_counters_of reference_scene_counters_of
#define haptable_pose_of reference_scene_pose_of
#define haptable_swing_of reference_scene_swing_of
#define haptable_deform reference_scene_deform
#define haptable_line_begin reference_scene_line_begin
#define haptable_line reference_scene_line
#define haptable_tool_watch reference_scene_tool_watch
#define haptable_tool_point_of reference_scene_tool_point_of
#undef HAPTABLE_TYPES_H
#undef HAPTABLE_MODEL_H
#define float double
#define restrict
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
// clang-format off
#include "firmware/haptable_model.h"
#define vec_inverse_root vec_inverse_root_of_floats
#define vec_inverse_root_by vec_inverse_root_of_floats_by
#define vec_is_below_one vec_is_float_below_one
#include "firmware/haptable_vector.h"
#undef vec_inverse_root
#undef vec_inverse_root_by
#undef vec_is_below_one
static inline double vec_inverse_root(double x) { return 1.0 / std::sqrt(x); }
static inline int vec_is_below_one(double x) { return x < 1.0; }
static inline double vec_inverse_root_by(double x, int) { return x > 0.0 ? 1.0 / std::sqrt(x) : 0.0; }
#include "firmware/haptable_hinge.c"
#include "firmware/haptable_patch.c"
#include "firmware/haptable_sliver.c"
#include "firmware/haptable_side.c"
#include "firmware/haptable_entry.c"
#include "firmware/haptable_contact.c"

#include "firmware/haptable_least_energy.c"

#include "firmware/haptable_force.c"
#include "firmware/haptable_force_interpolated.c"
#include "firmware/haptable_energy_interpolated.c"
#include "firmware/haptable_compliance.c"
#include "firmware/haptable_force_compliance.c"
#include "firmware/haptable_force_compliance_packed.c"

#include "firmware/haptable_stiffening.c"

#include "firmware/haptable_servo.c"
// clang-format on
#pragma GCC diagnostic pop
// Those that the tables in float name; the others keep their other names to the file's end.
#undef float
#undef restrict
#undef haptable_god_object_nearest
#undef haptable_force_interpolated
#undef haptable_force_consistent
#undef haptable_force_pressure_mask
#undef haptable_force_of_least_energy

}  // namespace haptable::test::reference

namespace haptable::test {

namespace {

using Eigen::Vector3d;

/// Floats as doubles: what the reference's tables point to.
template <std::size_t width>
std::vector<double> widen(const float (*rows)[width], std::size_t count) {
    std::vector<double> wide;
    for (std::size_t i = 0; rows != nullptr && i < count; ++i)
        for (float value : rows[i]) wide.push_back(double(value));
    return wide;
}

template <std::size_t width>
const double (*as_rows(const std::vector<double>& wide))[width] {
    return reinterpret_cast<const double(*)[width]>(wide.data());
}

}  // namespace

struct ReferenceServo::State {
    std::vector<double> stiffening, vertex, stiffness, vertex_compliance, edge_compliance, patch_compliance;
    reference::haptable_compliance compliance{};
    reference::haptable_model model{};
    reference::haptable_servo servo{};

    explicit State(const haptable_model& m)
        : vertex(widen(m.vertex_m, m.vertex_count)), stiffness(widen(m.stiffness_n_per_m, m.free_count)) {
        model.max_force_n = double(m.max_force_n);
        model.rigid_stiffness_n_per_m = double(m.rigid_stiffness_n_per_m);
        model.tolerance_m = double(m.tolerance_m);
        model.workspace_limit_m = double(m.workspace_limit_m);
        for (int i = 0; i < 3; ++i) model.grid_origin_m[i] = double(m.grid_origin_m[i]);
        model.grid_per_m = double(m.grid_per_m);
        model.vertex_count = m.vertex_count;
        model.free_count = m.free_count;
        model.patch_count = m.patch_count;
        model.box_count = m.box_count;
        model.vertex_m = as_rows<3>(vertex);
        model.stiffness_n_per_m = as_rows<6>(stiffness);
        model.patch = m.patch;
        model.neighbour = m.neighbour;
        model.box = reinterpret_cast<const reference::haptable_box*>(m.box);
        model.hinge_count = m.hinge_count;
        model.hinges = m.hinges != nullptr ? &reference::reference_hinges_of_table : nullptr;
        if (m.slivers != nullptr)
            model.slivers = m.slivers->is_thin != nullptr ? &reference::reference_slivers_of_patches
                                                          : &reference::reference_slivers_of_corners;
        model.hinge = reinterpret_cast<const reference::haptable_hinge*>(m.hinge);
        choose(m);
        if (m.compliance != nullptr) copy(*m.compliance, m);
        reference::reference_init(&servo);
    }

    void choose(const haptable_model& m) {
        model.god_object = m.god_object == haptable_god_object_nearest ? reference::reference_god_object_nearest
                                                                       : reference::reference_god_object_least_energy;
        const haptable_force_fn* const force = m.force;
        if (force == haptable_force_interpolated) {
            model.force = reference::reference_force_interpolated;
            model.energy = reference::reference_energy_interpolated;
        } else if (force == haptable_force_consistent) {
            model.force = reference::reference_force_consistent;
            model.energy = reference::reference_energy_consistent;
        } else if (force == haptable_force_pressure_mask) {
            model.force = reference::reference_force_pressure_mask;
            model.energy = reference::reference_energy_pressure_mask;
        } else if (force == haptable_force_of_least_energy) {
            model.force = reference::reference_force_of_least_energy;
            model.energy = m.compliance->degree == 2 ? reference::reference_energy_consistent
                                                     : reference::reference_energy_pressure_mask;
        } else {
            throw std::logic_error("the reference does not know this force");
        }
        if (m.stiffen == nullptr) return;
        stiffening = {double(m.stiffening[0]), double(m.stiffening[1]), double(m.stiffening[2]),
                      double(m.stiffening[3])};
        model.relax = reference::reference_stiffening;
        model.stiffening = stiffening.data();
    }

    void copy(const haptable_compliance& c, const haptable_model& m) {
        vertex_compliance = widen(c.vertex, m.vertex_count);
        edge_compliance = widen(c.edge, std::size_t{c.edge_count} * (c.degree - 1U));
        if (c.degree == 4) patch_compliance = widen(c.patch, 3U * m.patch_count);
        compliance.degree = c.degree;
        compliance.edge_count = c.edge_count;
        compliance.vertex = as_rows<6>(vertex_compliance);
        compliance.edge = as_rows<6>(edge_compliance);
        compliance.patch = as_rows<6>(patch_compliance);
        compliance.patch_edge = c.patch_edge;
        model.compliance = &compliance;
    }
};

ReferenceServo::ReferenceServo(const haptable_model& model) : state_(std::make_unique<State>(model)) {}
ReferenceServo::~ReferenceServo() = default;

ReferenceServo::Tick ReferenceServo::step(const Vector3d& finger) {
    reference::haptable_output out{};
    reference::reference_step(&state_->model, &state_->servo, finger.data(), 0, &out);
    return {out.state, out.patch, Eigen::Map<const Vector3d>(out.alpha), Eigen::Map<const Vector3d>(out.god_object_m),
            Eigen::Map<const Vector3d>(out.force_n)};
}

void ReferenceServo::set_contact(int patch, const Vector3d& alpha, const Vector3d& last_finger) {
    reference::haptable_contact& contact = state_->servo.contact;
    contact.patch = static_cast<std::uint16_t>(patch);
    for (int c = 0; c < 3; ++c) {
        contact.alpha[c] = alpha[c];
        state_->servo.finger_m[c] = last_finger[c];
    }
    reference::place(&state_->model, &contact);
    state_->servo.finger_known = 1;
}

ReferenceServo::Energy ReferenceServo::energy(int patch, const Vector3d& alpha, const Vector3d& finger) const {
    reference::haptable_contact contact{};
    contact.patch = static_cast<std::uint16_t>(patch);
    for (int c = 0; c < 3; ++c) contact.alpha[c] = alpha[c];
    reference::place(&state_->model, &contact);
    reference::haptable_energy e{};
    state_->model.energy(&state_->model, &contact, finger.data(), reference::HAPTABLE_ENERGY_ALL, &e);
    Energy energy;
    energy.energy = e.energy_j;
    energy.load = Eigen::Map<const Vector3d>(e.load_n);
    energy.gradient = Eigen::Map<const Eigen::Vector2d>(e.gradient_j);
    energy.hessian << e.hessian_j[0], e.hessian_j[1], e.hessian_j[1], e.hessian_j[2];
    energy.gauss_newton << e.gauss_newton_j[0], e.gauss_newton_j[1], e.gauss_newton_j[1], e.gauss_newton_j[2];
    return energy;
}

}  // namespace haptable::test
