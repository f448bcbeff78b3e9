/* SPDX-License-Identifier: MIT
 *
 *   q+ - q = A (q, p) + b phi^T f_m,   f_m = f + S (dx - phi dq / 2)
 *
 * f is the force that the hand has had since the last tick, dx how far it went with it, dq how far the modes did; S the
 * contact's stiffness. So modes and contact gain what the hand gave, f . dx, and dx . S dx / 2 besides, which is what a
 * wall of that stiffness makes of a hand that is felt at ticks: the modes make nothing. What they do not know of, a
 * god-object that goes on to where the modes move otherwise, is counted and taken out of their motion.
 */
#include "haptable_modes.h"

#include "haptable_modes_terms.h"

/* A contact as the modes meet it. */
struct meeting {
    float shape[HAPTABLE_MODES][3]; /* phi there */
    float s[3][3];                  /* S of the force that was given */
};

/* S u of a contact, whatever the force is made of. */
static void load_of(const struct haptable_model* model, const struct haptable_contact* contact, const float finger_m[3],
                    float load_n[3]) {
    if (model->energy) {
        struct haptable_energy energy;
        model->energy(model, contact, finger_m, HAPTABLE_ENERGY_SLOPE, &energy);
        vec_copy(energy.load_n, load_n);
    } else {
        float nodal_n[3][3];
        float force_n[3];
        model->force(model, contact, finger_m, nodal_n, force_n);
        vec_zero(load_n);
        vec_add_scaled(-1.0f, force_n, load_n);
    }
}

/* S by columns, each times what of the force was given: limits may have lowered it. */
static void stiffness_at(const struct haptable_model* model, const struct haptable_contact* contact,
                         const float finger_m[3], const float given_n[3], float s[3][3]) {
    const float unit_m = 1e-3f;
    float load_n[3];
    float share = 1.0f;
    float load2;
    int c;
    load_of(model, contact, finger_m, load_n);
    load2 = vec_dot(load_n, load_n);
    if (load2 > 1e-24f) {
        const float share2 = vec_dot(given_n, given_n) / load2;
        if (share2 < 1.0f) share = share2 > 1e-24f ? share2 * vec_inverse_root(share2) : 0.0f;
    }
    for (c = 0; c < 3; ++c) {
        float at_m[3];
        vec_copy(contact->god_object_m, at_m);
        at_m[c] += unit_m;
        load_of(model, contact, at_m, load_n);
        at_m[c] -= contact->god_object_m[c]; /* unit_m as it was rounded */
        vec_zero(s[c]);
        vec_add_scaled(share / at_m[c], load_n, s[c]);
    }
}

static void product(const float columns[3][3], const float v[3], float out[3]) {
    vec_zero(out);
    vec_add_scaled(v[0], columns[0], out);
    vec_add_scaled(v[1], columns[1], out);
    vec_add_scaled(v[2], columns[2], out);
}

/* x of columns x = b, by Cramer's rule: the matrix is 1 and a product of two that are not negative. */
static void solve(const float columns[3][3], const float b[3], float x[3]) {
    float across[3][3];
    float scale;
    int c;
    for (c = 0; c < 3; ++c) vec_cross(columns[(c + 1) % 3], columns[(c + 2) % 3], across[c]);
    scale = 1.0f / vec_dot(columns[0], across[0]);
    for (c = 0; c < 3; ++c) x[c] = scale * vec_dot(across[c], b);
}

/* f_m: (1 + S G / 2) f_m = f + S (dx - b / 2), where b is how far the surface goes without a force, and G f of one. */
static void find_load(const struct haptable_modes* modes, const struct haptable_modes_state* state,
                      const struct meeting* meeting, const float moved_m[3], float load_n[3]) {
    float columns[3][3];
    float gives[3][3];
    float ahead[3];
    float wanted[3];
    int k;
    int c;
    vec_copy(moved_m, ahead);
    for (c = 0; c < 3; ++c) vec_zero(gives[c]);
    for (k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        vec_add_scaled(-0.5f * modes_free_change(mode, state->swings.q[k], state->swings.p[k]), meeting->shape[k],
                       ahead);
        for (c = 0; c < 3; ++c) vec_add_scaled(0.5f * mode->q_by_f * meeting->shape[k][c], meeting->shape[k], gives[c]);
    }
    product(meeting->s, ahead, wanted);
    vec_add_scaled(1.0f, state->met.load_n, wanted);
    for (c = 0; c < 3; ++c) {
        product(meeting->s, gives[c], columns[c]);
        columns[c][c] += 1.0f;
    }
    solve((const float(*)[3])columns, wanted, load_n);
}

