// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/modes.hpp"

namespace haptable {

namespace {

/// By the value of the enum.
template <typename Choice, typename Function, std::size_t count>
Function* chosen(Function* const (&functions)[count], Choice choice) {
    static_assert(count == words(Choice{}).size());
    return functions[static_cast<std::size_t>(choice)];
}

}  // namespace

void set_modes(const Tables& tables, haptable_model& model) {
    static constexpr haptable_god_object_fn* kGodObject[] = {haptable_god_object_nearest,
                                                             haptable_god_object_least_energy};
    static constexpr haptable_force_fn* kForce[] = {haptable_force_interpolated, haptable_force_consistent,
                                                    haptable_force_pressure_mask};
    static constexpr haptable_energy_fn* kEnergy[] = {haptable_energy_interpolated, haptable_energy_consistent,
                                                      haptable_energy_pressure_mask};
    static constexpr haptable_force_fn* kPackedForce[] = {haptable_force_interpolated, haptable_force_consistent_packed,
                                                          haptable_force_pressure_mask_packed};
    static constexpr haptable_energy_fn* kPackedEnergy[] = {
        haptable_energy_interpolated, haptable_energy_consistent_packed, haptable_energy_pressure_mask_packed};
    const bool packed = tables.precision != Storage::kFloat32;
    const bool least = tables.god_object == GodObject::kLeastEnergy, friction = tables.static_friction > 0.0;
    const bool has_load = least && !friction && tables.force != ForceLaw::kInterpolated;
    model.god_object = friction ? haptable_god_object_friction : chosen(kGodObject, tables.god_object);
    model.frictionless = friction ? chosen(kGodObject, tables.god_object) : nullptr;
    model.static_friction = friction ? static_cast<float>(tables.static_friction) : 0.0F;
    model.kinetic_friction = friction ? static_cast<float>(tables.kinetic_friction) : 0.0F;
    model.force = has_load ? haptable_force_of_least_energy : chosen(packed ? kPackedForce : kForce, tables.force);
    model.energy = least ? chosen(packed ? kPackedEnergy : kEnergy, tables.force) : nullptr;
    model.release = tables.release_n_per_ms > 0.0 ? haptable_release_slew : nullptr;
    model.release_n = static_cast<float>(tables.release_n_per_ms);
    model.passivity = tables.passivity ? haptable_passivity_control : nullptr;
}

haptable_unpack_fn* unpack_of(Storage precision) {
    static constexpr haptable_unpack_fn* kUnpack[] = {nullptr, haptable_unpack_float16, haptable_unpack_int16};
    return chosen(kUnpack, precision);
}

}  // namespace haptable
