// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/modes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "codegen/laws.hpp"
#include "codegen/model.hpp"
#include "firmware/haptable_bounds.h"
#include "firmware/haptable_tool.h"

namespace haptable {

namespace {

/// What a law may cost in instructions: host/base/laws.inc.
struct LawCost {
    std::uint64_t force, energy, pair_force, pair_rest, pair_energy, pair_evaluation, pair_look;
};

const LawCost& of_law(ForceLaw law) {
    static constexpr LawCost kCost[] = {
#define HAPTABLE_FORCE_LAW(NAME, WORD, TITLE, FUNCTION, PACKED, DEGREE, ...) {__VA_ARGS__},
#include "host/base/laws.inc"
    };
    return kCost[static_cast<std::size_t>(law)];
}

constexpr StiffeningCurve kCurve{{0.5, -0.5, 3.0}, 1e-4};

}  // namespace

std::vector<Mode> every_mode() {
    std::vector<Mode> modes;
    for (const char* more : {"", "friction", "passivity"})
        for (const ForceLaw force : every<ForceLaw>())
            for (const GodObject god_object : every<GodObject>()) modes.push_back({force, god_object, more});
    for (const ForceLaw force : every<ForceLaw>()) modes.push_back({force, GodObject::kNearest, "stiffening"});
    return modes;
}

haptable_model in_mode(haptable_model model, const Mode& mode) {
    Tables chosen;
    chosen.force = mode.force;
    chosen.god_object = mode.god_object;
    if (mode.more == "friction") {
        chosen.static_friction = 0.5;
        chosen.kinetic_friction = 0.4;
    } else if (mode.more == "passivity") {
        chosen.options.set("contact.release_slew", 0.05);
        chosen.options.set("contact.passivity", true);
    } else if (mode.more == "stiffening") {
        static const std::vector<float> kTable = stiffening_table(kCurve);
        chosen.stiffening = kCurve;
        model.stiffening = kTable.data();
    }
    set_laws(chosen, model);
    return model;
}

TickCost cost_of(const Mode& mode, std::uint64_t fan, std::uint64_t slides) {
    const bool least = mode.god_object == GodObject::kLeastEnergy;
    const LawCost& law = of_law(mode.force);
    constexpr std::uint64_t kNormal = 280, kPressed = 170;  // of a patch around a vertex: its angle; least energy, more
    TickCost cost{900 + law.force, 65, 280, least ? law.energy : 0};
    cost.rest += slides * (200 + fan * (kNormal + (least ? kPressed : 0)));
    if (mode.more == "friction")  // and a look at the finger from where it is held
        cost.rest += MOST_FRICTION_FORCES * (200 + fan * kNormal + law.force) + 200 + fan * kNormal;
    if (mode.more == "passivity") cost.rest += 300;
    if (mode.more == "stiffening") cost.rest += 64;
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
    if (mode.god_object == GodObject::kLeastEnergy) most.most_energies = MOST_ENERGIES;
    return cost(each, most);
}

}  // namespace

std::uint64_t most_cost(const Mode& mode, std::uint64_t fan) { return most_of(cost_of(mode, fan), mode); }

PairTickCost pair_cost_of(const Mode& mode, std::uint64_t fan) {
    const LawCost& law = of_law(mode.force);
    const bool least = mode.god_object == GodObject::kLeastEnergy, friction = mode.more == "friction";
    PairTickCost cost{cost_of(mode, fan), 0, 0, 0};
    cost.rest = law.pair_rest;
    if (friction) cost.each.rest += MOST_FRICTION_FORCES * law.pair_force;  // its blocks read anew
    if (!least) return cost;
    cost.each.energy = law.pair_energy;
    cost.each.rest += friction ? law.pair_force : 0;
    if (friction) return cost;  // one after the other
    cost.rest += 2000;
    cost.evaluation = law.pair_evaluation;
    cost.look = law.pair_look;
    return cost;
}

std::uint64_t pair_cost(const PairTickCost& each, const haptable_pair& tick) {
    std::uint64_t sum = each.rest + each.evaluation * tick.evaluations + each.look * tick.looks;
    for (const haptable_servo& servo : tick.servo) sum += cost(each.each, servo.counters);
    return sum;
}

std::uint64_t most_pair_cost(const Mode& mode, std::uint64_t fan) {
    const PairTickCost each = pair_cost_of(mode, fan);
    return each.rest + 2 * most_of(each.each, mode) + each.evaluation * HAPTABLE_PAIR_EVALUATIONS +
           each.look * HAPTABLE_PAIR_LOOKS;
}

std::uint64_t most_tool_cost(const Mode& mode, std::uint64_t fan, std::uint64_t n) {
    const bool mask = mode.force == ForceLaw::kPressureMask;
    const bool settles = mode.god_object == GodObject::kLeastEnergy || mode.more == "friction";
    const std::uint64_t couple = mask ? 3200 : 1300, own = mask ? 3000 : 2000, ways = n * (n - 1);
    // C's blocks; a factorisation of 3 n rows with its solve, and a look at every point.
    const std::uint64_t assembly = n * own + ways / 2 * couple, set = 300 + 300 * n + 160 * n * n + 18 * n * n * n;
    const Mode nearest{mode.force, GodObject::kNearest, mode.more == "friction" ? "" : mode.more};
    std::uint64_t sum = 2000 + n * (700 + most_cost(nearest, fan)) + assembly + (HAPTABLE_POINTS_SETS + 1) * set;
    if (!settles) return sum;
    sum += ways / 2 * couple + n * own;  // slopes of E
    sum += HAPTABLE_POINTS_TRIALS * n * 65 * (HAPTABLE_POINTS_WALK_STEPS + MOST_STEPS - HAPTABLE_WALK_STEPS);
    return sum + HAPTABLE_POINTS_TRIALS * assembly + (HAPTABLE_POINTS_TRIALS * HAPTABLE_POINTS_TRIAL_SETS + 1) * set;
}

std::uint64_t most_moving_cost(const LoadedScene& scene, const Mode& mode) {
    /// Most instructions of a mover: under one finger and under two, and for each point on a floor or mode.
    struct MoverCost {
        std::uint64_t one, one_each, two, two_each;
    };
#define HAPTABLE_COST(PART, KEY, WORD, TITLE, ...) {__VA_ARGS__},
    static constexpr MoverCost kRigid[] = {HAPTABLE_RIGID_MOVERS(HAPTABLE_COST)},
                               kSurface[] = {HAPTABLE_SURFACE_MOVERS(HAPTABLE_COST)};
    const bool two = scene.pair() != nullptr;
    const auto of = [two](const MoverCost& cost, std::uint64_t count) {
        return two ? cost.two + cost.two_each * count : cost.one + cost.one_each * count;
    };
    std::uint64_t sum = 0;
    if (const haptable_body* body = scene.body()) sum += of(kRigid[body->motion], body->point_count);
    if (const haptable_modes* modes = scene.modes()) {
        // A surface that moves is met by each contact's own terms, and by what couples them, read anew.
        const std::uint64_t load = std::max<std::uint64_t>(STEPS_OF_ENERGY * cost_of(mode, 0).energy, 2000);
        sum += of(kSurface[0], modes->count) + (two ? pair_cost_of(mode, 0).rest : 4 * load);
    }
    return sum;
}

}  // namespace haptable
