// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/modes.hpp"

#include <algorithm>

namespace haptable {

namespace {

/// Steps that a walk may take after it has met its limit: the last look around a vertex, two edges and two patches.
constexpr std::uint32_t kLastLook = 13;

/// Boxes beyond the limit that the last leaf may take: four patches with a look around their vertices each.
constexpr std::uint32_t kLastLeaf = 20;

/// What a tick's search took, its slide has not: an energy less for so many boxes (firmware/haptable_least_energy.c).
constexpr std::uint32_t kBoxesOfEnergy = 8;

haptable_energy_fn* energy_of(haptable_force_fn* force) {
    if (force == haptable_force_consistent) return haptable_energy_consistent;
    return force == haptable_force_pressure_mask ? haptable_energy_pressure_mask : haptable_energy_interpolated;
}

}  // namespace

std::vector<Mode> every_mode() {
    std::vector<Mode> modes;
    for (const char* more : {"", "friction", "passivity"})
        for (const char* force : {"interpolated", "consistent", "pressure-mask"})
            for (const char* god_object : {"nearest", "least-energy"}) modes.push_back({force, god_object, more});
    return modes;
}

haptable_model in_mode(haptable_model model, const Mode& mode) {
    const bool least = mode.god_object == "least-energy";
    model.god_object = least ? haptable_god_object_least_energy : haptable_god_object_nearest;
    model.energy = least ? energy_of(model.force) : nullptr;
    model.frictionless = nullptr;
    if (least && mode.more != "friction" && model.compliance != nullptr) model.force = haptable_force_of_least_energy;
    if (mode.more == "friction") {
        model.frictionless = model.god_object;
        model.god_object = haptable_god_object_friction;
        model.static_friction = 0.5F;
        model.kinetic_friction = 0.4F;
    }
    const bool finishes = mode.more == "passivity";
    model.release = finishes ? haptable_release_slew : nullptr;
    model.release_n = 0.05F;
    model.passivity = finishes ? haptable_passivity_control : nullptr;
    return model;
}

TickCost cost_of(const Mode& mode, std::uint64_t fan, std::uint64_t slides) {
    const bool consistent = mode.force == "consistent", mask = mode.force == "pressure-mask";
    const bool least = mode.god_object == "least-energy";
    const std::uint64_t force = mask ? 2000 : consistent ? 400 : 200;
    const std::uint64_t energy = mask ? 3400 : consistent ? 2300 : 1350;
    constexpr std::uint64_t kNormal = 280, kPressed = 60;  // of a patch around a vertex, and its angle
    TickCost cost{900 + force, 65, 280, least ? energy : 0};
    cost.rest += slides * (200 + fan * (kNormal + (least ? kPressed : 0)));
    if (mode.more == "friction") cost.rest += 9 * (100 + fan * kNormal + force);  // looks into the cone
    if (mode.more == "passivity") cost.rest += 300;
    return cost;
}

std::uint64_t most_patches_around_a_vertex(const haptable_model& model) {
    std::vector<std::uint64_t> around(model.vertex_count);
    for (int patch = 0; patch < model.patch_count; ++patch)
        for (const std::uint16_t vertex : model.patch[patch]) ++around[vertex];
    return *std::max_element(around.begin(), around.end());
}

std::uint64_t cost(const TickCost& each, const haptable_counters& tick) {
    return each.rest + each.step * (tick.most_steps + tick.most_held_steps) + each.box * tick.most_boxes +
           each.energy * tick.most_energies;
}

std::uint64_t most_cost(const Mode& mode, std::uint64_t fan) {
    haptable_counters most{};
    most.most_steps = HAPTABLE_WALK_STEPS + kLastLook;
    if (mode.more == "friction") most.most_held_steps = 3U * HAPTABLE_WALK_STEPS + kLastLook;
    if (mode.god_object == "least-energy") most.most_energies = HAPTABLE_ENERGY_STEPS + 2U * HAPTABLE_SLIDES;
    const std::uint64_t without_search = cost(cost_of(mode, fan), most);
    most.most_boxes = HAPTABLE_TICK_BOXES + kLastLeaf;
    if (mode.god_object == "least-energy") most.most_energies -= HAPTABLE_TICK_BOXES / kBoxesOfEnergy;
    return std::max(without_search, cost(cost_of(mode, fan), most));
}

}  // namespace haptable
