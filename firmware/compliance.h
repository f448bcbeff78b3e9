/* SPDX-License-Identifier: MIT
 *
 * C(alpha) of a contact point, and f = C^-1 u: the load on the body that moves the point by u.
 */
#ifndef HAPTABLE_COMPLIANCE_H
#define HAPTABLE_COMPLIANCE_H

#include "haptable.h"

#define COMPLIANCE_CONTROLS 15 /* of degree 4; degree 2 has 6 */

/* One control point of Bernstein's form: its exponents and degree! / (i! j! k!). */
struct compliance_control {
    uint8_t exponent[3];
    uint8_t factor;
};

/* A degree's control points: three vertices, then degree - 1 on the edge opposite to corner 0, 1, 2, from corner c + 1
 * to c + 2, then those inside. */
struct compliance_form {
    int count;
    const struct compliance_control* control;
};

/* The load of a contact: C(alpha) of the patch, lifted at fixed vertices, and its inverse times finger - god-object.
 * Fixed vertices add no compliance: with s the sum of their alpha, C + max(0, s / rigid_stiffness - trace C / 3) I is
 * what is inverted. It is C where C's mean is larger, rigid_stiffness^-1 where all three are fixed, and continuous.
 * before: model->compliance has the form's degree. after: load_n is finite where u is. */
void compliance_load(const struct haptable_model* model, const struct compliance_form* form,
                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]);

/* The nodal forces alpha_i f of a load f, and the reaction -f. */
void compliance_share(const float load_n[3], const struct haptable_contact* contact, float nodal_force_n[3][3],
                      float force_n[3]);

/* E = 1/2 u^T C^-1 u and its derivatives. cost: the blocks once each, three solves with C. */
void compliance_energy(const struct haptable_model* model, const struct compliance_form* form,
                       const struct haptable_contact* contact, const float finger_m[3], struct haptable_energy* energy);

#endif
