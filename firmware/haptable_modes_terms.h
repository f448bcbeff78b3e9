/* SPDX-License-Identifier: MIT
 *
 * What haptable_modes.c and haptable_modes_pair.c are made of: the shapes at a place, a tick of a mode, and what takes
 * energy out of their motion.
 */
#ifndef HAPTABLE_MODES_TERMS_H
#define HAPTABLE_MODES_TERMS_H

#include "haptable_modes.h"
#include "haptable_vector.h"

/* sum += part, with what the sum does not hold kept in low. */
static inline void modes_add_whole(float part, float* sum, float* low) {
    const float corrected = part - *low;
    const float next = *sum + corrected;
    *low = (next - *sum) - corrected;
    *sum = next;
}

/* The controls of a patch and their weights at alpha; HAPTABLE_NONE where it is held. */
static inline void modes_controls_of(const struct haptable_modes* modes, uint16_t patch, const float alpha[3],
                                     uint16_t control[HAPTABLE_MODES_CONTROLS], float weight[HAPTABLE_MODES_CONTROLS]) {
    const struct haptable_model* model = modes->model;
    int c;
    for (c = 0; c < 3; ++c) {
        const uint16_t vertex = model->patch[patch][c];
        control[c] = modes->controls > 3 || vertex < model->free_count ? vertex : HAPTABLE_NONE;
        weight[c] = alpha[c];
        if (modes->controls == 3) continue;
        weight[c] = alpha[c] * alpha[c];
        control[3 + c] = (uint16_t)(model->vertex_count + model->compliance->patch_edge[patch][c]);
        weight[3 + c] = 2.0f * alpha[(c + 1) % 3] * alpha[(c + 2) % 3];
    }
}

static inline void modes_shape_at(const struct haptable_modes* modes, uint16_t patch, const float alpha[3],
                                  float shape[HAPTABLE_MODES][3]) {
    uint16_t control[HAPTABLE_MODES_CONTROLS];
    float weight[HAPTABLE_MODES_CONTROLS];
    int c;
    int k;
    for (k = 0; k < modes->count; ++k) vec_zero(shape[k]);
    if (patch == HAPTABLE_NONE) return;
    modes_controls_of(modes, patch, alpha, control, weight);
    for (c = 0; c < modes->controls; ++c) {
        const float(*row)[3] = &modes->shape[(uint32_t)control[c] * modes->count];
        if (control[c] == HAPTABLE_NONE) continue;
        for (k = 0; k < modes->count; ++k) vec_add_scaled(weight[c], row[k], shape[k]);
    }
}

/* How far modes go in the tick without a force. */
static inline float modes_free_change(const struct haptable_mode* mode, float q, float p) {
    return mode->q_by_q * q + mode->q_by_p * p;
}

/* A tick of mode k under that force. */
static inline void modes_tick(const struct haptable_mode* mode, int k, float force, struct haptable_swings* swings) {
    const float q = swings->q[k];
    const float p = swings->p[k];
    modes_add_whole(modes_free_change(mode, q, p) + mode->q_by_f * force, &swings->q[k], &swings->q_low[k]);
    modes_add_whole(mode->p_by_q * q + mode->p_by_p * p + mode->q_by_p * force, &swings->p[k], &swings->p_low[k]);
}

/* How far the modes have moved the surface at the last contact. */
static inline void modes_place_of(const struct haptable_modes* modes, const struct haptable_swings* swings,
                                  const struct haptable_met* met, float at_m[3]) {
    float shape[HAPTABLE_MODES][3];
    int k;
    modes_shape_at(modes, met->patch, met->alpha, shape);
    vec_zero(at_m);
    for (k = 0; k < modes->count; ++k) vec_add_scaled(swings->q[k], shape[k], at_m);
}

/* The finger's way since the last tick; none where that is no number, or farther than a hand goes. */
static inline void modes_way_of(const struct haptable_met* met, const float finger_m[3], float moved_m[3]) {
    vec_sub(finger_m, met->finger_m, moved_m);
    if (!(vec_dot(moved_m, moved_m) <= HAPTABLE_FAST_SEGMENT_M * HAPTABLE_FAST_SEGMENT_M)) vec_zero(moved_m);
}

/* Takes energy out of the modes' motion, as far as it has any. */
static inline void modes_brake(const struct haptable_modes* modes, struct haptable_swings* swings, float energy_j) {
    float motion_j = 0.0f;
    float left;
    int k;
    for (k = 0; k < modes->count; ++k) motion_j += 0.5f * swings->p[k] * swings->p[k];
    if (!(energy_j > 0.0f) || !(motion_j > 1e-24f)) return;
    left = energy_j < motion_j ? 1.0f - energy_j / motion_j : 0.0f;
    left = left > 1e-12f ? left * vec_inverse_root(left) : 0.0f;
    for (k = 0; k < modes->count; ++k) {
        swings->p[k] *= left;
        swings->p_low[k] *= left;
    }
}

/* What the next tick is to know of a finger's contact. */
static inline void modes_leave(const struct haptable_contact* contact, const float finger_m[3], const float force_n[3],
                               struct haptable_met* met) {
    vec_copy(finger_m, met->finger_m);
    vec_zero(met->load_n);
    vec_add_scaled(-1.0f, force_n, met->load_n);
    if (contact->patch == HAPTABLE_NONE) return;
    met->patch = contact->patch;
    vec_copy(contact->alpha, met->alpha);
}

/* The most that the shift goes in a tick in which nothing bears on the surface: a finger that waits there is met with
 * so little that its contact holds no more than rounding. */
#define HAPTABLE_MODES_FREE_STEP_M 1e-6f

/* From the shift to where the modes have the surface at the god-object's place. Returns what it may cost the contact to
 * go there, J. */
static inline float modes_apart(const struct haptable_modes* modes, const struct haptable_swings* swings,
                                const struct haptable_met* met, float apart_m[3]) {
    modes_place_of(modes, swings, met, apart_m);
    vec_add_scaled(-1.0f, met->shift_m, apart_m);
    return 0.5f * modes->model->stiffness_limit_n_per_m * vec_dot(apart_m, apart_m) - vec_dot(met->load_n, apart_m);
}

/* Brings the shift that much nearer, or, where nothing bears on the surface, by a step. Returns what it may cost. */
static inline float modes_follow(const float apart_m[3], float share, float cost_j, struct haptable_met* met) {
    const float step2 = HAPTABLE_MODES_FREE_STEP_M * HAPTABLE_MODES_FREE_STEP_M;
    const float apart2 = vec_dot(apart_m, apart_m);
    if (vec_dot(met->load_n, met->load_n) == 0.0f && share * share * apart2 < step2) {
        share = apart2 > step2 ? HAPTABLE_MODES_FREE_STEP_M * vec_inverse_root(apart2) : 1.0f;
        cost_j = 0.0f;
    }
    vec_add_scaled(share, apart_m, met->shift_m);
    return share * cost_j;
}

#endif
