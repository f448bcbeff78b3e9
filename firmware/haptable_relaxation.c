/* SPDX-License-Identifier: MIT
 *
 * F = F_e t / s,   s = |F_e| / |S u| sqrt(u . S u),   t = g_rest s + sum g_k r_k,   dr_k/dt = ds/dt - r_k / time_k
 *
 * F_e is the elastic force of this tick, g_rest + sum g_k = 1. Where the contact is fixed and u keeps its direction,
 * that is F_e convolved with g(t) = g_rest + sum g_k exp(-t / time_k): a generalised Maxwell body. Where F_e is minus
 * the gradient of an energy s^2 / 2, so is F of 1/2 (g_rest s^2 + sum g_k r_k^2) but for what the terms lose,
 * g_k r_k^2 / time_k, which is never negative: no loop gains, wherever the god-object goes. Where the body stiffens, s
 * grows with the dent's sqrt(u . S u) by a factor (haptable_relaxation_stiffening.c): the elastic force relaxes (Fung
 * 1981), and what the terms lose is g_k r_k / time_k times the dent less the one that would have s - r_k.
 *
 * In a tick s goes straight from one value to the next; then
 *   r_k <- r_k + rise_k (s' - s) - fall_k r_k,   fall = 1 - exp(-tick / time),   rise = time / tick fall
 * is exact. The surface is at the finger where that presses, t > 0; else it is free, and s goes by t = 0: so a dent
 * recovers, and a finger that comes back early meets it later.
 */
#include "haptable_relaxation.h"

#include "haptable_vector.h"

/* A dent of this part of the deepest is none. */
#define FORGOTTEN 1e-6f

static void forget(struct haptable_relaxed* relaxed) {
    static const struct haptable_relaxed fresh = {.vertex = {HAPTABLE_NONE, HAPTABLE_NONE, HAPTABLE_NONE}};
    const struct haptable_relaxed before = *relaxed;
    *relaxed = fresh;
    relaxed->tick = before.tick;
    relaxed->time_us = before.time_us;
}

struct haptable_relaxed* haptable_relaxation_meet(const struct haptable_model* model, struct haptable_servo* servo) {
    struct haptable_relaxed* relaxed = haptable_relaxed_of(model, servo);
    if (servo->counters.ticks - relaxed->tick != 1u || servo->position_us - relaxed->time_us >= HAPTABLE_SILENCE_US)
        forget(relaxed);
    relaxed->tick = servo->counters.ticks;
    relaxed->time_us = servo->position_us;
    return relaxed;
}

void haptable_relaxation_note(struct haptable_relaxed* relaxed, const struct haptable_output* out) {
    relaxed->pressed = relaxed->dent;
    vec_copy(out->alpha, relaxed->alpha);
    vec_copy(out->god_object_m, relaxed->god_object_m);
    for (int corner = 0; corner < 3; ++corner) {
        relaxed->vertex[corner] = out->vertex[corner];
        vec_copy(out->nodal_force_n[corner], relaxed->nodal_force_n[corner]);
    }
}

/* A tick in which the surface goes by `change`. */
static void advance(const struct haptable_model* model, struct haptable_relaxed* relaxed, float change) {
    float branches = 0.0f;
    float fall = 0.0f;
    for (int k = 0; k < model->term_count; ++k) {
        const float* term = model->term[k];
        float* branch = relaxed->term[k].branch;
        haptable_relaxation_go(term, change, branch, relaxed->term[k].lost);
        const float part = term[TERM_SHARE] * *branch;
        branches += part;
        fall += term[TERM_FALL] * part;
    }
    relaxed->branches = branches;
    relaxed->fall = fall;
}

/* A new contact `away` from the last one, as a part of the reach, finds so much less of its dent. What is left of it
 * stores less than it did. */
