/* SPDX-License-Identifier: MIT
 *
 * gain <- min(1, gain + resume_gain),   from 0 where contact begins inside the body
 *
 * The nearest patch of the whole surface is sought over several ticks. Inside of it begins a contact, which the
 * god-object then slides on, or lets go where the finger is seen outside.
 */
#include "haptable_model.h"
#include "haptable_patch.h"
#include "haptable_side.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

static void begin(struct haptable_servo* servo) {
    servo->seek_patch = 0;
    servo->nearest_patch = 0;
    servo->nearest_m2 = HAPTABLE_MOST;
}

static void try_patch(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    struct haptable_contact nearest;
    haptable_patch_nearest(model, servo->seek_patch, x_m, &nearest);
    const float distance2 = gap2(nearest.god_object_m, x_m);
    if (distance2 < servo->nearest_m2) {
        servo->nearest_m2 = distance2;
        servo->nearest_patch = servo->seek_patch;
    }
    ++servo->seek_patch;
}

/* All patches were tried: contact, where the finger is not outside of the nearest. */
static void end(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    struct haptable_contact nearest = *contact;
    float u[3];
    servo->seek_patch = HAPTABLE_NONE;
    nearest.patch = servo->nearest_patch;
    haptable_patch_nearest(model, servo->nearest_patch, x_m, &nearest);
    vec_sub(x_m, nearest.god_object_m, u);
    if (haptable_side_of(model, &nearest, u) != HAPTABLE_SIDE_INSIDE) return;
    *contact = nearest;
    contact->slips = 0;
    if (model->energy) {
        vec_zero(servo->sensitivity_per_m[0]);
        vec_zero(servo->sensitivity_per_m[1]);
    }
    servo->segment.unfinished = 0;
    servo->gain = 0.0f;
    ++servo->counters.contacts;
}

/* cost: HAPTABLE_SEEK_PATCHES nearest points, for patch_count / HAPTABLE_SEEK_PATCHES ticks; then one of a side. */
void haptable_resume_ramp(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    if (servo->contact.patch != HAPTABLE_NONE) {
        servo->seek_patch = HAPTABLE_NONE;
        if (servo->gain < 1.0f) servo->gain = vec_clamp01(servo->gain + model->resume_gain);
        return;
    }
    if (!servo->finger_known) begin(servo);
    if (servo->seek_patch == HAPTABLE_NONE) return;
    for (int patches = 0; patches < HAPTABLE_SEEK_PATCHES && servo->seek_patch < model->patch_count; ++patches)
        try_patch(model, servo, x_m);
    if (servo->seek_patch >= model->patch_count) end(model, servo, x_m);
}
