/* SPDX-License-Identifier: MIT
 *
 * f = C^-1 u,   F = -f,   F_a = alpha_a f
 */
#include "haptable_compliance.h"

void haptable_compliance_solve(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float c[6], float load_n[3]) {
    float u[3];
    lift(model, fixed_fraction(model, contact), c);
    vec_sub(finger_m, contact->god_object_m, u);
    sym_solve_once(c, u, load_n);
}

void haptable_compliance_distribute(const float load_n[3], const struct haptable_contact* contact,
                                    float nodal_force_n[3][3], float force_n[3]) {
    vec_zero(force_n);
    vec_add_scaled(-1.0f, load_n, force_n);
    for (int corner = 0; corner < 3; ++corner) {
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], load_n, nodal_force_n[corner]);
    }
}
