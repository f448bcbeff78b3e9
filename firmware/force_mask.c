/* SPDX-License-Identifier: MIT
 *
 * F = -C^-1 u,   C = sum_ab w_a(g) w_b(g) L_ab,   w quadratic in the area coordinates: C is of degree 4
 */
#include "compliance.h"

/* Vertices; then on the edges opposite to corner 0, 1, 2 from its next corner to the one after; then inside. */
static const struct compliance_control control[15] = {
    {{4, 0, 0}, 1}, {{0, 4, 0}, 1}, {{0, 0, 4}, 1},  {{0, 3, 1}, 4},  {{0, 2, 2}, 6},
    {{0, 1, 3}, 4}, {{1, 0, 3}, 4}, {{2, 0, 2}, 6},  {{3, 0, 1}, 4},  {{3, 1, 0}, 4},
    {{2, 2, 0}, 6}, {{1, 3, 0}, 4}, {{2, 1, 1}, 12}, {{1, 2, 1}, 12}, {{1, 1, 2}, 12},
};
static const struct compliance_form form = {15, control};

void haptable_force_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float load_n[3];
    compliance_load(model, &form, contact, finger_m, load_n);
    compliance_share(load_n, contact, nodal_force_n, force_n);
}

void haptable_energy_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float finger_m[3], struct haptable_energy* energy) {
    compliance_energy(model, &form, contact, finger_m, energy);
}
