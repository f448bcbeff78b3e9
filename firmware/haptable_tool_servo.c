/* SPDX-License-Identifier: MIT
 *
 * pose -> checked -> points -> god-objects -> loads -> wrench -> limited -> out
 *
 * The hand is a servo as a finger's: its states, faults and limits are those of the wrench. Each point is one too, as
 * far as it tells whether it is inside; its force is the tool's to solve.
 */
#include "haptable_tool.h"

#include "haptable.h"
#include "haptable_side.h"
#include "haptable_six.h"
#include "haptable_tick.h"

/* A turn's squared length may be off 1 by so much: floats that a device sends. */
#define TURN_ERROR 2e-3f

static struct haptable_tool_state* state_of(void* state) { return (struct haptable_tool_state*)state; }

/* ---- pose -------------------------------------------------------------------------------------------------------- */

/* out = turn of v: v + 2 w (q x v) + 2 q x (q x v) */
static void turned(const float turn[4], const float v[3], float out[3]) {
    float once[3], twice[3];
    vec_cross(&turn[1], v, once);
    vec_cross(&turn[1], once, twice);
    vec_copy(v, out);
    vec_add_scaled(2.0f * turn[0], once, out);
    vec_add_scaled(2.0f, twice, out);
}

static float turn_length2(const float turn[4]) { return turn[0] * turn[0] + vec_length2(&turn[1]); }

/* Returns 0 where the numbers are no turn. */
static int take_turn(const float from[4], float turn[4]) {
    const float length2 = turn_length2(from);
    if (!(vec_magnitude(length2 - 1.0f) <= TURN_ERROR)) return 0;
    const float inverse = vec_inverse_root(length2);
    for (int i = 0; i < 4; ++i) turn[i] = inverse * from[i];
    return 1;
}

/* The small turn from one to the other, a vector in world axes, rad. */
static void turn_between(const float from[4], const float to[4], float by[3]) {
    vec_cross(&from[1], &to[1], by);
    for (int i = 0; i < 3; ++i) by[i] = from[0] * to[1 + i] - to[0] * from[1 + i] - by[i];
    const float along = from[0] * to[0] + vec_dot(&from[1], &to[1]);
    vec_scale(along < 0.0f ? -2.0f : 2.0f, by);
}

/* to = by after from: a turn by a small vector, rad. */
static void turn_on(const float by[3], const float from[4], float to[4]) {
    float half[3], cross[3];
    vec_zero(half);
    vec_add_scaled(0.5f, by, half);
    vec_cross(half, &from[1], cross);
    to[0] = from[0] - vec_dot(half, &from[1]);
    for (int i = 0; i < 3; ++i) to[1 + i] = from[1 + i] + from[0] * half[i] + cross[i];
    const float inverse = vec_inverse_root(turn_length2(to));
    for (int i = 0; i < 4; ++i) to[i] *= inverse;
}

/* ---- virtual coupling -------------------------------------------------------------------------------------------- */

/* K = J^T C_TT^-1 J: the stiffness of the points that press, against a motion (d, theta) of the tool, its god-objects
 * staying; J_i = (1, -[R r_i]). Lower half. */
static void stiffness_of(const struct haptable_tool_model* tool, struct haptable_tool_state* state, float (*k)[6]) {
    const struct haptable_points* points = &state->points;
    float w[6][3 * HAPTABLE_POINTS]; /* L^-1 J by columns */
    for (uint32_t a = 0; a < points->count; ++a) {
        float r_m[3];
        turned(state->turn, tool->point_m[points->order[a]], r_m);
        for (uint32_t c = 0; c < 6u; ++c) {
            float axis[3] = {0.0f, 0.0f, 0.0f};
            axis[c % 3u] = 1.0f;
            if (c < 3u)
                vec_copy(axis, &w[c][3u * a]);
            else
                vec_cross(axis, r_m, &w[c][3u * a]);
        }
    }
    for (uint32_t c = 0; c < 6u; ++c) {
        haptable_points_forward(&tool->points, state, w[c]);
        for (uint32_t other = 0; other <= c; ++other)
            k[c][other] = haptable_points_dot(w[c], w[other], 3u * points->count);
    }
}

