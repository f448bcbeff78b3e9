/* SPDX-License-Identifier: MIT
 *
 * F = -(alpha_i S_i + alpha_j S_j + alpha_k S_k) u
 */
#include "force.h"

#include "vector.h"

/* f = S u for a symmetric S stored as xx yy zz xy yz zx. */
static void symmetric_product(const float s[6], const float u[3], float f[3]) {
    f[0] = s[0] * u[0] + s[3] * u[1] + s[5] * u[2];
    f[1] = s[3] * u[0] + s[1] * u[1] + s[4] * u[2];
    f[2] = s[5] * u[0] + s[4] * u[1] + s[2] * u[2];
}

void force_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                        const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float u[3];
    int corner;
    vec_sub(finger_m, contact->god_object_m, u);
    vec_zero(force_n);
    for (corner = 0; corner < 3; ++corner) {
        const uint16_t vertex = model->patch[contact->patch][corner];
        float f[3]; /* eq. 9: the force if this node alone were displaced by u */
        if (vertex < model->free_count) {
            symmetric_product(model->stiffness_n_per_m[vertex], u, f);
        } else {
            vec_zero(f);
            vec_add_scaled(model->rigid_stiffness_n_per_m, u, f);
        }
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], f, nodal_force_n[corner]); /* eq. 10 */
        vec_add_scaled(-1.0f, nodal_force_n[corner], force_n);            /* eq. 12 */
    }
}

int force_clamp(float max_n, float force_n[3]) {
    const float size2 = vec_dot(force_n, force_n);
    float scale;
    if (size2 <= max_n * max_n) return 0;
    scale = max_n * vec_inverse_root(size2);
    force_n[0] *= scale;
    force_n[1] *= scale;
    force_n[2] *= scale;
    return 1;
}
