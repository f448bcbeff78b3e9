// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/modes.hpp"

#include <algorithm>

#include "codegen/modes.hpp"
#include "firmware/haptable_bounds.h"

namespace haptable {

std::vector<Mode> every_mode() {
    std::vector<Mode> modes;
    for (const char* more : {"", "friction", "passivity"})
        for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent, ForceLaw::kPressureMask})
            for (const GodObject god_object : {GodObject::kNearest, GodObject::kLeastEnergy})
                modes.push_back({force, god_object, more});
    return modes;
}

haptable_model in_mode(haptable_model model, const Mode& mode) {
    Tables options;
    options.force = mode.force;
    options.god_object = mode.god_object;
    if (mode.more == "friction") {
        options.static_friction = 0.5;
        options.kinetic_friction = 0.4;
    } else if (mode.more == "passivity") {
        options.release_n_per_ms = 0.05;
        options.passivity = true;
    }
    set_modes(options, model);
    return model;
}

TickCost cost_of(const Mode& mode, std::uint64_t fan, std::uint64_t slides) {
    const bool consistent = mode.force == ForceLaw::kConsistent, mask = mode.force == ForceLaw::kPressureMask;
    const bool least = mode.god_object == GodObject::kLeastEnergy;
    const std::uint64_t force = mask ? 2000 : consistent ? 400 : 200;
    const std::uint64_t energy = mask ? 3400 : consistent ? 2300 : 1350;
    constexpr std::uint64_t kNormal = 280, kPressed = 170;  // of a patch around a vertex: its angle; least energy, more
    TickCost cost{900 + force, 65, 280, least ? energy : 0};
    cost.rest += slides * (200 + fan * (kNormal + (least ? kPressed : 0)));
    if (mode.more == "friction")  // and a look at the finger from where it is held
        cost.rest += MOST_FRICTION_FORCES * (200 + fan * kNormal + force) + 200 + fan * kNormal;
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
    most.most_steps = MOST_STEPS;
    if (mode.more == "friction") most.most_held_steps = MOST_HELD_STEPS;
    most.most_boxes = MOST_BOXES;
    const TickCost each = cost_of(mode, fan);
    if (mode.god_object != GodObject::kLeastEnergy) return cost(each, most);
    most.most_energies = MOST_ENERGIES_WITH_MOST_BOXES;
    const std::uint64_t with_search = cost(each, most);
    most.most_energies = MOST_ENERGIES;
    most.most_boxes = MOST_BOXES_WITH_MOST_ENERGIES;
    return std::max(with_search, cost(each, most));
}

}  // namespace haptable
