/* SPDX-License-Identifier: MIT
 *
 * C(alpha) of a contact point, and f = C^-1 u: the load on the body that moves the point by u.
 */
#ifndef HAPTABLE_COMPLIANCE_H
#define HAPTABLE_COMPLIANCE_H

#include "haptable_model.h"

#define HAPTABLE_COMPLIANCE_CONTROLS 15 /* of degree 4; degree 2 has 6 */

/* Where a patch's blocks stand in the order of their exponents (haptable_compliance.c): those of its corners, those of
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

/* C^-1 times finger - god-object, where C, which is given, is first lifted at fixed vertices.
 * Fixed vertices add no compliance: with s the sum of their alpha, C + max(0, s / rigid_stiffness - trace C / 3) I is
 * what is inverted. It is C where C's mean is larger, rigid_stiffness^-1 where all three are fixed, and continuous.
 * after: load_n is finite where u is. */
void haptable_compliance_solve(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float c[6], float load_n[3]);

/* The same with C(alpha) of the patch. before: model->compliance has degree 4, that of the form. */
void haptable_compliance_load(const struct haptable_model* model, const struct haptable_compliance_form* form,
                              const struct haptable_contact* contact, const float finger_m[3], float load_n[3]);

/* The same where the blocks are stored in 16 bits, of either degree. before: model->unpack is not NULL. */
void haptable_compliance_load_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]);

/* The nodal forces alpha_i f of a load f, and the reaction -f. */
void haptable_compliance_distribute(const float load_n[3], const struct haptable_contact* contact,
                                    float nodal_force_n[3][3], float force_n[3]);

/* E = 1/2 u^T C^-1 u and its derivatives; or its gradient alone, with the load that is in `energy`. Where the lift may
 * begin or end within HAPTABLE_CORRECTION, the load's derivative, which steps there, is no number.
 * cost: the blocks three times each and three solves with C; the blocks twice each. */
void haptable_compliance_energy(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                const struct haptable_contact* contact, const float finger_m[3],
                                enum haptable_energy_terms terms, struct haptable_energy* energy);

/* The same where the blocks are stored in 16 bits. cost: besides, every block expanded once. */
void haptable_compliance_energy_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                       const struct haptable_contact* contact, const float finger_m[3],
                                       enum haptable_energy_terms terms, struct haptable_energy* energy);

#endif
