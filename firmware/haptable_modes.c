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

#include "haptable_vector.h"

/* A contact as the modes meet it. */
struct meeting {
    float shape[HAPTABLE_MODES][3]; /* phi there */
    float s[3][3];                  /* S of the force that was given */
};

static void add_whole(float part, float* sum, float* low) {
    const float corrected = part - *low;
    const float next = *sum + corrected;
    *low = (next - *sum) - corrected;
    *sum = next;
}

/* The controls of a patch and their weights at alpha; HAPTABLE_NONE where it is held. */
static void controls_of(const struct haptable_modes* modes, uint16_t patch, const float alpha[3],
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

static void shape_at(const struct haptable_modes* modes, uint16_t patch, const float alpha[3],
                     float shape[HAPTABLE_MODES][3]) {
    uint16_t control[HAPTABLE_MODES_CONTROLS];
    float weight[HAPTABLE_MODES_CONTROLS];
    int c;
    int k;
    for (k = 0; k < modes->count; ++k) vec_zero(shape[k]);
    if (patch == HAPTABLE_NONE) return;
    controls_of(modes, patch, alpha, control, weight);
    for (c = 0; c < modes->controls; ++c) {
        const float(*row)[3] = &modes->shape[(uint32_t)control[c] * modes->count];
        if (control[c] == HAPTABLE_NONE) continue;
        for (k = 0; k < modes->count; ++k) vec_add_scaled(weight[c], row[k], shape[k]);
    }
}

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

/* How far modes go in the tick without a force. */
static float free_change(const struct haptable_mode* mode, float q, float p) {
    return mode->q_by_q * q + mode->q_by_p * p;
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
        vec_add_scaled(-0.5f * free_change(mode, state->q[k], state->p[k]), meeting->shape[k], ahead);
        for (c = 0; c < 3; ++c) vec_add_scaled(0.5f * mode->q_by_f * meeting->shape[k][c], meeting->shape[k], gives[c]);
    }
    product(meeting->s, ahead, wanted);
    vec_add_scaled(1.0f, state->load_n, wanted);
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
        const struct haptable_mode* mode = &modes->mode[k];
        const float q = state->q[k];
        const float p = state->p[k];
        const float force = vec_dot(meeting->shape[k], load_n);
        add_whole(free_change(mode, q, p) + mode->q_by_f * force, &state->q[k], &state->q_low[k]);
        add_whole(mode->p_by_q * q + mode->p_by_p * p + mode->q_by_p * force, &state->p[k], &state->p_low[k]);
        vec_add_scaled(state->q[k] - q, meeting->shape[k], state->shift_m);
    }
}

/* How far the modes have moved the surface at the last contact. */
static void place_of(const struct haptable_modes* modes, const struct haptable_modes_state* state, float at_m[3]) {
    float shape[HAPTABLE_MODES][3];
    int k;
    shape_at(modes, state->patch, state->alpha, shape);
    vec_zero(at_m);
    for (k = 0; k < modes->count; ++k) vec_add_scaled(state->q[k], shape[k], at_m);
}

/* The finger's way since the last tick; none where that is no number, or farther than a hand goes. */
static void motion_of(const struct haptable_modes_state* state, const float finger_m[3], float moved_m[3]) {
    vec_sub(finger_m, state->finger_m, moved_m);
    if (!(vec_dot(moved_m, moved_m) <= HAPTABLE_FAST_SEGMENT_M * HAPTABLE_FAST_SEGMENT_M)) vec_zero(moved_m);
}

static void advance(const struct haptable_modes* modes, const struct haptable_servo* servo, const float moved_m[3],
                    struct haptable_modes_state* state) {
    const struct haptable_contact* contact = &servo->contact;
    struct meeting meeting;
    float load_n[3] = {0.0f, 0.0f, 0.0f};
    shape_at(modes, state->patch, state->alpha, meeting.shape);
    if (contact->patch != HAPTABLE_NONE) {
        stiffness_at(modes->model, contact, servo->finger_m, state->load_n, meeting.s);
        find_load(modes, state, &meeting, moved_m, load_n);
    }
    swing(modes, &meeting, load_n, state);
}

