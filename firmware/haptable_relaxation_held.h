/* SPDX-License-Identifier: MIT
 *
 * F = -(g_rest f + sum g_k h_k),   f = -F_e,   dh_k/dt = df/dt - h_k / time_k      while the god-object stays
 *
 * Friction and a hand hold a contact where it is: then S is one matrix, u turns, and each direction has its own
 * history. Where the contact goes on to slide, what a term has of u's direction (in the energy's norm) goes with it,
 * and the rest is dropped: both only lose energy.
 */
#ifndef HAPTABLE_RELAXATION_HELD_H
#define HAPTABLE_RELAXATION_HELD_H

#include "haptable_relaxation.h"
#include "haptable_vector.h"

static void sum_up(const struct haptable_model* model, struct haptable_relaxed* relaxed) {
    relaxed->branches = 0.0f;
    relaxed->fall = 0.0f;
    for (int k = 0; k < model->term_count; ++k) {
        const float part = model->term[k][TERM_SHARE] * relaxed->term[k].branch[0];
        relaxed->branches += part;
        relaxed->fall += model->term[k][TERM_FALL] * part;
    }
    relaxed->stress = model->rest_share * relaxed->dent + relaxed->branches;
}

/* Psi' of the last tick, s^2 / (u . f); stiffens: 0: of a linear body. */
static float last_factor(const struct haptable_relaxed* relaxed, int stiffens) {
    if (!stiffens) return 1.0f;
    const float work_j = vec_dot(relaxed->offset_m, relaxed->load_n);
    return work_j > 0.0f && relaxed->dent > 0.0f ? relaxed->dent * relaxed->dent / work_j : 1.0f;
}

/* r_k = h_k . u / sqrt(u . S u) */
static void end_hold(const struct haptable_model* model, struct haptable_relaxed* relaxed, int stiffens) {
    const float factor = last_factor(relaxed, stiffens);
    float inverse;
    relaxed->dent = haptable_relaxation_size(vec_dot(relaxed->offset_m, relaxed->load_n), factor, &inverse);
    relaxed->dent_lost = 0.0f;
    for (int k = 0; k < model->term_count; ++k) {
        struct haptable_relaxed_term* term = &relaxed->term[k];
        const float along = factor * inverse * vec_dot(term->branch, relaxed->offset_m);
        vec_zero(term->branch);
        vec_zero(term->lost);
        term->branch[0] = along;
    }
    relaxed->held = 0;
    sum_up(model, relaxed);
}

/* h_k = r_k f / s */
static void begin_hold(const struct haptable_model* model, struct haptable_relaxed* relaxed, int stiffens) {
    float inverse;
    (void)haptable_relaxation_size(vec_dot(relaxed->offset_m, relaxed->load_n), last_factor(relaxed, stiffens),
                                   &inverse);
    for (int k = 0; k < model->term_count; ++k) {
        struct haptable_relaxed_term* term = &relaxed->term[k];
        const float along = inverse * term->branch[0];
        vec_zero(term->branch);
        vec_zero(term->lost);
        vec_add_scaled(along, relaxed->load_n, term->branch);
    }
    relaxed->held = 1;
}

static void hold(const struct haptable_model* model, struct haptable_relaxed* relaxed, const float load_n[3],
                 float force_n[3]) {
    float change[3];
    vec_sub(load_n, relaxed->load_n, change);
    vec_zero(force_n);
    vec_add_scaled(-model->rest_share, load_n, force_n);
    for (int k = 0; k < model->term_count; ++k) {
        struct haptable_relaxed_term* term = &relaxed->term[k];
        for (int c = 0; c < 3; ++c) haptable_relaxation_go(model->term[k], change[c], &term->branch[c], &term->lost[c]);
        vec_add_scaled(-model->term[k][TERM_SHARE], term->branch, force_n);
    }
}

/* 1 where this tick's contact is the last one's, and the surface was at the finger. */
static int is_held(const struct haptable_relaxed* relaxed, const struct haptable_output* out) {
    float moved[3];
    if (out->patch == HAPTABLE_NONE || !relaxed->touches || !(relaxed->stress > 0.0f || relaxed->held)) return 0;
    vec_sub(out->god_object_m, relaxed->god_object_m, moved);
    return vec_length2(moved) == 0.0f;
}

static int is_grabbed(const struct haptable_model* model, const struct haptable_servo* servo) {
    return model->ungrabbed && (servo->buttons & HAPTABLE_BUTTON_GRAB) != 0;
}

/* A tick of a held contact. Where it would pull, and no hand holds it, the surface stays behind. */
static void feel(const struct haptable_model* model, const struct haptable_servo* servo,
                 struct haptable_relaxed* relaxed, int stiffens, float factor, const float load_n[3],
                 struct haptable_output* out) {
    float inverse;
    if (!relaxed->held) begin_hold(model, relaxed, stiffens);
    hold(model, relaxed, load_n, out->force_n);
    vec_copy(load_n, relaxed->load_n);
    relaxed->dent = haptable_relaxation_size(vec_dot(relaxed->offset_m, load_n), factor, &inverse);
    haptable_relaxation_note(relaxed, out);
    if (is_grabbed(model, servo) || vec_dot(out->force_n, load_n) < 0.0f) return;
    end_hold(model, relaxed, stiffens);
    vec_zero(out->force_n);
}

/* haptable_relaxation_held; stiffens, factor: 1 and Psi' of a body whose dents stiffen, else 0 and 1. */
static void relaxation_held(const struct haptable_model* model, struct haptable_servo* servo, int stiffens,
                            float factor, struct haptable_output* out) {
    struct haptable_relaxed* relaxed = haptable_relaxation_meet(model, servo);
    const int held = is_held(relaxed, out);
    float load_n[3] = {0.0f, 0.0f, 0.0f};
    if (!held && relaxed->held) end_hold(model, relaxed, stiffens);
    vec_add_scaled(-1.0f, out->force_n, load_n);
    vec_sub(servo->finger_m, out->god_object_m, relaxed->offset_m);
    if (held) {
        feel(model, servo, relaxed, stiffens, factor, load_n, out);
        return;
    }
    if (stiffens)
        haptable_relaxation_slide_stiffened(model, servo, relaxed, factor, out);
    else
        haptable_relaxation_slide(model, servo, relaxed, out);
    vec_copy(load_n, relaxed->load_n);
}

#endif
