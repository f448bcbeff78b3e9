/* SPDX-License-Identifier: MIT
 *
 * finger -> checked -> god-object -> force -> checked -> limited -> out
 *
 * The stages of a tick: what haptable_servo.c (one finger) and haptable_pair_servo.c (two) are made of. One file for
 * each, so that each has them inlined, and a program pays for one of them only.
 */
#ifndef HAPTABLE_TICK_H
#define HAPTABLE_TICK_H

#include "haptable_contact.h"
#include "haptable_force.h"
#include "haptable_model.h"
#include "haptable_safety.h"
#include "haptable_vector.h"

static void put_nothing(uint8_t state, struct haptable_output* out) {
    out->state = state;
    out->faults = 0;
    out->patch = HAPTABLE_NONE;
    vec_zero(out->alpha);
    vec_zero(out->god_object_m);
    vec_zero(out->force_n);
    HAPTABLE_UNROLLED
    for (int corner = 0; corner < 3; ++corner) {
        out->vertex[corner] = HAPTABLE_NONE;
        vec_zero(out->nodal_force_n[corner]);
    }
}

static void drop_contact(struct haptable_servo* servo) {
    haptable_contact_end(servo);
    servo->finger_known = 0;
    servo->felt_known = 0;
    vec_zero(servo->given_n);
    servo->gain = 1.0f; /* contact begins at the surface, with no force */
}

/* No force, and no contact to come back to. */
HAPTABLE_CALLED void give_nothing(struct haptable_servo* servo, uint8_t state, struct haptable_output* out) {
    drop_contact(servo);
    servo->state = state;
    put_nothing(state, out);
    out->faults = servo->faults;
}

/* 1 when the position is within the workspace limit: what is not a number, or infinite, is not. */
static int is_position(const struct haptable_model* model, const float finger_m[3]) {
    float offset[3];
    vec_sub(finger_m, model->grid_origin_m, offset);
    return vec_length2(offset) <= model->workspace_limit_m * model->workspace_limit_m;
}

static void put_contact(const struct haptable_model* model, const struct haptable_servo* servo,
                        struct haptable_output* out) {
    out->state = HAPTABLE_CONTACT;
    out->faults = 0;
    out->patch = servo->contact.patch;
    vec_copy(servo->contact.alpha, out->alpha);
    vec_copy(servo->contact.god_object_m, out->god_object_m);
    for (int corner = 0; corner < 3; ++corner) out->vertex[corner] = model->patch[servo->contact.patch][corner];
}

/* Newtons squared: what is larger, or not a number, is no force of any device but a fault. */
#define HAPTABLE_FORCE_LIMIT2 1e30f

/* The last gate: what is not a force does not go to the device. */
static void gate_force(const struct haptable_model* model, struct haptable_servo* servo, struct haptable_output* out) {
    const float size2 = vec_length2(out->force_n);
    if (!(size2 <= HAPTABLE_FORCE_LIMIT2)) {
        ++servo->counters.rejected_forces;
        haptable_fault(servo, HAPTABLE_FAULT_FORCE);
        vec_zero(out->force_n);
        return;
    }
    servo->counters.clamped_forces += (uint32_t)haptable_force_clamp(model->max_force_n, out->force_n);
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

/* So often, and in every tick that fades, a contact is checked whose finger may be far. */
#define HAPTABLE_FAR_TICKS 16u

/* A finger that went through the body, or leapt, leaves its god-object behind, which would pull it for good. Where it
 * is farther from it than the body is large, the contact is given up as an undecided one is. */
static void doubt_far_contact(const struct haptable_model* model, struct haptable_servo* servo) {
    const float size_m = 1048576.0f * model->tolerance_m;
    float u[3];
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    if (servo->contact.patch != HAPTABLE_NONE && vec_length2(u) > size_m * size_m)
        servo->undecided_ticks = HAPTABLE_UNDECIDED_TICKS;
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
}

/* 1 while nothing may be given: a fault stands, or the tables were not checked. Pressing the button ends a fault;
 * tables that were damaged are to be found well first. */
static int is_faulted(const struct haptable_model* model, struct haptable_servo* servo) {
    if (servo->faults != 0 && (servo->pressed & HAPTABLE_BUTTON_ACKNOWLEDGE) != 0) {
        servo->faults = 0;
        servo->pressed &= ~(uint32_t)HAPTABLE_BUTTON_ACKNOWLEDGE;
        if (servo->check.verdict == CHECK_DAMAGED) haptable_check_begin(&servo->check);
    }
    return servo->faults != 0 || (model->check && servo->check.verdict != CHECK_WELL);
}

/* 1 where the position is none, or not to be believed: counted. */
static int is_refused(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                      uint32_t elapsed_us) {
    if (!is_position(model, finger_m)) {
        ++servo->counters.rejected_positions;
        return 1;
    }
    return model->plausible && !model->plausible(model, servo, finger_m, elapsed_us);
}

/* The contact of this tick, and what the finger did since the last one. */
static void move(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                 float motion_m[3]) {
    servo->segment.boxes = 0;
    if (model->resume) model->resume(model, servo, finger_m);
    if (!servo->finger_known) { /* nobody knows how it came here */
        vec_copy(finger_m, servo->segment.to_m);
        servo->segment.unfinished = 0;
    }
    model->god_object(model, servo, finger_m);
    if (model->release || model->passivity)
        vec_sub(finger_m, servo->finger_known ? servo->finger_m : finger_m, motion_m);
    vec_copy(finger_m, servo->finger_m);
    servo->finger_known = 1;
    if (servo->fade_ticks != 0 || servo->counters.ticks % HAPTABLE_FAR_TICKS == 0) doubt_far_contact(model, servo);
    if (servo->undecided_ticks != 0 || servo->fade_ticks != 0) fade_contact(servo);
}

/* What the contact that there is, or is not, gives before what a model may do to it. */
static void put_force(const struct haptable_model* model, struct haptable_servo* servo, struct haptable_output* out) {
    if (servo->contact.patch == HAPTABLE_NONE) {
        servo->state = HAPTABLE_FREE;
        put_nothing(HAPTABLE_FREE, out);
        vec_copy(servo->finger_m, out->god_object_m);
        if (model->relax) model->relax(model, servo, out);
        return;
    }
    ++servo->counters.contact_ticks;
    servo->state = HAPTABLE_CONTACT;
    put_contact(model, servo, out);
    model->force(model, &servo->contact, servo->finger_m, out->nodal_force_n, out->force_n);
    if (model->relax) model->relax(model, servo, out);
    gate_force(model, servo, out);
    if (servo->fade_ticks != 0) fade_force(servo, out->force_n);
}

/* A tick's first stages. Returns 0 where out is written already: a position or a state without force. */
static int begin_tick(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                      uint32_t now_us, struct haptable_output* out) {
    const uint32_t elapsed_us = now_us - servo->position_us;
    ++servo->counters.ticks;
    servo->position_us = now_us;
    const int refused = is_refused(model, servo, finger_m, elapsed_us);
    if (!refused && !is_faulted(model, servo)) return 1;
    give_nothing(servo, refused && servo->faults == 0 ? HAPTABLE_REJECTED : HAPTABLE_FAULTED, out);
    if (!refused && out->faults == 0) out->faults = HAPTABLE_FAULT_TABLES;
    return 0;
}

/* Its last stages, once the god-object is where it rests. */
static void finish_tick(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                        struct haptable_output* out) {
    put_force(model, servo, out);
    if (model->release || model->passivity) finish_force(model, servo, motion_m, out);
    if (model->limit) model->limit(model, servo, out);
    vec_copy(out->force_n, servo->given_n);
}

#endif