/* A tick of all modes under that load; the surface goes with them. */
static void swing(const struct haptable_modes* modes, const struct meeting* meeting, const float load_n[3],
                  struct haptable_modes_state* state) {
    int k;
    for (k = 0; k < modes->count; ++k) {
        const float q = state->swings.q[k];
        modes_tick(&modes->mode[k], k, vec_dot(meeting->shape[k], load_n), &state->swings);
        vec_add_scaled(state->swings.q[k] - q, meeting->shape[k], state->met.shift_m);
    }
}

static void advance(const struct haptable_modes* modes, const struct haptable_servo* servo, const float moved_m[3],
                    struct haptable_modes_state* state) {
    const struct haptable_contact* contact = &servo->contact;
    struct meeting meeting;
    float load_n[3] = {0.0f, 0.0f, 0.0f};
    modes_shape_at(modes, state->met.patch, state->met.alpha, meeting.shape);
    if (contact->patch != HAPTABLE_NONE) {
        stiffness_at(modes->model, contact, servo->finger_m, state->met.load_n, meeting.s);
        find_load(modes, state, &meeting, moved_m, load_n);
    }
    swing(modes, &meeting, load_n, state);
}

/* What the contact has stored. */
static float stored_of(const float finger_m[3], const struct haptable_output* out) {
    float dent[3];
    float work;
    if (!haptable_touches(out->state)) return 0.0f;
    vec_sub(finger_m, out->god_object_m, dent);
    work = vec_dot(out->force_n, dent);
    return 0.5f * (work < 0.0f ? -work : work);
}

/* Brings the shift to where the modes have the surface at the god-object's new place, as far as that costs the contact
 * no more than the tick has left over. Returns what it may cost. */
static float follow(const struct haptable_modes* modes, struct haptable_modes_state* state, float left_j) {
    float apart_m[3];
    const float cost_j = modes_apart(modes, &state->swings, &state->met, apart_m);
    float share = 1.0f;
    if (cost_j > left_j) share = left_j > 0.0f ? left_j / cost_j : 0.0f;
    return modes_follow(apart_m, share, cost_j > 0.0f ? cost_j : 0.0f, &state->met);
}

/* Counts what the tick made. Beyond what a wall makes of a sampled hand, it is taken back; what is left over pays for
 * the shift. before: what the next tick is to know of the contact is left, but for the energy. */
static void settle(const struct haptable_modes* modes, struct haptable_modes_state* state, float allowed_j,
                   float contact_j) {
    const float made_j = contact_j + haptable_modes_energy(modes, &state->swings) - allowed_j;
    modes_brake(modes, &state->swings, made_j);
    state->stored_j = contact_j + haptable_modes_energy(modes, &state->swings);
    state->stored_j += follow(modes, state, -made_j);
}

/* What the modes and the contact may hold after the tick: what they held, less what was given to the hand, and what a
 * wall makes of a sampled hand. */
static float allowed_of(const struct haptable_modes* modes, const struct haptable_modes_state* state,
                        const float moved_m[3]) {
    return state->stored_j + vec_dot(state->met.load_n, moved_m) +
           0.5f * modes->model->stiffness_limit_n_per_m * vec_dot(moved_m, moved_m);
}

void haptable_modes_init(struct haptable_modes_state* state) {
    static const struct haptable_modes_state fresh = {.met = {.patch = HAPTABLE_NONE}};
    *state = fresh;
}

float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_swings* swings) {
    float twice_j = 0.0f;
    int k;
    for (k = 0; k < modes->count; ++k)
        twice_j += swings->p[k] * swings->p[k] + modes->mode[k].stiffness * swings->q[k] * swings->q[k];
    return 0.5f * twice_j;
}

void haptable_modes_step(const struct haptable_modes* modes, struct haptable_modes_state* state,
                         struct haptable_servo* servo, const float finger_m[3], uint32_t now_us,
                         struct haptable_output* out) {
    float moved_m[3];
    float shifted_m[3];
    float allowed_j;
    modes_way_of(&state->met, finger_m, moved_m);
    allowed_j = allowed_of(modes, state, moved_m);
    advance(modes, servo, moved_m, state);
    vec_sub(finger_m, state->met.shift_m, shifted_m);
    haptable_step(modes->model, servo, shifted_m, now_us, out);
    modes_leave(&servo->contact, finger_m, out->force_n, &state->met);
    settle(modes, state, allowed_j, stored_of(shifted_m, out));
    if (out->state == HAPTABLE_FREE) vec_copy(finger_m, out->god_object_m);
}
