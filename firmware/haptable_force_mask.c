/* SPDX-License-Identifier: MIT
 *
 * F = -C^-1 u,   C = sum_ab w_a(g) w_b(g) L_ab,   w quadratic in the area coordinates: C is of degree 4
 */
#include "haptable_compliance.h"

static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

void haptable_force_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float load_n[3];
    haptable_compliance_load(model, &mask_form, contact, finger_m, load_n);
    haptable_compliance_distribute(load_n, contact, nodal_force_n, force_n);
}

void haptable_force_pressure_mask_packed(const struct haptable_model* model, const struct haptable_contact* contact,
                                         const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float load_n[3];
    haptable_compliance_load_packed(model, &mask_form, contact, finger_m, load_n);
    haptable_compliance_distribute(load_n, contact, nodal_force_n, force_n);
}

void haptable_energy_pressure_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float finger_m[3], enum haptable_energy_terms terms,
                                   struct haptable_energy* energy) {
    haptable_compliance_energy(model, &mask_form, contact, finger_m, terms, energy);
}

void haptable_energy_pressure_mask_packed(const struct haptable_model* model, const struct haptable_contact* contact,
                                          const float finger_m[3], enum haptable_energy_terms terms,
                                          struct haptable_energy* energy) {
    haptable_compliance_energy_packed(model, &mask_form, contact, finger_m, terms, energy);
}