/* The tool goes where coupling and contacts balance, its god-objects staying: (K + K_v) delta = K_v (hand - tool) -
 * load. One that touches nothing is at the hand. */
static void follow_hand(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                        const float hand_m[3], const float turn[4]) {
    const float stiffness[2] = {tool->stiffness_n_per_m, tool->turn_stiffness_n_m_per_rad};
    float k[6][6], b[6], moved[6], way_m[3], by[3], next[4];
    const struct haptable_points* points = &state->points;
    if (!(stiffness[0] > 0.0f) || state->most == HAPTABLE_NONE || points->count == 0) {
        vec_copy(hand_m, state->position_m);
        for (int i = 0; i < 4; ++i) state->turn[i] = turn[i];
        return;
    }
    vec_sub(hand_m, state->position_m, way_m);
    turn_between(state->turn, turn, by);
    for (int i = 0; i < 3; ++i) {
        b[i] = stiffness[0] * way_m[i];
        b[3 + i] = stiffness[1] * by[i];
    }
    for (uint32_t a = 0; a < points->count; ++a) {
        const float* load_n = haptable_points_in(&tool->points, state)[points->order[a]].load_n;
        float r_m[3], moment[3];
        turned(state->turn, tool->point_m[points->order[a]], r_m);
        vec_cross(r_m, load_n, moment);
        vec_sub(&b[0], load_n, &b[0]);
        vec_sub(&b[3], moment, &b[3]);
    }
    stiffness_of(tool, state, k);
    for (int i = 0; i < 6; ++i) k[i][i] += stiffness[i / 3];
    six_factor(k);
    six_solve((const float(*)[6])k, b, moved);
    vec_add(state->position_m, &moved[0], state->position_m);
    turn_on(&moved[3], state->turn, next);
    for (int i = 0; i < 4; ++i) state->turn[i] = next[i];
}

