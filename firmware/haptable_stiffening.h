/* SPDX-License-Identifier: MIT
 *
 * Psi and its derivatives: haptable_stiffening.c has the law.
 */
#ifndef HAPTABLE_STIFFENING_H
#define HAPTABLE_STIFFENING_H

#include "haptable_model.h"
#include "haptable_vector.h"

/* In a curve's row after c_1, c_2, c_3: 1 / (2 e_0). */
#define HAPTABLE_STIFFENING_PER_WORK 3

/* s of e / e_0, within 5e-6 of itself: another curve by as little, and force and energy are of one curve. */
static inline float stiffening_root(float part) {
    return vec_is_below_one(part) ? part * vec_inverse_root_by(part, 2) : 1.0f;
}

/* Psi' of s. */
static inline float stiffening_factor(const float c[4], float s) { return 1.0f + s * (c[0] + s * (c[1] + s * c[2])); }

/* Psi / e below e_0, and 2 e Psi'' there. */
static inline float stiffening_mean(const float c[4], float s) {
    return 1.0f + s * (2.0f / 3.0f * c[0] + s * (0.5f * c[1] + s * (0.4f * c[2])));
}
static inline float stiffening_slope(const float c[4], float s) {
    return s * (c[0] + s * (2.0f * c[1] + s * (3.0f * c[2])));
}

/* What a contact has whose linear energy is half of work_j. Returns Psi'. */
float haptable_stiffening_put(const float c[4], float work_j, struct haptable_stiffened* stiffened);

/* Psi' of a tick's contact; 1 without one, as its force is 0. before: out has its linear force. */
static inline float stiffening_factor_of(const struct haptable_model* model, const struct haptable_servo* servo,
                                         const struct haptable_output* out) {
    const float* c = model->stiffening;
    float u[3];
    vec_sub(out->god_object_m, servo->finger_m, u);
    return stiffening_factor(c, stiffening_root(vec_dot(u, out->force_n) * c[HAPTABLE_STIFFENING_PER_WORK]));
}

#endif
