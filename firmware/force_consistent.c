/* SPDX-License-Identifier: MIT
 *
 * F = -C^-1 u,   C = sum_ab alpha_a alpha_b L_ab
 */
#include "compliance.h"

static const struct compliance_control control[6] = {
    {{2, 0, 0}, 1}, {{0, 2, 0}, 1}, {{0, 0, 2}, 1}, {{0, 1, 1}, 2}, {{1, 0, 1}, 2}, {{1, 1, 0}, 2},
};
static const struct compliance_form form = {6, control};

void haptable_force_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float load_n[3];
    compliance_load(model, &form, contact, finger_m, load_n);
    compliance_share(load_n, contact, nodal_force_n, force_n);
}

void haptable_energy_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                                const float finger_m[3], struct haptable_energy* energy) {
    compliance_energy(model, &form, contact, finger_m, energy);
}
