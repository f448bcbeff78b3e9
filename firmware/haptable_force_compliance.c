/* SPDX-License-Identifier: MIT
 *
 * F = -C^-1 u with blocks in float32, where they stand in flash
 *
 * Consistent: C = sum_ab alpha_a alpha_b L_ab. Under a mask C = sum_ab w_a(g) w_b(g) L_ab, w quadratic in the area
 * coordinates: C is of degree 4.
 */
#include "haptable_polynomial.h"

void haptable_force_of_least_energy(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    (void)model;
    (void)finger_m;
    haptable_compliance_distribute(contact->load_n, contact, nodal_force_n, force_n);
}

/* C = sum alpha_a^2 L_aa + sum 2 alpha_a alpha_b L_ab, without the scheme for all degrees: half the work. */
static void compliance_of_point(const struct haptable_model* model, const struct haptable_contact* contact,
                                float c[6]) {
    const struct haptable_compliance* table = model->compliance;
    const uint16_t* v = model->patch[contact->patch];
    const uint16_t* e = table->patch_edge[contact->patch];
    const float* a = contact->alpha;
    const float w[6] = {a[0] * a[0],        a[1] * a[1],        a[2] * a[2],
                        2.0f * a[1] * a[2], 2.0f * a[2] * a[0], 2.0f * a[0] * a[1]};
    for (int i = 0; i < 6; ++i)
        c[i] = w[0] * table->vertex[v[0]][i] + w[1] * table->vertex[v[1]][i] + w[2] * table->vertex[v[2]][i] +
               w[3] * table->edge[e[0]][i] + w[4] * table->edge[e[1]][i] + w[5] * table->edge[e[2]][i];
}

void haptable_force_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float load_n[3], c[6];
    compliance_of_point(model, contact, c);
    haptable_compliance_solve(model, contact, finger_m, c, load_n);
    haptable_compliance_distribute(load_n, contact, nodal_force_n, force_n);
}

#define HAPTABLE_STORED(name) name
#define HAPTABLE_GATHER gather
#include "haptable_compliance_template.h"