/* Takes energy out of the modes' motion, as far as it has any. */
static void brake(const struct haptable_modes* modes, struct haptable_modes_state* state, float energy_j) {
    float motion_j = 0.0f;
    float left;
    int k;
    for (k = 0; k < modes->count; ++k) motion_j += 0.5f * state->p[k] * state->p[k];
    if (!(energy_j > 0.0f) || !(motion_j > 1e-24f)) return;
    left = energy_j < motion_j ? 1.0f - energy_j / motion_j : 0.0f;
    left = left > 1e-12f ? left * vec_inverse_root(left) : 0.0f;
    for (k = 0; k < modes->count; ++k) {
        state->p[k] *= left;
        state->p_low[k] *= left;
    }
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

/* The most that the shift goes in a tick in which nothing bears on the surface: a finger that waits there is met with
 * so little that its contact holds no more than rounding. */
#define FREE_STEP_M 1e-6f

/* Brings the shift to where the modes have the surface at the god-object's new place, as far as that costs the contact
 * no more than the tick has left over. Returns what it may cost. */
static float follow(const struct haptable_modes* modes, struct haptable_modes_state* state, float left_j) {
    float apart[3];
    float apart2;
    float cost_j;
    float share = 1.0f;
    place_of(modes, state, apart);
    vec_add_scaled(-1.0f, state->shift_m, apart);
    apart2 = vec_dot(apart, apart);
    cost_j = 0.5f * modes->model->stiffness_limit_n_per_m * apart2 - vec_dot(state->load_n, apart);
    if (cost_j > left_j) share = left_j > 0.0f ? left_j / cost_j : 0.0f;
    if (vec_dot(state->load_n, state->load_n) == 0.0f && share * share * apart2 < FREE_STEP_M * FREE_STEP_M) {
        share = apart2 > FREE_STEP_M * FREE_STEP_M ? FREE_STEP_M * vec_inverse_root(apart2) : 1.0f;
        cost_j = 0.0f;
    }
    vec_add_scaled(share, apart, state->shift_m);
    return cost_j > 0.0f ? share * cost_j : 0.0f;
}

/* Counts what the tick made. Beyond what a wall makes of a sampled hand, it is taken back; what is left over pays for
 * the shift. before: what the next tick is to know of the contact is left, but for the energy. */
static void settle(const struct haptable_modes* modes, struct haptable_modes_state* state, float allowed_j,
                   float contact_j) {
    const float made_j = contact_j + haptable_modes_energy(modes, state) - allowed_j;
    brake(modes, state, made_j);
    state->stored_j = contact_j + haptable_modes_energy(modes, state);
    state->stored_j += follow(modes, state, -made_j);
}

/* What the modes and the contact may hold after the tick: what they held, less what was given to the hand, and what a
 * wall makes of a sampled hand. */
static float allowed_of(const struct haptable_modes* modes, const struct haptable_modes_state* state,
                        const float moved_m[3]) {
    return state->stored_j + vec_dot(state->load_n, moved_m) +
           0.5f * modes->model->stiffness_limit_n_per_m * vec_dot(moved_m, moved_m);
}

/* What the next tick is to know of the contact. */
static void leave(const struct haptable_servo* servo, const float finger_m[3], const struct haptable_output* out,
                  struct haptable_modes_state* state) {
    vec_copy(finger_m, state->finger_m);
    vec_zero(state->load_n);
    vec_add_scaled(-1.0f, out->force_n, state->load_n);
    if (servo->contact.patch == HAPTABLE_NONE) return;
    state->patch = servo->contact.patch;
    vec_copy(servo->contact.alpha, state->alpha);
}

void haptable_modes_init(struct haptable_modes_state* state) {
    static const struct haptable_modes_state fresh = {.patch = HAPTABLE_NONE};
    *state = fresh;
}

float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_modes_state* state) {
    float twice_j = 0.0f;
    int k;
    for (k = 0; k < modes->count; ++k)
        twice_j += state->p[k] * state->p[k] + modes->mode[k].stiffness * state->q[k] * state->q[k];
    return 0.5f * twice_j;
}

void haptable_modes_step(const struct haptable_modes* modes, struct haptable_modes_state* state,
                         struct haptable_servo* servo, const float finger_m[3], uint32_t now_us,
                         struct haptable_output* out) {
    float moved_m[3];
    float shifted_m[3];
    float allowed_j;
    motion_of(state, finger_m, moved_m);
    allowed_j = allowed_of(modes, state, moved_m);
    advance(modes, servo, moved_m, state);
    vec_sub(finger_m, state->shift_m, shifted_m);
    haptable_step(modes->model, servo, shifted_m, now_us, out);
    leave(servo, finger_m, out, state);
    settle(modes, state, allowed_j, stored_of(shifted_m, out));
    if (out->state == HAPTABLE_FREE) vec_copy(finger_m, out->god_object_m);
}
