/* SPDX-License-Identifier: MIT
 *
 * W = sum F_k . (x_k+1 - x_k),   W > 0: F <- F - W way / |way|^2
 */
#include "haptable.h"
#include "vector.h"

/* A force held over a tick (zero-order hold) does F_k . way to the user: W is exactly what was given. What is owed is
 * braked away in the next tick if the finger goes on as it went. The brake is at most as large as max_force_n. */
void haptable_passivity_control(const struct haptable_model* model, struct haptable_servo* servo, const float way_m[3],
                                float force_n[3]) {
    const float way2 = vec_dot(way_m, way_m);
    float brake;
    servo->given_j += vec_dot(servo->given_n, way_m);
    if (servo->given_j <= 0.0f || way2 <= 0.0f) return;
    brake = servo->given_j / way2; /* N/m, along the way */
    if (brake * brake * way2 > model->max_force_n * model->max_force_n)
        brake = model->max_force_n * vec_inverse_root(way2 > 1e-30f ? way2 : 1e-30f);
    vec_add_scaled(-brake, way_m, force_n);
}
