// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/modes.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "host/base/error.hpp"

// A function's name as text and itself, so that the two cannot differ.
#define HAPTABLE_NAMED(function) \
    { #function, function }

namespace haptable {

namespace {

template <typename Function>
using Choices = std::vector<std::pair<std::string, Named<Function>>>;

template <typename Function>
Named<Function> chosen(const Choices<Function>& choices, const char* key, const std::string& word) {
    for (const auto& [name, function] : choices)
        if (name == word) return function;
    throw Error(
        fmt::format("the tables ask for {} = \"{}\", which this version does not have: make them again", key, word));
}

}  // namespace

Modes modes_of(const Tables& tables) {
    static const Choices<haptable_god_object_fn> god_objects = {
        {"nearest", HAPTABLE_NAMED(haptable_god_object_nearest)},
        {"least-energy", HAPTABLE_NAMED(haptable_god_object_least_energy)},
    };
    static const Choices<haptable_force_fn> forces = {
        {"interpolated", HAPTABLE_NAMED(haptable_force_interpolated)},
        {"consistent", HAPTABLE_NAMED(haptable_force_consistent)},
        {"pressure-mask", HAPTABLE_NAMED(haptable_force_pressure_mask)},
    };
    static const Choices<haptable_energy_fn> energies = {
        {"interpolated", HAPTABLE_NAMED(haptable_energy_interpolated)},
        {"consistent", HAPTABLE_NAMED(haptable_energy_consistent)},
        {"pressure-mask", HAPTABLE_NAMED(haptable_energy_pressure_mask)},
    };
    static const Choices<haptable_unpack_fn> precisions = {
        {"float32", {"0", nullptr}},
        {"float16", HAPTABLE_NAMED(haptable_unpack_float16)},
        {"int16", HAPTABLE_NAMED(haptable_unpack_int16)},
    };
    Modes modes;
    modes.god_object = chosen(god_objects, "god_object", tables.god_object);
    modes.force = chosen(forces, "force", tables.force);
    modes.unpack = chosen(precisions, "precision", tables.precision);
    if (tables.god_object == "least-energy") {
        modes.energy = chosen(energies, "force", tables.force);
        if (tables.force != "interpolated" && tables.static_friction <= 0.0)
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

}  // namespace haptable
