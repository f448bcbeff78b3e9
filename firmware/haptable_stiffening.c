/* SPDX-License-Identifier: MIT
 *
 * E = Psi(e),   F = Psi'(e) F_lin,   Psi'(e) = 1 + c_1 s + c_2 s^2 + c_3 s^3,   s = min(1, sqrt(e / e_0))
 *
 * e = 1/2 u^T S u is the linear energy of the contact, e_0 the largest that the curve was fitted to. E is a function of
 * the finger and of the god-object, and Psi grows: contact stays conservative, and the point of least energy is that of
 * the linear body. Beyond e_0 the factor stays, so that the force goes on growing with the dent.
 */
#include "haptable_stiffening.h"

void haptable_stiffening(const struct haptable_model* model, struct haptable_servo* servo,
                         struct haptable_output* out) {
    vec_scale(stiffening_factor_of(model, servo, out), out->force_n);
}

/* Psi = e_0 s^2 (1 + 2/3 c_1 s + 1/2 c_2 s^2 + 2/5 c_3 s^3) + Psi' (e - e_0 s^2);   2 e Psi'' = s dPsi'/ds for s < 1 */
float haptable_stiffening_put(const float c[4], float work_j, struct haptable_stiffened* stiffened) {
    const float part = work_j * c[HAPTABLE_STIFFENING_PER_WORK];
    const float s = stiffening_root(part);
    const float factor = stiffening_factor(c, s);
    const float within = part < 1.0f ? 1.0f : 1.0f / part; /* of e */
    stiffened->stored = within * (stiffening_mean(c, s) / factor) + (1.0f - within);
    stiffened->tangent = part < 1.0f ? 1.0f + stiffening_slope(c, s) / factor : 1.0f;
    return factor;
}

float haptable_stiffened_of(const struct haptable_model* model, const struct haptable_servo* servo,
                            struct haptable_stiffened* stiffened) {
    float nodal_n[3][3], force_n[3], u[3];
    model->force(model, &servo->contact, servo->finger_m, nodal_n, force_n);
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    return haptable_stiffening_put(model->stiffening, -vec_dot(u, force_n), stiffened);
}
