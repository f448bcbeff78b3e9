// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/modes.hpp"

// A function's name as text and itself, so that the two cannot differ.
#define HAPTABLE_NAMED(function) \
    { #function, function }

namespace haptable {

namespace {

/// By the value of the enum.
template <typename Choice, typename Function, std::size_t count>
Named<Function> chosen(const Named<Function> (&functions)[count], Choice choice) {
    static_assert(count == words(Choice{}).size());
    return functions[static_cast<std::size_t>(choice)];
}

}  // namespace

Modes modes_of(const Tables& tables) {
    static constexpr Named<haptable_god_object_fn> kGodObject[] = {
        HAPTABLE_NAMED(haptable_god_object_nearest),
        HAPTABLE_NAMED(haptable_god_object_least_energy),
    };
    static constexpr Named<haptable_force_fn> kForce[] = {
        HAPTABLE_NAMED(haptable_force_interpolated),
        HAPTABLE_NAMED(haptable_force_consistent),
        HAPTABLE_NAMED(haptable_force_pressure_mask),
    };
    static constexpr Named<haptable_energy_fn> kEnergy[] = {
        HAPTABLE_NAMED(haptable_energy_interpolated),
        HAPTABLE_NAMED(haptable_energy_consistent),
        HAPTABLE_NAMED(haptable_energy_pressure_mask),
    };
    static constexpr Named<haptable_unpack_fn> kUnpack[] = {
        {"0", nullptr},
        HAPTABLE_NAMED(haptable_unpack_float16),
        HAPTABLE_NAMED(haptable_unpack_int16),
    };
    Modes modes;
    modes.god_object = chosen(kGodObject, tables.god_object);
    modes.force = chosen(kForce, tables.force);
    modes.unpack = chosen(kUnpack, tables.precision);
    if (tables.god_object == GodObject::kLeastEnergy) {
        modes.energy = chosen(kEnergy, tables.force);
        if (tables.force != ForceLaw::kInterpolated && tables.static_friction <= 0.0)
            modes.force = HAPTABLE_NAMED(haptable_force_of_least_energy);
    }
    if (tables.static_friction > 0.0) {
        modes.frictionless = modes.god_object;
        modes.god_object = HAPTABLE_NAMED(haptable_god_object_friction);
    }
    if (tables.release_n_per_ms > 0.0) modes.release = HAPTABLE_NAMED(haptable_release_slew);
    if (tables.passivity) modes.passivity = HAPTABLE_NAMED(haptable_passivity_control);
    return modes;
}

void set_modes(const Tables& tables, haptable_model& model) {
    const Modes modes = modes_of(tables);
    model.god_object = modes.god_object.function;
    model.force = modes.force.function;
    model.energy = modes.energy.function;
    model.frictionless = modes.frictionless.function;
    model.static_friction = static_cast<float>(tables.static_friction);
    model.kinetic_friction = static_cast<float>(tables.kinetic_friction);
    model.release = modes.release.function;
    model.release_n = static_cast<float>(tables.release_n_per_ms);
    model.passivity = modes.passivity.function;
}

}  // namespace haptable
