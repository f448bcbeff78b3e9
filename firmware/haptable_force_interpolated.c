/* SPDX-License-Identifier: MIT
 *
 * F = -(alpha_i S_i + alpha_j S_j + alpha_k S_k) u
 */
#include "haptable_block.h"
#include "haptable_model.h"
#include "haptable_vector.h"

void haptable_force_interpolated(const struct haptable_model* model, const struct haptable_contact* contact,
                                 const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    float u[3];
    vec_sub(finger_m, contact->god_object_m, u);
    vec_zero(force_n);
    HAPTABLE_UNROLLED
    for (int corner = 0; corner < 3; ++corner) {
        float f[3]; /* eq. 9: the force if this node alone were displaced by u */
        block_product(model, model->patch[contact->patch][corner], u, f);
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], f, nodal_force_n[corner]); /* eq. 10 */
        vec_add_scaled(-1.0f, nodal_force_n[corner], force_n);            /* eq. 12 */
    }
}
