/* SPDX-License-Identifier: MIT
 *
 * E = Psi(e),   F = Psi'(e) F_lin,   Psi'(e) = 1 + c_1 s + c_2 s^2 + c_3 s^3,   s = min(1, sqrt(e / e_0))
 *
 * e = 1/2 u^T S u is the linear energy of the contact, e_0 the largest that the curve was fitted to. E is a function of
 * the finger and of the god-object, and Psi grows: contact stays conservative, and the point of least energy is that of
 * the linear body. Beyond e_0 the factor stays, so that the force goes on growing with the dent.
 */
#include "haptable_model.h"
#include "haptable_vector.h"

/* Psi', and the part e / e_0 and its root. before: linear_n is the linear force. */
HAPTABLE_CALLED float factor_of(const struct haptable_model* model, const struct haptable_contact* contact,
                                const float finger_m[3], const float linear_n[3], float* part, float* s) {
    const float* c = model->stiffening;
    float u[3];
    vec_sub(finger_m, contact->god_object_m, u);
    *part = -vec_dot(u, linear_n) * c[3];
    *s = 0.0f;
    if (*part > HAPTABLE_ROOT_LEAST) *s = *part < 1.0f ? *part * vec_inverse_root(*part) : 1.0f;
    return 1.0f + *s * (c[0] + *s * (c[1] + *s * c[2]));
}

void haptable_force_stiffening(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float part, s;
    model->linear(model, contact, finger_m, nodal_force_n, force_n);
    vec_scale(factor_of(model, contact, finger_m, force_n, &part, &s), force_n);
}

/* Psi = e_0 s^2 (1 + 2/3 c_1 s + 1/2 c_2 s^2 + 2/5 c_3 s^3) + Psi' (e - e_0 s^2);   2 e Psi'' = s dPsi'/ds for s < 1 */
float haptable_stiffening(const struct haptable_model* model, const struct haptable_contact* contact,
                          const float finger_m[3], struct haptable_stiffened* stiffened) {
    const float* c = model->stiffening;
    float nodal_n[3][3], linear_n[3], part, s;
    model->linear(model, contact, finger_m, nodal_n, linear_n);
    const float factor = factor_of(model, contact, finger_m, linear_n, &part, &s);
    const float curve = 1.0f + s * (2.0f / 3.0f * c[0] + s * (0.5f * c[1] + s * (0.4f * c[2])));
    const float within = part < 1.0f ? 1.0f : 1.0f / part; /* of e */
    stiffened->stored = within * (curve / factor) + (1.0f - within);
    stiffened->tangent = part < 1.0f ? 1.0f + s * (c[0] + s * (2.0f * c[1] + s * (3.0f * c[2]))) / factor : 1.0f;
    return factor;
}
