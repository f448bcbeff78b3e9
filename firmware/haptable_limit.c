/* SPDX-License-Identifier: MIT
 *
 * gain <- the largest that keeps    |gain F - c F'| <= rate_n for a c in 0..1, F' the last force given
 *                            and    gain^2 F^2 <= L + (L - m) slope,   m <- m + share (F'^2 - m),   L = mean_limit_n2
 *
 * The gain only falls while contact lasts (but for haptable_resume.c): a finger that has pressed against the body's
 * whole force, or more of it than now, gets no more back than it gave.
 */
#include "haptable_model.h"
#include "haptable_vector.h"

static float root(float x) { return x > HAPTABLE_ROOT_LEAST ? x * vec_inverse_root(x) : 0.0f; }

/* The largest gain whose force is within r of the last force given, B, or of a part of it. before: |F| > 0 */
static float gain_within(float r, const float force_n[3], const float before_n[3]) {
    const float force2 = vec_length2(force_n);
    const float before2 = vec_length2(before_n);
    const float along = vec_dot(force_n, before_n);
    if (along <= 0.0f) return r / root(force2);
    const float across2 = force2 - along * (along / before2); /* of what is left of F without its part along B */
    if (across2 * before2 * before2 >= r * r * along * along) return r / root(across2);
    /* beyond the end of B: |gain F - B| = r */
    return (along + root(force2 * r * r - across2 * before2)) / force2;
}

void haptable_limit_rate(const struct haptable_model* model, struct haptable_servo* servo, const float force_n[3]) {
    const float r = model->rate_n;
    float change[3];
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) change[i] = servo->gain * force_n[i] - servo->given_n[i];
    if (vec_length2(change) <= r * r) return; /* most ticks */
    const float gain = gain_within(r, force_n, servo->given_n);
    if (gain >= servo->gain) return;
    servo->gain = gain;
    ++servo->counters.rate_limits;
}

void haptable_limit_mean(const struct haptable_model* model, struct haptable_servo* servo, const float force_n[3]) {
    const float limit2 = model->mean_limit_n2;
    servo->mean_n2 += model->mean_share * (vec_length2(servo->given_n) - servo->mean_n2);
    if (servo->mean_n2 <= 0.5f * limit2) return; /* most ticks */
    const float most2 = limit2 + (limit2 - servo->mean_n2) * model->mean_slope;
    const float force2 = vec_length2(force_n);
    if (servo->gain * servo->gain * force2 <= most2) return;
    servo->gain = root(most2 / force2);
    ++servo->counters.mean_limits;
}

void haptable_limit_force(const struct haptable_model* model, struct haptable_servo* servo,
                          struct haptable_output* out) {
    const int touches = servo->contact.patch != HAPTABLE_NONE;
    const int has_left = !touches && vec_length2(out->force_n) == 0.0f;
    if (has_left) servo->gain = 1.0f;
    if (model->mean) model->mean(model, servo, out->force_n);
    if (model->rate && !has_left) model->rate(model, servo, out->force_n); /* no force is within any rate */
    if (!(servo->gain < 1.0f)) return;                                     /* most ticks */
    vec_scale(servo->gain, out->force_n);
    if (!touches) return;
    ++servo->counters.limited_ticks;
    servo->state = out->state = HAPTABLE_LIMITED;
}
