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
    const std::uint64_t energy = mask ? 1700 : consistent ? 1150 : 675;
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

namespace {

std::uint64_t most_of(const TickCost& each, const Mode& mode) {
    haptable_counters most{};
    most.most_steps = MOST_STEPS;
    if (mode.more == "friction") most.most_held_steps = MOST_HELD_STEPS;
    most.most_boxes = MOST_BOXES;
    if (mode.god_object != GodObject::kLeastEnergy) return cost(each, most);
    most.most_energies = MOST_ENERGIES;
    return cost(each, most);
}

}  // namespace

std::uint64_t most_cost(const Mode& mode, std::uint64_t fan) { return most_of(cost_of(mode, fan), mode); }

PairTickCost pair_cost_of(const Mode& mode, std::uint64_t fan) {
    const bool consistent = mode.force == ForceLaw::kConsistent, mask = mode.force == ForceLaw::kPressureMask;
    const bool least = mode.god_object == GodObject::kLeastEnergy, friction = mode.more == "friction";
    PairTickCost cost{cost_of(mode, fan), 0, 0, 0};
    const std::uint64_t force = mask ? 3800 : consistent ? 1500 : 1200;  // of the pair, its blocks read anew
    cost.rest = mask ? 6500 : 2400;
    if (friction) cost.each.rest += MOST_FRICTION_FORCES * force;
    if (!least) return cost;
    cost.each.energy = mask ? 4750 : consistent ? 2350 : 1850;
    cost.each.rest += friction ? force : 0;
    if (friction) return cost;  // one after the other
    cost.rest += 2000;
    cost.evaluation = mask ? 15000 : consistent ? 7700 : 6300;
    cost.look = mask ? 4700 : consistent ? 2400 : 1900;
    return cost;
}

std::uint64_t pair_cost(const PairTickCost& each, const haptable_pair& tick) {
    std::uint64_t sum = each.rest + each.evaluation * tick.evaluations + each.look * tick.looks;
    for (const haptable_servo& servo : tick.servo) sum += cost(each.each, servo.counters);
    for (const haptable_pair_view& view : tick.view) sum += STEPS_OF_ENERGY * each.each.energy * view.tracked;
    return sum;
}

std::uint64_t most_pair_cost(const Mode& mode, std::uint64_t fan) {
    const PairTickCost each = pair_cost_of(mode, fan);
    // Without friction one is tracked only where one is left behind: then the other's energies are one finger's, which
    // saves more than that takes.
    const bool tracks = mode.god_object == GodObject::kLeastEnergy && mode.more == "friction";
    const std::uint64_t tracked = tracks ? each.each.energy * 2 * HAPTABLE_PAIR_TRACKED * STEPS_OF_ENERGY : 0;
    return each.rest + 2 * most_of(each.each, mode) + each.evaluation * HAPTABLE_PAIR_EVALUATIONS +
           each.look * HAPTABLE_PAIR_LOOKS + tracked;
}

std::uint64_t most_body_cost(std::uint64_t points, std::uint64_t fingers) {
    // Two systems of 6x6 and eight solves; of a finger 4 lines of the system, of a point 3, twice.
    return 9000 + 2400 * fingers + 2800 * points;
}

std::uint64_t most_vibration_cost(const Mode& mode, std::uint64_t modes) {
    const std::uint64_t load = std::max<std::uint64_t>(STEPS_OF_ENERGY * cost_of(mode, 0).energy, 2000);
    return 1500 + 4 * load + 400 * modes;
}

std::uint64_t most_vibration_pair_cost(const Mode& mode, std::uint64_t modes) {
    // Each place's own terms and what couples them, read anew; a system of 6x6; the account.
    return 5000 + pair_cost_of(mode, 0).rest + 900 * modes;
}

}  // namespace haptable
