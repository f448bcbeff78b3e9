/* SPDX-License-Identifier: MIT
 *
 * What a tick's work is counted in, and the most of each that one tick does.
 *
 * The servo counts by these numbers; the host bounds a tick's instructions by them (host/target/modes.cpp), and tests
 * hold every tick to that. The limits that they come from are those of haptable.h.
 */
#ifndef HAPTABLE_BOUNDS_H
#define HAPTABLE_BOUNDS_H

#include "haptable.h"

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

/* Evaluations of the energy: the dearest costs as much as twelve boxes. What a tick's search for an entry took, its
 * slides have not; what its slides took beyond some, its look at the finger has not. The last trial around a vertex may
 * take three more. */
enum {
    BOXES_OF_ENERGY = 12,
    FREE_ENERGIES = 6,
    ENTRY_ENERGIES = 14, /* of a tick that begins contact: half of the boxes are left for the look that may end it */
    MOST_ENERGIES = HAPTABLE_ENERGY_STEPS + 3, /* counter most_energies */
    MOST_ENERGIES_WITH_MOST_BOXES = FREE_ENERGIES + 3,
    MOST_BOXES_WITH_MOST_ENERGIES = MOST_BOXES - BOXES_OF_ENERGY * (HAPTABLE_ENERGY_STEPS - FREE_ENERGIES)
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
