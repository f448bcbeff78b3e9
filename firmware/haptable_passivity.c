/* SPDX-License-Identifier: MIT
 *
 * W = sum F_k . (x_k+1 - x_k),   W > 0: F <- F - W d / |d|^2,   d = x_k+1 - x_k
 */
#include "haptable_force.h"
#include "haptable_vector.h"

float haptable_brake_of(const struct haptable_model* model, float given_j, float motion2_m2) {
    const float most = HAPTABLE_BRAKE * model->stiffness_limit_n_per_m;
    if (!(given_j > 0.0f && motion2_m2 > 0.0f)) return 0.0f;
    return given_j < most * motion2_m2 ? given_j / motion2_m2 : most;
}

float haptable_brake_within(const struct haptable_model* model, float by, float motion2_m2) {
    if (!(by * by * motion2_m2 > model->max_force_n * model->max_force_n)) return by;
    return model->max_force_n * vec_inverse_root(motion2_m2 > HAPTABLE_ROOT_LEAST ? motion2_m2 : HAPTABLE_ROOT_LEAST);
}

void haptable_brake(const struct haptable_model* model, float by, const float motion_m[3], float force_n[3]) {
    vec_add_scaled(-haptable_brake_within(model, by, vec_length2(motion_m)), motion_m, force_n);
}

/* A force held over a tick (zero-order hold) does F_k . d to the user: W is exactly what was given. What is owed is
 * braked away in the next tick if the finger goes on as it went, as far as the device bears such a brake; its force is
 * at most max_force_n. */
void haptable_passivity_control(const struct haptable_model* model, struct haptable_servo* servo,
                                const float motion_m[3], float force_n[3]) {
    servo->given_j += vec_dot(servo->given_n, motion_m);
    const float by = haptable_brake_of(model, servo->given_j, vec_length2(motion_m));
    if (by > 0.0f) haptable_brake(model, by, motion_m, force_n); /* in few ticks */
}
