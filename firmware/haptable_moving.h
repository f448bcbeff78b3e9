/* SPDX-License-Identifier: MIT
 *
 *   D+ = D + dE - f . dx - K/2 |dx|^2,   F = (1 - max(0, D+) / E) F_contact
 *
 * The tick of a body that moves, rigidly or in its modes or both, under one finger or two. Contacts are as on a body at
 * rest, in the body's frame and less what its modes have moved the surface. f is the load of the fingers, dx how far
 * they went in that frame, E what contacts store, dE what contacts and modes have got, K the stiffest contact.
 *
 * Action is reaction: hands and body get the same force for a tick, so that the body's momentum is what it was given.
 * It is kicked, then it drifts. Over a contact hands and body pay no less than the sum of f . dx, and a spring that is
 * sampled makes at most the last term. What contacts make beyond that (a force without an energy, a finger that enters
 * where the other has bulged the surface) is owed, and lowers the force on both sides until it is paid. Nothing is
 * forgiven: docs/design/moving.md.
 */
#ifndef HAPTABLE_MOVING_H
#define HAPTABLE_MOVING_H

#include "haptable_contact.h"
#include "haptable_force.h"
#include "haptable_scene.h"
#include "haptable_vector.h"

/* The fingers of a tick, body axes. */
struct fingers {
    int count;
    int is_known[HAPTABLE_FINGERS];     /* 1: by its way since the last tick */
    float at_m[HAPTABLE_FINGERS][3];    /* where it is */
    float moved_m[HAPTABLE_FINGERS][3]; /* since the last tick; 0 where that is not known */
    float felt_m[HAPTABLE_FINGERS][3];  /* at_m, less what the modes have moved the surface */
    float load_n[HAPTABLE_FINGERS][3];  /* of its contact, on the body */
    float share[HAPTABLE_FINGERS];      /* of its force that is given */
    float stored_j;                     /* by its contacts */
};

static void to_body(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                    struct fingers* fingers) {
    const struct haptable_account* account = haptable_scene_account(scene, state);
    fingers->count = haptable_scene_fingers(scene);
    for (int f = 0; f < fingers->count; ++f) {
        const struct haptable_past* past = &account->past[f];
        const float most2 = HAPTABLE_FAST_SEGMENT_M * HAPTABLE_FAST_SEGMENT_M;
        float hand_m[3];
        if (scene->rigid)
            scene->rigid->from_world(scene->body, haptable_scene_body(scene, state), in[f].finger_m, fingers->at_m[f]);
        else
            vec_copy(in[f].finger_m, fingers->at_m[f]);
        vec_sub(fingers->at_m[f], past->finger_m, fingers->moved_m[f]);
        vec_sub(in[f].finger_m, past->hand_m, hand_m);
        /* What is no number fails, too. */
        fingers->is_known[f] = in[f].is_there && past->is_known && vec_dot(hand_m, hand_m) <= most2 &&
                               vec_dot(fingers->moved_m[f], fingers->moved_m[f]) <= 4.0f * most2;
        if (!fingers->is_known[f]) vec_zero(fingers->moved_m[f]);
        vec_copy(fingers->at_m[f], fingers->felt_m[f]);
    }
}

/* A tick of the modes under what the fingers did since the last one. A hand on a held body is allowed what a wall makes
 * of its way; on one that drifts the way is halved, as its own step has the other half. */
static void ring(const struct haptable_scene* scene, void* state, struct fingers* fingers) {
    const struct haptable_account* account = haptable_scene_account(scene, state);
    struct haptable_modes_state* modes = haptable_scene_modes(scene, state);
    struct haptable_modes_load load;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        vec_zero(&load.load_n[3 * f]);
        vec_zero(&load.moved_m[3 * f]);
    }
    load.presses = scene->rows(scene, state, account->past, load.compliance);
    for (int f = 0; f < fingers->count; ++f) {
        if ((load.presses >> f & 1u) == 0u) continue;
        vec_copy(account->past[f].load_n, &load.load_n[3 * f]);
        vec_add_scaled(scene->rigid ? 0.5f : 1.0f, fingers->moved_m[f], &load.moved_m[3 * f]);
    }
    scene->ringing->advance(scene->modes, scene->model, modes, &load);
    for (int f = 0; f < fingers->count; ++f) vec_sub(fingers->at_m[f], modes->met[f].shift_m, fingers->felt_m[f]);
}

/* A release brakes the hand, and not only the finger as the surface has it: what of it pushes the hand is left out, and
 * need not be paid back. For the modes may take what the contact stores, so that no hand pays it. */