/* The wrench of the coupling in place of the contacts', which it balances at rest. */
static void couple_wrench(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                          const float hand_m[3], const float turn[4]) {
    if (!(tool->stiffness_n_per_m > 0.0f)) return;
    vec_sub(state->position_m, hand_m, state->force_n);
    vec_scale(tool->stiffness_n_per_m, state->force_n);
    turn_between(turn, state->turn, state->moment_n_m);
    vec_scale(tool->turn_stiffness_n_m_per_rad, state->moment_n_m);
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

/* The hand has no pose, or none that is believed: no point knows where it was. */
static void give_no_wrench(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                           struct haptable_tool_output* out) {
    for (uint32_t i = 0; i < tool->points.count; ++i) {
        drop_contact(&haptable_points_servos(&tool->points, state)[i]);
        haptable_point_forget(&tool->points, state, i);
    }
    state->tip.finger_known = 0;
    state->points.energy_j = 0.0f;
    state->points.count = 0;
    state->most = HAPTABLE_NONE;
    vec_zero(state->given_n_m);
    vec_zero(out->torque_n_m);
}

void haptable_tool_place(const struct haptable_tool_model* tool, const float position_m[3], const float turn[4],
                         uint32_t point, float x_m[3]) {
    turned(turn, tool->point_m[point], x_m);
    vec_add(position_m, x_m, x_m);
}

static void move_points(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    for (uint32_t i = 0; i < tool->points.count; ++i) {
        struct haptable_servo* servo = &haptable_points_servos(&tool->points, state)[i];
        float x_m[3], motion_m[3];
        haptable_tool_place(tool, state->position_m, state->turn, i, x_m);
        servo->position_us = state->hand.position_us;
        ++servo->counters.ticks;
        move(&state->model, servo, x_m, motion_m);
        haptable_point_see(&tool->points, state, i);
        if (servo->gain < state->hand.gain) state->hand.gain = servo->gain; /* with resume */
    }
}

/* ---- wrench ------------------------------------------------------------------------------------------------------ */

/* F, M, and which point presses most: the hand's contact. */
static void put_wrench(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    float most2 = 0.0f;
    state->most = HAPTABLE_NONE;
    vec_zero(state->force_n);
    vec_zero(state->moment_n_m);
    for (uint32_t i = 0; i < tool->points.count; ++i) {
        const struct haptable_point* point = &haptable_points_in(&tool->points, state)[i];
        const struct haptable_servo* servo = &haptable_points_servos(&tool->points, state)[i];
        float r_m[3], moment[3], load_n[3];
        if (!point->presses) continue;
        vec_copy(point->load_n, load_n);
        if (servo->fade_ticks != 0) fade_force(servo, load_n);
        turned(state->turn, tool->point_m[i], r_m);
        vec_cross(r_m, load_n, moment);
        vec_sub(state->force_n, load_n, state->force_n);
        vec_sub(state->moment_n_m, moment, state->moment_n_m);
        if (state->most != HAPTABLE_NONE && !(vec_length2(load_n) > most2)) continue;
        most2 = vec_length2(load_n);
        state->most = (uint16_t)i;
    }
    struct haptable_contact* contact = &state->hand.contact;
    const int is_new = contact->patch == HAPTABLE_NONE;
    contact->patch = HAPTABLE_NONE;
    if (state->most == HAPTABLE_NONE) return;
    *contact = haptable_points_in(&tool->points, state)[state->most].at;
    state->hand.counters.contacts += (uint32_t)is_new;
}

void haptable_tool_force(const struct haptable_model* model, const struct haptable_contact* contact,
                         const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    const struct haptable_tool_state* state =
        (const struct haptable_tool_state*)((const unsigned char*)model - offsetof(struct haptable_tool_state, model));
    const struct haptable_tool_model* tool = state->tool;
    const struct haptable_point* point =
        (const struct haptable_point*)((const unsigned char*)state + tool->points.points_at);
    (void)finger_m;
    tool->points.pair->law->load(model, contact, point[state->most].load_n, nodal_force_n, force_n);
    vec_copy(state->force_n, force_n);
    if (!(vec_length2(state->moment_n_m) <= HAPTABLE_FORCE_LIMIT2)) vec_no_number(force_n); /* for the gate */
}

/* The energy of the last tick's wrench over the hand's motion, and what takes back what was given. */
static void observe(const struct haptable_tool_model* tool, struct haptable_tool_state* state, const float motion_m[3],
                    const float turn_rad[3]) {
    const float motion2 = vec_length2(motion_m) + tool->reach_m * tool->reach_m * vec_length2(turn_rad);
    state->given_j += vec_dot(state->hand.given_n, motion_m) + vec_dot(state->given_n_m, turn_rad);
    const float by =
        haptable_brake_within(&state->model, haptable_brake_of(&state->model, state->given_j, motion2), motion2);
    state->brake_n_per_m = by;
    vec_add_scaled(-by * tool->reach_m * tool->reach_m, turn_rad, state->moment_n_m);
}

void haptable_tool_brake(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                         float force_n[3]) {
    const struct haptable_tool_state* state = (const struct haptable_tool_state*)servo; /* its first member */
    (void)model;
    vec_add_scaled(-state->brake_n_per_m, motion_m, force_n);
}

/* Lowers the hand's gain so that the torque keeps the limits of the force, times max_torque over max_force. */
static void limit_torque(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                         const float torque_n_m[3]) {
    const struct haptable_model* model = &state->model;
    struct haptable_servo* hand = &state->hand;
    const float per_m = model->max_force_n / tool->max_torque_n_m;
    const float mean_n2 = hand->mean_n2;
    float as_force_n[3], given_n[3];
    vec_copy(hand->given_n, given_n);
    for (int i = 0; i < 3; ++i) {
        as_force_n[i] = per_m * torque_n_m[i];
        hand->given_n[i] = per_m * state->given_n_m[i];
    }
    hand->mean_n2 = state->mean_n2;
    if (model->mean) model->mean(model, hand, as_force_n);
    if (model->rate && vec_length2(as_force_n) > 0.0f) model->rate(model, hand, as_force_n);
    state->mean_n2 = hand->mean_n2;
    hand->mean_n2 = mean_n2;
    vec_copy(given_n, hand->given_n);
}

static void put_torque(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                       const float motion_m[3], struct haptable_tool_output* out) {
    struct haptable_servo* hand = &state->hand;
    const uint32_t rejected = hand->counters.rejected_forces;
    vec_copy(state->moment_n_m, out->torque_n_m);
    hand->counters.clamped_forces += (uint32_t)haptable_force_clamp(tool->max_torque_n_m, out->torque_n_m);
    if (state->model.limit && hand->contact.patch != HAPTABLE_NONE) limit_torque(tool, state, out->torque_n_m);
    finish_tick(&state->model, hand, motion_m, &out->hand);
    if (hand->contact.patch == HAPTABLE_NONE || hand->counters.rejected_forces != rejected) vec_zero(out->torque_n_m);
    vec_scale(hand->gain, out->torque_n_m);
    vec_copy(out->torque_n_m, state->given_n_m);
}

/* ---- a tick ------------------------------------------------------------------------------------------------------ */

/* Where resume has lowered the gain, contact raises it again. */
static void raise_gain(struct haptable_tool_state* state) {
    if (!state->model.resume || !(state->hand.gain < 1.0f) || state->hand.contact.patch == HAPTABLE_NONE) return;
    state->hand.gain = vec_clamp01(state->hand.gain + state->model.resume_gain);
}

/* 1 where no hand turns the tool so far in time: the farthest point's way, as a finger's along x and back. */
static int is_turn_refused(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                           const float turn_rad[3], uint32_t now_us) {
    struct haptable_servo* tip = &state->tip;
    const float angle2 = vec_length2(turn_rad);
    const float way_m = tool->reach_m * (angle2 > HAPTABLE_ROOT_LEAST ? angle2 * vec_inverse_root(angle2) : 0.0f);
    const uint32_t elapsed_us = now_us - tip->position_us;
    float at_m[3];
    vec_copy(state->model.grid_origin_m, at_m);
    at_m[0] = tip->finger_m[0] > at_m[0] ? tip->finger_m[0] - way_m : tip->finger_m[0] + way_m;
    at_m[1] = tip->finger_m[1];
    at_m[2] = tip->finger_m[2];
    tip->position_us = now_us;
    const int refused = state->model.plausible && !state->model.plausible(&state->model, tip, at_m, elapsed_us);
    vec_copy(at_m, tip->finger_m);
    if (refused) ++state->hand.counters.implausible;
    if (tip->faults != 0) haptable_fault(&state->hand, tip->faults);
    tip->faults = 0;
    return refused;
}

/* 1 where the pose is one and is believed, and no fault stands. Otherwise out is written. turn_rad: since the last
 * tick, meaningless where that is not known. */
static int take_pose(const struct haptable_tool_model* tool, struct haptable_tool_state* state,
                     const struct haptable_tool_input* in, uint32_t now_us, float turn[4], float turn_rad[3],
                     struct haptable_tool_output* out) {
    struct haptable_servo* hand = &state->hand;
    float position_m[3];
    int refused = 0;
    vec_copy(in->hand.finger_m, position_m);
    if (take_turn(in->turn, turn)) {
        turn_between(state->hand_turn, turn, turn_rad);
        refused = is_turn_refused(tool, state, turn_rad, now_us);
        for (int i = 0; i < 4; ++i) state->hand_turn[i] = turn[i];
    } else {
        vec_no_number(position_m);
    }
    if (!begin_tick(&state->model, hand, position_m, now_us, &out->hand)) return 0;
    if (!refused) return 1;
    give_nothing(hand, hand->faults == 0 ? HAPTABLE_REJECTED : HAPTABLE_FAULTED, &out->hand);
    return 0;
}

static void put_pose(const struct haptable_tool_state* state, struct haptable_tool_output* out) {
    vec_copy(state->position_m, out->position_m);
    for (int i = 0; i < 4; ++i) out->turn[i] = state->turn[i];
}

void haptable_step_tool(const struct haptable_scene* scene, void* of, const struct haptable_input first[],
                        uint32_t now_us, struct haptable_output first_out[]) {
    const struct haptable_tool_model* tool = haptable_tool_of(scene);
    const struct haptable_tool_input* in = (const struct haptable_tool_input*)first;
    struct haptable_tool_output* out = (struct haptable_tool_output*)first_out;
    struct haptable_tool_state* state = state_of(of);
    struct haptable_servo* hand = &state->hand;
    float turn[4] = {1.0f, 0.0f, 0.0f, 0.0f};
    float turn_rad[3] = {0.0f, 0.0f, 0.0f};
    float motion_m[3] = {0.0f, 0.0f, 0.0f};
    haptable_scene_begin(scene, of, first, now_us, first_out);
    if (!hand->finger_known) give_no_wrench(tool, state, out);
    if (!in->hand.is_there || !take_pose(tool, state, in, now_us, turn, turn_rad, out)) {
        give_no_wrench(tool, state, out);
        put_pose(state, out);
        return;
    }
    if (hand->finger_known)
        vec_sub(in->hand.finger_m, hand->finger_m, motion_m);
    else
        vec_zero(turn_rad);
    vec_copy(in->hand.finger_m, hand->finger_m);
    hand->finger_known = state->tip.finger_known = 1;
    follow_hand(tool, state, in->hand.finger_m, turn);
    raise_gain(state);
    move_points(tool, state);
    haptable_points_tick(&tool->points, state);
    put_wrench(tool, state);
    couple_wrench(tool, state, in->hand.finger_m, turn);
    if (state->model.passivity) observe(tool, state, motion_m, turn_rad);
    put_torque(tool, state, motion_m, out);
    put_pose(state, out);
}

unsigned haptable_tool_watch(const struct haptable_scene* scene, void* state, uint32_t now_us,
                             struct haptable_tool_output* out) {
    const unsigned silent = haptable_watch(scene, state, now_us, &out->hand);
    if (silent != 0u) vec_zero(out->torque_n_m);
    return silent;
}

void haptable_init_tool(const struct haptable_scene* scene, void* of) {
    const struct haptable_tool_model* tool = haptable_tool_of(scene);
    struct haptable_tool_state* state = state_of(of);
    haptable_servo_begin(&state->hand);
    haptable_servo_begin(&state->tip);
    vec_copy(scene->model->grid_origin_m, state->tip.finger_m);
    state->tool = tool;
    state->hand_turn[0] = state->turn[0] = 1.0f;
    state->most = HAPTABLE_NONE;
    haptable_points_take_model(scene->model, haptable_tool_force, haptable_tool_brake, &state->model);
    for (uint32_t i = 0; i < tool->points.count; ++i)
        haptable_servo_begin(&haptable_points_servos(&tool->points, state)[i]);
}

void haptable_tool_put_point(const struct haptable_scene* scene, const struct haptable_contact* at,
                             const float load_n[3], const float x_m[3], struct haptable_output* out) {
    put_nothing(HAPTABLE_FREE, out);
    vec_copy(x_m, out->god_object_m);
    if (at->patch == HAPTABLE_NONE) return;
    out->state = HAPTABLE_CONTACT;
    out->patch = at->patch;
    vec_copy(at->alpha, out->alpha);
    vec_copy(at->god_object_m, out->god_object_m);
    for (int corner = 0; corner < 3; ++corner) out->vertex[corner] = scene->model->patch[at->patch][corner];
    haptable_tool_of(scene)->points.pair->law->load(scene->model, at, load_n, out->nodal_force_n, out->force_n);
}

void haptable_tool_point_of(const struct haptable_scene* scene, const void* of, int number,
                            struct haptable_output* out) {
    static const struct haptable_contact none = {.patch = HAPTABLE_NONE};
    const struct haptable_tool_model* tool = haptable_tool_of(scene);
    const struct haptable_servo* servo =
        (const struct haptable_servo*)((const unsigned char*)of + tool->points.servos_at) + number;
    const struct haptable_point* point =
        (const struct haptable_point*)((const unsigned char*)of + tool->points.points_at) + number;
    haptable_tool_put_point(scene, point->is_inside ? &point->at : &none, point->load_n, servo->finger_m, out);
}
