/* SPDX-License-Identifier: MIT
 *
 * What haptable_relaxation.c and haptable_relaxation_held.c are made of.
 */
#ifndef HAPTABLE_RELAXATION_H
#define HAPTABLE_RELAXATION_H

#include "haptable_model.h"
#include "haptable_vector.h"

/* A row of model->term. */
enum { TERM_SHARE, TERM_FALL, TERM_RISE };

/* Begins a tick: what was not seen to go on is forgotten. Returns what the body remembers of the finger. */
struct haptable_relaxed* haptable_relaxation_meet(const struct haptable_model* model, struct haptable_servo* servo);

/* The tick of a contact that slides, or of none. before: haptable_relaxation_meet; branches are no vectors. */
void haptable_relaxation_slide(const struct haptable_model* model, const struct haptable_servo* servo,
                               struct haptable_relaxed* relaxed, struct haptable_output* out);

/* Remembers where the finger is and by which loads the surface is where it is, if the finger should leave. */
void haptable_relaxation_note(struct haptable_relaxed* relaxed, const struct haptable_output* out);

/* r <- r + rise change - fall r, compensated (Kahan 1965): a fall of 1e-7 is not lost. */
static inline void haptable_relaxation_go(const float term[3], float change, float* branch, float* lost) {
    const float step = (term[TERM_RISE] * change - term[TERM_FALL] * *branch) + *lost;
    const float next = *branch + step;
    *lost = step - (next - *branch);
    *branch = next;
}

/* s = factor sqrt(u . S u), and 1 / s, with work_j = u . F_e; 0 and 0 where it is none. */
static inline float haptable_relaxation_size(float work_j, float factor, float* inverse) {
    const float twice_energy_j = work_j / factor;
    *inverse = 0.0f;
    if (!(twice_energy_j > HAPTABLE_ROOT_LEAST && twice_energy_j < HAPTABLE_ROOT_MOST)) return 0.0f;
    const float inverse_root = vec_inverse_root(twice_energy_j);
    *inverse = inverse_root / factor;
    return factor * (twice_energy_j * inverse_root);
}

/* haptable_relaxation_slide of a body whose dents stiffen. before: out has the elastic force F_e, which is `factor`
 * times the linear one. */
void haptable_relaxation_slide_stiffened(const struct haptable_model* model, const struct haptable_servo* servo,
                                         struct haptable_relaxed* relaxed, float factor, struct haptable_output* out);

/* haptable_relaxation_held of such a body. before: the same. */
void haptable_relaxation_held_stiffened(const struct haptable_model* model, struct haptable_servo* servo, float factor,
                                        struct haptable_output* out);

#endif