static void brake_only(const struct haptable_model* model, const float moved_m[3], struct haptable_servo* servo,
                       struct haptable_output* out) {
    const float given_j = vec_dot(servo->released_n, moved_m);
    if (!(given_j > 0.0f)) return;
    servo->owed_j = servo->owed_j > given_j ? servo->owed_j - given_j : 0.0f;
    const float by = -given_j / vec_dot(moved_m, moved_m);
    vec_add_scaled(by, moved_m, servo->released_n);
    vec_add_scaled(by, moved_m, out->force_n);
    (void)haptable_force_clamp(model->max_force_n, out->force_n);
}

/* A release is no load of the contact, whose energy the account is of. */
static void find_loads(const struct haptable_scene* scene, void* state, struct fingers* fingers,
                       struct haptable_output out[]) {
    for (int f = 0; f < fingers->count; ++f) {
        struct haptable_servo* servo = haptable_scene_servo(state, f);
        vec_zero(fingers->load_n[f]);
        if (scene->model->release && out[f].state != HAPTABLE_LIMITED) {
            brake_only(scene->model, fingers->moved_m[f], servo, &out[f]);
            if (out[f].state == HAPTABLE_CONTACT) vec_sub(servo->released_n, out[f].force_n, fingers->load_n[f]);
        } else {
            vec_sub(fingers->load_n[f], out[f].force_n, fingers->load_n[f]);
        }
    }
}

/* How deep a contact is; 0 without one. */
static void dent_of(const struct fingers* fingers, int f, const struct haptable_output* out, float dent_m[3]) {
    vec_zero(dent_m);
    if (haptable_touches(out->state)) vec_sub(fingers->felt_m[f], out->god_object_m, dent_m);
}

/* How the contact of a finger stiffens; stiffens, here and below: 0: no dent does. */
static void stiffened_of(const struct haptable_scene* scene, void* state, int stiffens, int f,
                         const struct haptable_output* out, struct haptable_stiffened* more) {
    const struct haptable_model* model = scene->model;
    more->stored = more->tangent = 1.0f;
    if (!stiffens || !haptable_touches(out->state)) return;
    if (scene->pair) model = &((struct haptable_pair*)state)->view[f].model;
    (void)model->stiffen(model, haptable_scene_servo(state, f), more);
}

/* What contacts and modes hold, and what of it the contacts do. */
static float stored_of(const struct haptable_scene* scene, void* state, int stiffens, struct fingers* fingers,
                       const struct haptable_output out[]) {
    float work_j = 0.0f;
    for (int f = 0; f < fingers->count; ++f) {
        struct haptable_stiffened more;
        float dent_m[3];
        dent_of(fingers, f, &out[f], dent_m);
        stiffened_of(scene, state, stiffens, f, &out[f], &more);
        work_j += more.stored * vec_dot(fingers->load_n[f], dent_m);
    }
    fingers->stored_j = 0.5f * (work_j < 0.0f ? -work_j : work_j);
    return fingers->stored_j +
           (scene->ringing ? scene->ringing->energy(scene->modes, haptable_scene_modes(scene, state)) : 0.0f);
}

/* A force that falls is given as it will be so many ticks later, as far as finger and body go on as they went: none
 * where the contact will have ended. Held for the tick as it began, it would throw the body off with more than it came
 * with; so it is a little less, and what lies between two fingers comes to rest. A force is never more than the
 * contact's. */
#define HAPTABLE_EASE_TICKS 2.0f

static void ease(const struct haptable_scene* scene, void* state, int stiffens, struct fingers* fingers,
                 const struct haptable_output out[]) {
    for (int f = 0; f < fingers->count; ++f) {
        struct haptable_stiffened more;
        float dent_m[3], gives_m[3];
        const float* load_n = fingers->load_n[f];
        if (!fingers->is_known[f]) continue;
        dent_of(fingers, f, &out[f], dent_m);
        scene->rigid->give(scene->body, fingers->at_m[f], load_n, gives_m);
        const float deep_j = vec_dot(load_n, dent_m);
        float leaves_j = vec_dot(load_n, gives_m) - vec_dot(load_n, fingers->moved_m[f]);
        if (!(leaves_j > 0.0f)) continue;
        stiffened_of(scene, state, stiffens, f, &out[f], &more);
        leaves_j *= HAPTABLE_EASE_TICKS * more.tangent;
        fingers->share[f] = leaves_j < deep_j ? 1.0f - leaves_j / deep_j : 0.0f;
    }
}

