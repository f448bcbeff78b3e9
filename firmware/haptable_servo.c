/* SPDX-License-Identifier: MIT
 *
 * finger -> checked -> god-object -> force -> checked -> out
 */
#include "haptable.h"
#include "haptable_contact.h"
#include "haptable_force.h"
#include "haptable_vector.h"

static void put_nothing(uint8_t state, struct haptable_output* out) {
    int corner;
    out->state = state;
    out->patch = HAPTABLE_NONE;
    vec_zero(out->alpha);
    vec_zero(out->god_object_m);
    vec_zero(out->force_n);
    for (corner = 0; corner < 3; ++corner) {
        out->vertex[corner] = HAPTABLE_NONE;
        vec_zero(out->nodal_force_n[corner]);
    }
}

static void drop_contact(struct haptable_servo* servo) {
    haptable_contact_end(servo);
    servo->finger_known = 0;
    vec_zero(servo->felt_n);
    vec_zero(servo->released_n);
    servo->owed_j = 0.0f;
    vec_zero(servo->given_n);
}

/* 1 when the position is a number and within the workspace limit. */
static int is_position(const struct haptable_model* model, const float finger_m[3]) {
    float offset[3];
    if (!vec_finite(finger_m)) return 0;
    vec_sub(finger_m, model->grid_origin_m, offset);
    return vec_dot(offset, offset) <= model->workspace_limit_m * model->workspace_limit_m;
}

static void put_contact(const struct haptable_model* model, const struct haptable_servo* servo,
                        struct haptable_output* out) {
    int corner;
    out->state = HAPTABLE_CONTACT;
    out->patch = servo->contact.patch;
    vec_copy(servo->contact.alpha, out->alpha);
    vec_copy(servo->contact.god_object_m, out->god_object_m);
    for (corner = 0; corner < 3; ++corner) out->vertex[corner] = model->patch[servo->contact.patch][corner];
}

/* Newtons squared: what is larger, or not a number, is no force of any device but a fault. */
#define FORCE_LIMIT2 1e30f

/* The last gate: what is not a force does not go to the device. */
static void gate_force(const struct haptable_model* model, struct haptable_servo* servo, struct haptable_output* out) {
    const float size2 = vec_dot(out->force_n, out->force_n);
    if (!(size2 <= FORCE_LIMIT2)) {
        ++servo->counters.rejected_forces;
        vec_zero(out->force_n);
        return;
    }
    servo->counters.clamped_forces += (uint32_t)haptable_force_clamp(model->max_force_n, out->force_n);
}

void haptable_init(struct haptable_servo* servo) {
    static const struct haptable_servo fresh = {
        .contact = {.patch = HAPTABLE_NONE}, .state = HAPTABLE_SILENT, .slide_patch = HAPTABLE_NONE};
    *servo = fresh;
}

void haptable_buttons(struct haptable_servo* servo, uint32_t buttons) {
    servo->pressed = buttons & ~servo->buttons;
    servo->buttons = buttons;
}

/* Where a contact stays undecided its force falls, and comes up again once it is decided; where it has fallen to zero
 * the contact is given up. before: the finger's position is taken. */
static void fade_contact(struct haptable_servo* servo) {
    if (servo->undecided_ticks == HAPTABLE_UNDECIDED_TICKS)
        ++servo->fade_ticks;
    else if (servo->fade_ticks > 0)
        --servo->fade_ticks;
    if (servo->fade_ticks < HAPTABLE_FADE_TICKS) return;
    ++servo->counters.given_up;
    haptable_contact_end(servo);
    vec_copy(servo->finger_m, servo->segment.to_m);
    servo->segment.unfinished = 0;
}

static void fade_force(const struct haptable_servo* servo, float force_n[3]) {
    vec_add_scaled(-(float)servo->fade_ticks / (float)HAPTABLE_FADE_TICKS, force_n, force_n);
}

/* What a model may do to the force that contact gave, or to its absence. */
static void finish_force(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                         struct haptable_output* out) {
    if (model->release) model->release(model, servo, motion_m, out->force_n);
    if (model->passivity) model->passivity(model, servo, motion_m, out->force_n);
    gate_force(model, servo, out);
    vec_copy(out->force_n, servo->given_n);
}

void haptable_step(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                   uint32_t now_us, struct haptable_output* out) {
    const int finishes = model->release || model->passivity;
    float motion_m[3];
    ++servo->counters.ticks;
    servo->position_us = now_us;
    if (!is_position(model, finger_m)) {
        ++servo->counters.rejected_positions;
        drop_contact(servo);
        servo->state = HAPTABLE_REJECTED;
        put_nothing(HAPTABLE_REJECTED, out);
        return;
    }
    servo->segment.boxes = 0;
    if (!servo->finger_known) { /* nobody knows how it came here */
        vec_copy(finger_m, servo->segment.to_m);
        servo->segment.unfinished = 0;
    }
    model->god_object(model, servo, finger_m);
    if (finishes) vec_sub(finger_m, servo->finger_known ? servo->finger_m : finger_m, motion_m);
    vec_copy(finger_m, servo->finger_m);
    servo->finger_known = 1;
    if (servo->undecided_ticks != 0 || servo->fade_ticks != 0) fade_contact(servo);
    if (servo->contact.patch == HAPTABLE_NONE) {
        servo->state = HAPTABLE_FREE;
        put_nothing(HAPTABLE_FREE, out);
        vec_copy(finger_m, out->god_object_m);
        if (finishes) finish_force(model, servo, motion_m, out);
        return;
    }
    ++servo->counters.contact_ticks;
    servo->state = HAPTABLE_CONTACT;
    put_contact(model, servo, out);
    model->force(model, &servo->contact, finger_m, out->nodal_force_n, out->force_n);
    if (servo->fade_ticks != 0) fade_force(servo, out->force_n);
    gate_force(model, servo, out);
    if (finishes) finish_force(model, servo, motion_m, out);
}

int haptable_watch(struct haptable_servo* servo, uint32_t now_us, struct haptable_output* out) {
    const int was_silent = servo->state == HAPTABLE_SILENT;
    if (!was_silent && now_us - servo->position_us < HAPTABLE_SILENCE_US) return 0;
    if (!was_silent) {
        ++servo->counters.silences;
        drop_contact(servo);
        servo->state = HAPTABLE_SILENT;
    }
    put_nothing(HAPTABLE_SILENT, out);
    return 1;
}
