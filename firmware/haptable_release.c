/* SPDX-License-Identifier: MIT
 *
 * F = F_contact + R,   |R| falls by release_n a tick,   R . d <= 0: what is left of a force that has ended only
 * brakes
 */
#include "haptable.h"
#include "haptable_vector.h"

/* The largest change of a contact's force over the finger's motion that is no jump, as a multiple of its stiffness. */
#define JUMP 2.0f

/* The square of the stiffness that the contact shows, |F| / |u|. before: contact. */
static float shown_stiffness2(const struct haptable_model* model, const struct haptable_servo* servo,
                              const float force_n[3]) {
    const float most2 = model->stiffness_limit_n_per_m * model->stiffness_limit_n_per_m;
    float u[3];
    float u2;
    float force2;
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    u2 = vec_dot(u, u);
    force2 = vec_dot(force_n, force_n);
    if (!(u2 > 0.0f)) return 0.0f; /* the finger is on the surface: the force has ended */
    return force2 < most2 * u2 ? force2 / u2 : most2;
}

/* 1 where the force changed by more than the finger's motion explains; without contact, where it has ended. */
static int has_jumped(const struct haptable_model* model, const struct haptable_servo* servo, const float force_n[3],
                      const float change_n[3], const float motion_m[3]) {
    const float change2 = vec_dot(change_n, change_n);
    if (servo->contact.patch == HAPTABLE_NONE) return change2 > 0.0f;
    if (change2 <= model->release_n * model->release_n) return 0; /* most ticks */
    return change2 > JUMP * JUMP * shown_stiffness2(model, servo, force_n) * vec_dot(motion_m, motion_m) +
                         model->release_n * model->release_n;
}

/* Shortens R by release_n. */
static void shorten(float by_n, float r[3]) {
    const float size2 = vec_dot(r, r);
    float scale;
    if (size2 <= by_n * by_n) {
        vec_zero(r);
        return;
    }
    scale = 1.0f - by_n * vec_inverse_root(size2);
    r[0] *= scale;
    r[1] *= scale;
    r[2] *= scale;
}

/* Takes away what of R would push the finger on. */
static void only_brake(const float motion_m[3], float r[3]) {
    const float power = vec_dot(r, motion_m);
    const float motion2 = vec_dot(motion_m, motion_m);
    if (power > 0.0f && motion2 > 0.0f) vec_add_scaled(-power / motion2, motion_m, r);
}

void haptable_release_slew(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                           float force_n[3]) {
    float change[3];
    vec_sub(servo->felt_n, force_n, change);
    vec_copy(force_n, servo->felt_n);
    if (has_jumped(model, servo, force_n, change, motion_m)) {
        ++servo->counters.jumps;
        vec_add_scaled(1.0f, change, servo->released_n);
    }
    shorten(model->release_n, servo->released_n);
    only_brake(motion_m, servo->released_n);
    vec_add_scaled(1.0f, servo->released_n, force_n);
}
