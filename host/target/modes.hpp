// SPDX-License-Identifier: GPL-2.0-or-later
// Every mode in which a model can be touched, and what a tick of each costs at the most.
#pragma once

#include <string>
#include <vector>

#include "codegen/loaded_scene.hpp"
#include "firmware/haptable_model.h"
#include "firmware/haptable_pair.h"
#include "host/base/modes.hpp"

namespace haptable {

/// What a scene's [contact] chooses, as far as it changes a tick's work.
struct Mode {
    ForceLaw force;
    GodObject god_object;
    std::string more;  ///< empty, friction, passivity (and a release), or stiffening

    std::string name() const {
        return std::string(word(force)) + " " + word(god_object) + (more.empty() ? "" : " " + more);
    }
};

/// Three forces, two god-objects, each alone, with friction, with passivity and release; the nearest with stiffening.
std::vector<Mode> every_mode();

/// The model as it is touched in that mode.
/// before: the model's tables are of the mode's force.
haptable_model in_mode(haptable_model model, const Mode& mode);

/// What a tick costs by reasoning, in instructions: a rest, and so much each step of the walk, box of the index, point
/// whose energy is taken. The numbers hold for Cortex-M4F, M7, M33 and rv32imafc at -O2.
struct TickCost {
    std::uint64_t rest, step, box, energy;
};

/// `fan`: the most patches around a vertex of the model, whose normals tell inside from outside after each of a tick's
/// `slides`.
TickCost cost_of(const Mode& mode, std::uint64_t fan, std::uint64_t slides = HAPTABLE_SLIDES);

/// At most HAPTABLE_FAN_PATCHES.
std::uint64_t most_patches_around_a_vertex(const haptable_model& model);

/// The work of one tick, as the servo counted it.
std::uint64_t cost(const TickCost& each, const haptable_counters& tick);

/// The most that a tick can cost: the limits of haptable.h times the cost of each.
std::uint64_t most_cost(const Mode& mode, std::uint64_t fan);

/// A tick of two fingers: each finger's own work by `each`, and what couples them: once a tick, each evaluation of both
/// at once, each look at another patch of an edge or a vertex.
struct PairTickCost {
    TickCost each;
    std::uint64_t rest, evaluation, look;
};
PairTickCost pair_cost_of(const Mode& mode, std::uint64_t fan);

/// The work of one tick of both, the servos' counters being that tick's.
std::uint64_t pair_cost(const PairTickCost& each, const haptable_pair& tick);

/// The most that a tick of two fingers can cost, all pairs of places being blocks.
std::uint64_t most_pair_cost(const Mode& mode, std::uint64_t fan);

/// The most that a tick of a tool with so many points can cost, all pairs of places being blocks.
std::uint64_t most_tool_cost(const Mode& mode, std::uint64_t fan, std::uint64_t points);

/// What the scene's movers can cost beside its fingers' steps (HAPTABLE_MOVERS); 0: nothing moves. No loop of theirs
/// depends on data.
std::uint64_t most_moving_cost(const LoadedScene& scene, const Mode& mode);

}  // namespace haptable