/* Counts what the tick made, and how much of the forces is paid for. */
static void settle(const struct haptable_scene* scene, void* state, int stiffens, struct fingers* fingers,
                   const struct haptable_output out[]) {
    struct haptable_account* account = haptable_scene_account(scene, state);
    const float stored_j = stored_of(scene, state, stiffens, fingers, out);
    float owed_j = account->owed_j + (stored_j - account->stored_j);
    float paid = 1.0f;
    for (int f = 0; f < fingers->count; ++f) {
        const float* past_n = account->past[f].load_n;
        const float* moved_m = fingers->moved_m[f];
        owed_j -= vec_dot(past_n, moved_m);
        if (haptable_touches(out[f].state) || vec_dot(past_n, past_n) > 0.0f)
            owed_j -= 0.5f * scene->model->stiffness_limit_n_per_m * vec_dot(moved_m, moved_m);
    }
    if (owed_j > 0.0f) paid = owed_j < fingers->stored_j ? 1.0f - owed_j / fingers->stored_j : 0.0f;
    for (int f = 0; f < fingers->count; ++f) fingers->share[f] *= paid;
    account->owed_j = fingers->stored_j > 0.0f || owed_j > 0.0f ? owed_j : 0.0f;
    account->stored_j = stored_j;
}

/* The forces on the hands as they are given, and what the next tick is to know of them. */
static void give(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                 const struct fingers* fingers, struct haptable_output out[]) {
    struct haptable_account* account = haptable_scene_account(scene, state);
    for (int f = 0; f < fingers->count; ++f) {
        struct haptable_servo* servo = haptable_scene_servo(state, f);
        struct haptable_past* past = &account->past[f];
        if (fingers->share[f] < 1.0f) {
            vec_scale(fingers->share[f], out[f].force_n);
            vec_scale(fingers->share[f], servo->given_n);
            for (int corner = 0; corner < 3; ++corner) vec_scale(fingers->share[f], out[f].nodal_force_n[corner]);
        }
        past->is_known = (uint8_t)(in[f].is_there && servo->finger_known);
        vec_zero(past->load_n);
        vec_add_scaled(fingers->share[f], fingers->load_n[f], past->load_n);
        if (!past->is_known) continue;
        vec_copy(in[f].finger_m, past->hand_m);
        vec_copy(fingers->at_m[f], past->finger_m);
        if (out[f].state == HAPTABLE_FREE) vec_copy(fingers->at_m[f], out[f].god_object_m);
    }
}

/* The surface is met where the modes have it at the god-objects' places, as far as what the hands have paid goes. */
static void follow(const struct haptable_scene* scene, void* state, const struct fingers* fingers) {
    const struct haptable_account* account = haptable_scene_account(scene, state);
    float credit_j = -account->owed_j;
    for (int f = 0; f < fingers->count; ++f)
        scene->ringing->follow(scene->modes, scene->model, haptable_scene_modes(scene, state), f,
                               &haptable_scene_servo(state, f)->contact, account->past[f].load_n, &credit_j);
}

/* Hands and body get the same forces; then the body drifts. */
static void drift(const struct haptable_scene* scene, void* state, const struct fingers* fingers,
                  struct haptable_output out[]) {
    struct haptable_body_state* body = haptable_scene_body(scene, state);
    for (int f = 0; f < fingers->count; ++f) {
        float force_n[3];
        float load_n[3] = {0.0f, 0.0f, 0.0f};
        if (vec_dot(out[f].force_n, out[f].force_n) == 0.0f) continue;
        scene->rigid->to_world(body, out[f].force_n, force_n);
        vec_copy(force_n, out[f].force_n);
        vec_sub(load_n, force_n, load_n);
        scene->rigid->kick(scene->body, body, fingers->at_m[f], load_n);
    }
    scene->rigid->move(scene->body, body);
}

/* haptable_moving, haptable_moving_stiffening. */
static void moving(const struct haptable_scene* scene, void* state, int stiffens, const struct haptable_input in[],
                   uint32_t now_us, struct haptable_output out[]) {
    struct fingers fingers;
    haptable_scene_begin(scene, state, in, now_us, out);
    to_body(scene, state, in, &fingers);
    if (scene->ringing) ring(scene, state, &fingers);
    scene->contacts(scene, state, in, (const float(*)[3])fingers.felt_m, now_us, out);
    find_loads(scene, state, &fingers, out);
    for (int f = 0; f < fingers.count; ++f) fingers.share[f] = 1.0f;
    if (scene->rigid) ease(scene, state, stiffens, &fingers, out);
    settle(scene, state, stiffens, &fingers, out);
    give(scene, state, in, &fingers, out);
    if (scene->ringing) follow(scene, state, &fingers);
    if (scene->rigid) drift(scene, state, &fingers, out);
}

#endif
