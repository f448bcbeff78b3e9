/* SPDX-License-Identifier: MIT
 *
 * What a tick's work is counted in, and the most of each that one tick does.
 *
 * The servo counts by these numbers; the host bounds a tick's instructions by them (host/target/modes.cpp), and tests
 * hold every tick to that. The limits that they come from are those of haptable.h.
 */
#ifndef HAPTABLE_BOUNDS_H
#define HAPTABLE_BOUNDS_H

#include "haptable_model.h"

/* Steps of the walk: comparing one edge with the finger is one, a patch's nearest point costs as much as six. A walk at
 * its last step still finishes a trial around a vertex: two edges, the patch between them, that of the steepest edge.
 */
enum {
    STEPS_OF_TWO_EDGES = 2,
    STEPS_OF_PATCH = 6,
    MOST_STEPS = HAPTABLE_WALK_STEPS - 1 + STEPS_OF_TWO_EDGES + 2 * STEPS_OF_PATCH /* counter most_steps */
};

/* Boxes of the index. */
enum { MOST_BOXES = HAPTABLE_TICK_BOXES /* counter most_boxes */ };

/* Evaluations of the energy: with all its derivatives it is as dear as two gradients. The last trial may take one of
 * the former when it is one step short, or one more after the last gradient. */
enum {
    STEPS_OF_ENERGY = 2,
    MOST_ENERGIES = HAPTABLE_ENERGY_STEPS + STEPS_OF_ENERGY /* counter most_energies */
};

/* Friction: so many points are tried on the line from stick to slip, each with a walk and a force, after the forces at
 * its ends. No walk begins once the walks took HELD_STEPS: most end after a patch or two. */
enum {
    SLIP_TRIES = 3,
    HELD_STEPS = HAPTABLE_WALK_STEPS,
    MOST_HELD_STEPS = HELD_STEPS - 1 + MOST_STEPS, /* counter most_held_steps */
    MOST_FRICTION_FORCES = 2 + SLIP_TRIES
};

#endif