static void move_dent(const struct haptable_model* model, struct haptable_relaxed* relaxed, float away) {
    const float left = 1.0f - away;
    if (!(left > 0.0f)) {
        forget(relaxed);
        return;
    }
    relaxed->dent *= left;
    relaxed->dent_lost *= left;
    relaxed->branches *= left;
    relaxed->fall *= left;
    for (int k = 0; k < model->term_count; ++k) {
        relaxed->term[k].branch[0] *= left;
        relaxed->term[k].lost[0] *= left;
    }
}

static float distance(const float a[3], const float b[3]) {
    float gap[3];
    vec_sub(a, b, gap);
    const float gap2 = vec_length2(gap);
    return gap2 > HAPTABLE_ROOT_LEAST ? gap2 * vec_inverse_root(gap2) : 0.0f;
}

static void scale_loads(float by, struct haptable_output* out) {
    for (int corner = 0; corner < 3; ++corner) vec_scale(by, out->nodal_force_n[corner]);
}

/* The loads of the dent that the finger left. */
static void put_dent(const struct haptable_relaxed* relaxed, struct haptable_output* out) {
    vec_copy(relaxed->alpha, out->alpha);
    for (int corner = 0; corner < 3; ++corner) {
        out->vertex[corner] = relaxed->vertex[corner];
        vec_copy(relaxed->nodal_force_n[corner], out->nodal_force_n[corner]);
    }
    scale_loads(relaxed->dent / relaxed->pressed, out);
}

/* The surface is where the finger is. */
static void press_on(const struct haptable_model* model, struct haptable_relaxed* relaxed, float size, float inverse,
                     struct haptable_output* out) {
    advance(model, relaxed, size - relaxed->dent);
    relaxed->dent = size;
    relaxed->dent_lost = 0.0f;
    relaxed->stress = model->rest_share * size + relaxed->branches;
    if (!(relaxed->stress > 0.0f)) relaxed->stress = 0.0f;
    vec_scale(relaxed->stress * inverse, out->force_n);
    haptable_relaxation_note(relaxed, out);
}

/* Nothing is at the surface: it goes by `change`, so that it bears nothing. */
static void recover(const struct haptable_model* model, struct haptable_relaxed* relaxed, float change) {
    const float step = change + relaxed->dent_lost;
    const float next = relaxed->dent + step;
    advance(model, relaxed, change);
    relaxed->dent_lost = step - (next - relaxed->dent);
    relaxed->dent = next;
    relaxed->stress = 0.0f;
}

void haptable_relaxation_slide(const struct haptable_model* model, const struct haptable_servo* servo,
                               struct haptable_relaxed* relaxed, struct haptable_output* out) {
    const uint8_t touches = out->patch != HAPTABLE_NONE;
    float size = 0.0f;
    float inverse = 0.0f;
    if (touches) {
        float u[3];
        vec_sub(servo->finger_m, out->god_object_m, u);
        size = haptable_relaxation_size(-vec_dot(u, out->force_n), 1.0f, &inverse);
        if (!relaxed->touches && relaxed->dent > 0.0f)
            move_dent(model, relaxed, distance(out->god_object_m, relaxed->god_object_m) / model->relaxation_reach_m);
    }
    relaxed->touches = touches;
    const float left = relaxed->stress - relaxed->fall;
    if (touches && left + model->tick_share * (size - relaxed->dent) > 0.0f) {
        press_on(model, relaxed, size, inverse, out);
        return;
    }
    vec_zero(out->force_n);
    if (!(relaxed->dent > FORGOTTEN * relaxed->pressed)) {
        if (relaxed->dent != 0.0f) forget(relaxed);
        relaxed->touches = touches;
        return;
    }
    recover(model, relaxed, -left / model->tick_share);
    if (touches)
        scale_loads(relaxed->dent * inverse, out);
    else
        put_dent(relaxed, out);
}

void haptable_relaxation(const struct haptable_model* model, struct haptable_servo* servo,
                         struct haptable_output* out) {
    haptable_relaxation_slide(model, servo, haptable_relaxation_meet(model, servo), out);
}
