/* SPDX-License-Identifier: MIT
 *
 *   q'' + 2 zeta omega q' + omega^2 q = phi_1^T f_1 + phi_2^T f_2
 *
 * Two fingers on a body that rings: as haptable_modes.h, with each finger felt against the surface as the modes have
 * moved it at its own god-object, and the dent of the one felt by the other. The tables are those of L_rest in all
 * blocks of the pair.
 */
#ifndef HAPTABLE_MODES_PAIR_H
#define HAPTABLE_MODES_PAIR_H

#include "haptable_modes.h"
#include "haptable_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What two fingers leave of a body that rings. The caller owns it; haptable_modes_pair_init makes it valid. */
struct haptable_modes_pair {
    struct haptable_swings swings;
    struct haptable_met met[HAPTABLE_FINGERS];
    float stored_j;  /* in the modes and in both contacts, and what the shifts may cost these next; less nothing owed */
    float contact_j; /* of that, in the contacts, were nothing owed */
    float owed_j;    /* made by contacts and not paid by the modes' motion: forces are times 1 - owed_j / contact_j */
};

void haptable_modes_pair_init(struct haptable_modes_pair* state);

/* One tick: as haptable_pair_step, on a body that rings. before: tables->model is modes->model. Bounded work:
 * haptable_pair_step, both places without one another, what couples them, a system of 6x6, and HAPTABLE_MODES
 * (2 x 6 x 3 + 90) multiplications. */
void haptable_modes_pair_step(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                              struct haptable_modes_pair* state, struct haptable_pair* pair,
                              const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                              struct haptable_output out[HAPTABLE_FINGERS]);

/* The same up to what is owed, of which the caller is to take account. Returns the energy, J, that modes and contacts
 * have got beyond what the hands gave and what a wall makes of hands that are felt at ticks; below 0 where they lost
 * some. */
float haptable_modes_pair_feel(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                               struct haptable_modes_pair* state, struct haptable_pair* pair,
                               const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                               struct haptable_output out[HAPTABLE_FINGERS]);

/* The same of finger `number` alone, 0 or 1, while the other is away: as haptable_modes_step. What is known of the
 * other is forgotten. */
void haptable_modes_pair_step_finger(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                     struct haptable_modes_pair* state, struct haptable_pair* pair, int number,
                                     const float finger_m[3], uint32_t now_us, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
