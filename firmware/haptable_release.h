/* SPDX-License-Identifier: MIT
 *
 * F = F_contact + R,   |R| falls by release_n a tick,   F . d <= max(0, F_contact . d)
 *
 * R is what is left of a force that has ended: it only brakes. Or it is what a new force, which brakes more, lacks yet.
 * Then the finger pays less than the contact stores; the difference is kept, and no force pushes until it is paid back:
 * F gives no more than the contact's own force would.
 */
#ifndef HAPTABLE_RELEASE_H
#define HAPTABLE_RELEASE_H

#include "haptable_model.h"
#include "haptable_vector.h"

/* The largest change of a contact's force over the finger's motion that is no jump, as a multiple of its stiffness. */
#define HAPTABLE_RELEASE_JUMP 2.0f

/* The square of the stiffness that the contact shows, |F| / |u|; where the body relaxes, that at once, u . S u / |u|^2;
 * where it stiffens, that of the next motion. before: contact. */
static float shown_stiffness2(const struct haptable_model* model, struct haptable_servo* servo, int stiffens,
                              const float force_n[3]) {
    const float most2 = model->stiffness_limit_n_per_m * model->stiffness_limit_n_per_m;
    float u[3];
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    const float u2 = vec_length2(u);
    float force2 = vec_length2(force_n);
    if (!(u2 > 0.0f)) return 0.0f; /* the finger is on the surface: the force has ended */
    if (stiffens ? model->term_count > 0 : model->relax != 0) {
        const float dent = haptable_relaxed_of(model, servo)->dent;
        const float twice_j = dent * dent;
        force2 = twice_j * (twice_j / u2);
    }
    if (stiffens) {
        struct haptable_stiffened more;
        const float factor = model->stiffen(model, servo, &more);
        const float by = model->term_count > 0 ? more.tangent / factor : more.tangent; /* dent has the factor twice */
        force2 *= by * by;
    }
    return force2 < most2 * u2 ? force2 / u2 : most2;
}

/* 1 where the force changed by more than the finger's motion explains; without contact, where it has ended. */
static int has_jumped(const struct haptable_model* model, struct haptable_servo* servo, int stiffens,
                      const float force_n[3], const float change_n[3], const float motion_m[3]) {
    const float change2 = vec_length2(change_n);
    if (servo->contact.patch == HAPTABLE_NONE) return change2 > 0.0f;
    if (change2 <= model->release_n * model->release_n) return 0; /* most ticks */
    return change2 > HAPTABLE_RELEASE_JUMP * HAPTABLE_RELEASE_JUMP * shown_stiffness2(model, servo, stiffens, force_n) *
                             vec_length2(motion_m) +
                         model->release_n * model->release_n;
}

/* Shortens R by release_n. */
static void release_shorten(float by_n, float r[3]) {
    const float size2 = vec_length2(r);
    if (size2 <= by_n * by_n) {
        vec_zero(r);
        return;
    }
    vec_scale(1.0f - by_n * vec_inverse_root(size2), r);
}

/* What R does over the motion, given what the contact's force does, J. It brakes; or it holds back a force that has
 * come up at a jump, by no more than most_j. That much the finger has not paid of what is stored: it is owed, and until
 * it is paid nothing pushes the finger. */
static void release_hold_back(float contact_j, float most_j, const float motion_m[3], struct haptable_servo* servo) {
    const float motion2 = vec_length2(motion_m);
    const float before = vec_dot(servo->released_n, motion_m);
    float kept = before < most_j ? before : most_j;
    if (!(motion2 > 0.0f)) return;
    servo->owed_j = servo->owed_j + kept > 0.0f ? servo->owed_j + kept : 0.0f;
    const float given = contact_j + kept;
    if (kept <= 0.0f && given > 0.0f && servo->owed_j > 0.0f) {
        const float paid = given < servo->owed_j ? given : servo->owed_j;
        servo->owed_j -= paid;
        kept -= paid;
    }
    if (kept != before) vec_add_scaled((kept - before) / motion2, motion_m, servo->released_n);
}

/* What may be owed more, J, at a contact that stores E: what the finger would pay, but no more than E in all, for what
 * it pays is known to first order only. Nothing at a first contact: its force comes at once. */
static float most_owed(const struct haptable_model* model, const struct haptable_servo* servo, int stiffens,
                       int is_first, const float force_n[3], float contact_j) {
    float u[3];
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    float stored_j = -0.5f * vec_dot(force_n, u);
    if (stiffens && servo->contact.patch != HAPTABLE_NONE) {
        struct haptable_stiffened more;
        (void)model->stiffen(model, servo, &more);
        stored_j *= more.stored;
    }
    const float left_j = stored_j - servo->owed_j;
    if (is_first || contact_j >= 0.0f || left_j <= 0.0f) return 0.0f;
    return -contact_j < left_j ? -contact_j : left_j;
}

/* haptable_release_slew; stiffens: 1 of a body whose dents do, else 0. */
static void release_slew(const struct haptable_model* model, struct haptable_servo* servo, int stiffens,
                         const float motion_m[3], float force_n[3]) {
    const int is_free = servo->contact.patch == HAPTABLE_NONE;
    float change[3];
    float held[3]; /* the contact's force over the motion */
    float contact_j, most_j;
    if (!servo->felt_known) {
        vec_zero(servo->felt_n);
        vec_zero(servo->released_n);
        servo->owed_j = 0.0f;
        servo->felt_known = 1;
    }
    const int is_first = vec_length2(servo->felt_n) == 0.0f;
    vec_sub(servo->felt_n, force_n, change);
    vec_copy(force_n, servo->felt_n);
    vec_copy(force_n, held);
    if (has_jumped(model, servo, stiffens, force_n, change, motion_m)) {
        ++servo->counters.jumps;
        vec_add_scaled(1.0f, change, servo->released_n);
        most_j = is_free ? 0.0f : most_owed(model, servo, stiffens, is_first, force_n, vec_dot(force_n, motion_m));
        vec_add_scaled(1.0f, change, held);
        contact_j = vec_dot(held, motion_m);
    } else {
        if (!(vec_length2(servo->released_n) > 0.0f || servo->owed_j > 0.0f)) return; /* most ticks */
        vec_add_scaled(0.5f, change, held);
        contact_j = vec_dot(held, motion_m);
        most_j = most_owed(model, servo, stiffens, is_first, force_n, contact_j);
    }
    release_shorten(model->release_n, servo->released_n);
    release_hold_back(contact_j, most_j, motion_m, servo);
    if (is_free) servo->owed_j = 0.0f; /* nothing is stored any more */
    vec_add_scaled(1.0f, servo->released_n, force_n);
}

#endif
