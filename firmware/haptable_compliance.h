/* SPDX-License-Identifier: MIT
 *
 * C(alpha) of a contact point, and f = C^-1 u: the load on the body that moves the point by u.
 */
#ifndef HAPTABLE_COMPLIANCE_H
#define HAPTABLE_COMPLIANCE_H

#include "haptable_matrix.h"
#include "haptable_model.h"

#define HAPTABLE_COMPLIANCE_CONTROLS 15 /* of degree 4; degree 2 has 6 */

/* Where a patch's blocks stand in the order of their exponents (haptable_polynomial.h): those of its corners, those of
 * the edge opposite to corner c from the next corner to the one after, and for degree 4 those with exponent 2 at corner
 * c. */
struct haptable_compliance_form {
    uint8_t degree; /* 2 or 4 */
    uint8_t vertex[3];
    uint8_t edge[3][3];
    uint8_t inside[3];
};

/* Newton's correction of a point that follows the finger may be this much of a patch at the most: its own error is then
 * below a float's rounding. */
#define HAPTABLE_CORRECTION 2e-3f

/* ---- fixed vertices ------------------------------------------------------------------------------------------- */

/* The fraction of alpha on fixed vertices. */
static inline float fixed_fraction(const struct haptable_model* model, const struct haptable_contact* contact) {
    float fraction = 0.0f;
    for (int corner = 0; corner < 3; ++corner)
        if (model->patch[contact->patch][corner] >= model->free_count) fraction += contact->alpha[corner];
    return fraction;
}

/* What C's diagonal lacks to the fixed vertices' fraction of 1 / rigid_stiffness. */
static inline float missing_of(const struct haptable_model* model, float fraction, const float c[6]) {
    return fraction / model->rigid_stiffness_n_per_m - sym_third_of_trace(c);
}

/* Lifts C's diagonal by what it lacks. Returns 1 where it did. */
static inline int lift(const struct haptable_model* model, float fraction, float c[6]) {
    if (fraction <= 0.0f) return 0;
    const float missing = missing_of(model, fraction, c);
    if (missing <= 0.0f) return 0;
    for (int i = 0; i < 3; ++i) c[i] += missing;
    return 1;
}

/* C^-1 times finger - god-object, where C, which is given, is first lifted at fixed vertices.
 * Fixed vertices add no compliance: with s the sum of their alpha, C + max(0, s / rigid_stiffness - trace C / 3) I is
 * what is inverted. It is C where C's mean is larger, rigid_stiffness^-1 where all three are fixed, and continuous.
 * after: load_n is finite where u is. */
void haptable_compliance_solve(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float c[6], float load_n[3]);

/* The nodal forces alpha_i f of a load f, and the reaction -f. */
void haptable_compliance_distribute(const float load_n[3], const struct haptable_contact* contact,
                                    float nodal_force_n[3][3], float force_n[3]);

#endif
