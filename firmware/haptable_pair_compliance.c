/* SPDX-License-Identifier: MIT
 *
 * [C_1 X; X^T C_2] f = u,   C_c = C(alpha) of one finger,   X = sum_kl w_k w_l C_kl over the controls of two patches
 */
#include "haptable_pair_laws.h"
#include "haptable_polynomial.h"

static inline void slope_of(const struct haptable_model* model, int degree, const struct haptable_contact* contact,
                            struct haptable_pair_point* point, const float v[3], int is_whole,
                            struct haptable_pair_slope* slope) {
    const float by[3] = {v[0], v[1], v[2]}; /* apart from what is written */
    float first_m[2][3], second_j[3];
    vary(degree, point->linear, by, point->lifted, first_m);
    if (point->lifted) vary_fraction(model, contact->patch, by, first_m);
    for (int b = 0; b < 2; ++b) {
        const float* e = point->e[b];
        const float* a_v = first_m[b];
        slope->first_j[b] = -vec_dot(e, by) - 0.5f * vec_dot(by, a_v);
        slope->y[b][0] = -e[0] - a_v[0];
        slope->y[b][1] = -e[1] - a_v[1];
        slope->y[b][2] = -e[2] - a_v[2];
        vec_copy(a_v, slope->a_v[b]);
    }
    if (!is_whole) return;
    bend_net(point->net.block, degree, by, point->lifted, second_j);
    for (int b = 0; b < 3; ++b) slope->second_j[b] = -0.5f * second_j[b];
}

void haptable_pair_slope_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                                    struct haptable_pair_point* point, const float v[3], int is_whole,
                                    struct haptable_pair_slope* slope) {
    slope_of(model, 2, contact, point, v, is_whole, slope);
}

void haptable_pair_slope_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                              struct haptable_pair_point* point, const float v[3], int is_whole,
                              struct haptable_pair_slope* slope) {
    slope_of(model, 4, contact, point, v, is_whole, slope);
}

void haptable_pair_load_of_compliance(const struct haptable_model* model, const struct haptable_contact* contact,
                                      const float v[3], float nodal_force_n[3][3], float force_n[3]) {
    (void)model;
    haptable_compliance_distribute(v, contact, nodal_force_n, force_n);
}

#define HAPTABLE_STORED(name) name
#define HAPTABLE_GATHER gather
#define HAPTABLE_IS_PACKED 0
#include "haptable_pair_compliance_template.h"
