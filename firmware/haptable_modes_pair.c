/* SPDX-License-Identifier: MIT
 *
 *   f_m = f + S (dx - phi dq / 2)   <=>   (C + G / 2) (f_m - f) = dx - phi dq_f / 2,   C = S^-1,   G = phi b phi^T
 *
 * As haptable_modes.c has it, with f, dx and phi of both fingers, six rows, and the pair's C. dq_f is how far the modes
 * would go under f. C and G are not negative, so the system is solved as it stands; a force that is held is f itself.
 *
 * What contacts made beyond what the modes' motion pays is owed, as on a body that nothing holds
 * (docs/design/moving.md): a finger that touches where the other has dented the surface stores at once what it would
 * have paid on its way there.
 */
#include "haptable_modes_pair.h"

#include "haptable_modes_terms.h"
#include "haptable_pair_terms.h"

#define ROWS (3 * HAPTABLE_FINGERS)

/* Both contacts as the modes meet them. */
struct meeting {
    float shape[HAPTABLE_FINGERS][HAPTABLE_MODES][3]; /* phi there; 0 where one does not touch, in the equations */
    float a[ROWS][ROWS];                              /* C + G / 2: its lower half */
    int touches[HAPTABLE_FINGERS];
};

/* ---- C of the forces that were given ---------------------------------------------------------------------------- */

/* The root of what was lost of a force, by which C grows: limits may have lowered it. 0: there was none. */
static float growth_of(const struct haptable_pair_law* law, const struct haptable_pair_own* own, const float v[3],
                       const float given_n[3]) {
    const float given2 = vec_dot(given_n, given_n);
    float load_n[3];
    float load2;
    if (law->is_stiffness)
        vec_symmetric_product(own->a, v, load_n);
    else
        vec_copy(v, load_n);
    load2 = vec_dot(load_n, load_n);
    if (!(given2 > 1e-24f && load2 > 1e-24f)) return 0.0f;
    return load2 > given2 ? vec_inverse_root(given2 / load2 * vec_inverse_root(given2 / load2)) : 1.0f;
}

static void put_block(const float own[6], float by, float (*a)[ROWS], int at) {
    a[at][at] = by * own[0];
    a[at + 1][at + 1] = by * own[1];
    a[at + 2][at + 2] = by * own[2];
    a[at + 1][at] = by * own[3];
    a[at + 2][at + 1] = by * own[4];
    a[at + 2][at] = by * own[5];
}

/* What the first's A is lifted by, as where it is solved for. */
static float lift_of(const struct haptable_pair_own own[HAPTABLE_FINGERS], const float x[9]) {
    float m[6];
    float xm[9];
    float n[6];
    float before;
    pair_invert(own[1].a, m);
    pair_reduce(own[0].a, x, m, xm, n);
    before = n[0];
    (void)pair_keep_definite(own[0].a, n);
    return n[0] - before;
}

/* C_11 of A + lift: of a stiffness A^-1 (A + lift) A^-1. */
static void lift_first(const struct haptable_pair_law* law, float lift, float c[6]) {
    const float row[3][3] = {{c[0], c[3], c[5]}, {c[3], c[1], c[4]}, {c[5], c[4], c[2]}};
    const float by = law->is_stiffness ? lift : 0.0f;
    int i;
    for (i = 0; i < 3; ++i) {
        c[i] += law->is_stiffness ? lift * vec_dot(row[i], row[i]) : lift;
        c[3 + i] += by * vec_dot(row[i], row[(i + 1) % 3]);
    }
}

/* C_21: X^T, or of a stiffness A_2^-1 X^T A_1^-1. */
static void put_cross(const struct haptable_pair_law* law, float c[HAPTABLE_FINGERS][6], const float x[9], float by,
                      float (*a)[ROWS]) {
    int i;
    int j;
    for (i = 0; i < 3; ++i) {
        float unit[3] = {0.0f, 0.0f, 0.0f};
        float column[3]; /* of C_21 */
        unit[i] = 1.0f;
        if (law->is_stiffness) {
            float first[3];
            vec_symmetric_product(c[0], unit, first);
            pair_transposed_product(x, first, unit);
            vec_symmetric_product(c[1], unit, column);
        } else {
            pair_transposed_product(x, unit, column);
        }
        for (j = 0; j < 3; ++j) a[3 + j][i] = by * column[j];
    }
}

/* C of those that touch; 1 on the diagonal of the others. Says who touches. */
static void put_compliance(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                           const struct haptable_met met[HAPTABLE_FINGERS], struct meeting* meeting) {
    const struct haptable_contact* at[HAPTABLE_FINGERS] = {&pair->servo[0].contact, &pair->servo[1].contact};
    struct haptable_pair_own own[HAPTABLE_FINGERS];
    float c[HAPTABLE_FINGERS][6];
    float growth[HAPTABLE_FINGERS] = {0.0f, 0.0f};
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (at[f]->patch != HAPTABLE_NONE && pair->touches[f]) {
            tables->law->own(tables->model, at[f], pair->servo[f].finger_m, &own[f]);
            growth[f] = growth_of(tables->law, &own[f], pair->view[f].v, met[f].load_n);
        }
        meeting->touches[f] = growth[f] > 0.0f;
        if (!meeting->touches[f]) continue;
        if (tables->law->is_stiffness)
            pair_invert(own[f].a, c[f]);
        else {
            vec_copy(&own[f].a[0], &c[f][0]);
            vec_copy(&own[f].a[3], &c[f][3]);
        }
    }
    if (meeting->touches[0] && meeting->touches[1]) {
        float x[9];
        pair_cross_contacts(tables, pair, at[0], at[1], x);
        put_cross(tables->law, c, x, growth[0] * growth[1], meeting->a);
        lift_first(tables->law, lift_of(own, x), c[0]);
    }
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        static const float none[6] = {1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f};
        put_block(meeting->touches[f] ? c[f] : none, meeting->touches[f] ? growth[f] * growth[f] : 1.0f, meeting->a,
                  3 * f);
    }
}

/* ---- the load of the modes -------------------------------------------------------------------------------------- */

/* a x = b, a = L D L^T of its lower half, in place: it is positive definite. b becomes x. */
static void solve_rows(float (*a)[ROWS], float b[ROWS]) {
    float scaled[ROWS];
    int i;
    int j;
    int k;
    for (j = 0; j < ROWS; ++j) {
        float d = a[j][j];
        for (k = 0; k < j; ++k) {
            scaled[k] = a[j][k] * a[k][k];
            d -= a[j][k] * scaled[k];
            b[j] -= a[j][k] * b[k];
        }
        a[j][j] = d;
        for (i = j + 1; i < ROWS; ++i) {
            for (k = 0; k < j; ++k) a[i][j] -= a[i][k] * scaled[k];
            a[i][j] /= d;
        }
    }
    for (i = ROWS - 1; i >= 0; --i) {
        b[i] /= a[i][i];
        for (k = i + 1; k < ROWS; ++k) b[i] -= a[k][i] * b[k];
    }
}

/* phi of mode k at those that touch. */
static void rows_of(const struct meeting* meeting, int k, float row[ROWS]) {
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        if (meeting->touches[f])
            vec_copy(meeting->shape[f][k], &row[3 * f]);
        else
            vec_zero(&row[3 * f]);
    }
}

/* f_m of both: f at the call. before: put_compliance */
static void find_load(const struct haptable_modes* modes, const struct haptable_swings* swings,
                      const float moved_m[HAPTABLE_FINGERS][3], struct meeting* meeting, float load_n[ROWS]) {
    float more[ROWS];
    int k;
    int i;
    int j;
    for (i = 0; i < ROWS; ++i) more[i] = meeting->touches[i / 3] ? moved_m[i / 3][i % 3] : 0.0f;
    for (k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        float row[ROWS];
        float goes;
        rows_of(meeting, k, row);
        goes = modes_free_change(mode, swings->q[k], swings->p[k]) +
               mode->q_by_f * (vec_dot(&row[0], &load_n[0]) + vec_dot(&row[3], &load_n[3]));
        for (i = 0; i < ROWS; ++i) {
            const float part = 0.5f * mode->q_by_f * row[i];
            more[i] -= 0.5f * goes * row[i];
            for (j = 0; j <= i; ++j) meeting->a[i][j] += part * row[j];
        }
    }
    solve_rows(meeting->a, more);
    for (i = 0; i < ROWS; ++i) load_n[i] += more[i];
}

/* A tick of all modes under those loads; the surface goes with them. */
static void swing(const struct haptable_modes* modes, const struct meeting* meeting, const float load_n[ROWS],
                  struct haptable_modes_pair* state) {
    int k;
    int f;
    for (k = 0; k < modes->count; ++k) {
        const float q = state->swings.q[k];
        const float force = vec_dot(meeting->shape[0][k], &load_n[0]) + vec_dot(meeting->shape[1][k], &load_n[3]);
        modes_tick(&modes->mode[k], k, force, &state->swings);
        for (f = 0; f < HAPTABLE_FINGERS; ++f)
            vec_add_scaled(state->swings.q[k] - q, meeting->shape[f][k], state->met[f].shift_m);
    }
}

static void advance(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                    struct haptable_pair* pair, const float moved_m[HAPTABLE_FINGERS][3],
                    struct haptable_modes_pair* state) {
    struct meeting meeting;
    float load_n[ROWS];
    int f;
    int i;
    for (i = 0; i < ROWS; ++i)
        for (f = 0; f < ROWS; ++f) meeting.a[i][f] = 0.0f;
    put_compliance(tables, pair, state->met, &meeting);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        modes_shape_at(modes, state->met[f].patch, state->met[f].alpha, meeting.shape[f]);
        if (meeting.touches[f])
            vec_copy(state->met[f].load_n, &load_n[3 * f]);
        else
            vec_zero(&load_n[3 * f]);
    }
    if (meeting.touches[0] || meeting.touches[1]) find_load(modes, &state->swings, moved_m, &meeting, load_n);
    swing(modes, &meeting, load_n, state);
}

/* ---- the tick's account ------------------------------------------------------------------------------------------ */

/* What both contacts have stored. */
static float stored_of(const float finger_m[HAPTABLE_FINGERS][3], const struct haptable_output out[]) {
    float work = 0.0f;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        float dent[3];
        if (!haptable_touches(out[f].state)) continue;
        vec_sub(finger_m[f], out[f].god_object_m, dent);
        work += vec_dot(out[f].force_n, dent);
    }
    return 0.5f * (work < 0.0f ? -work : work);
}

/* What the modes and the contacts may hold after the tick: what they held, less what was given to the hands, and what a
 * wall makes of hands that are felt at ticks. */
static float allowed_of(const struct haptable_modes* modes, const struct haptable_modes_pair* state,
                        const float moved_m[HAPTABLE_FINGERS][3]) {
    float allowed_j = state->stored_j;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f)
        allowed_j += vec_dot(state->met[f].load_n, moved_m[f]) +
                     0.5f * modes->model->stiffness_limit_n_per_m * vec_dot(moved_m[f], moved_m[f]);
    return allowed_j;
}

/* Brings both shifts to where the modes have the surface, as far as that costs the contacts no more than that. Returns
 * what it may cost. */
static float follow(const struct haptable_modes* modes, struct haptable_modes_pair* state, float left_j) {
    float apart_m[HAPTABLE_FINGERS][3];
    float cost_j[HAPTABLE_FINGERS];
    float paid_j = 0.0f;
    float share = 1.0f;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) cost_j[f] = modes_apart(modes, &state->swings, &state->met[f], apart_m[f]);
    if (cost_j[0] + cost_j[1] > left_j) share = left_j > 0.0f ? left_j / (cost_j[0] + cost_j[1]) : 0.0f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) paid_j += modes_follow(apart_m[f], share, cost_j[f], &state->met[f]);
    return paid_j > 0.0f ? paid_j : 0.0f;
}

void haptable_modes_pair_init(struct haptable_modes_pair* state) {
    static const struct haptable_modes_pair fresh = {.met = {{.patch = HAPTABLE_NONE}, {.patch = HAPTABLE_NONE}}};
    *state = fresh;
}

float haptable_modes_pair_feel(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                               struct haptable_modes_pair* state, struct haptable_pair* pair,
                               const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                               struct haptable_output out[HAPTABLE_FINGERS]) {
    float moved_m[HAPTABLE_FINGERS][3];
    float shifted_m[HAPTABLE_FINGERS][3];
    float allowed_j;
    float made_j;
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) modes_way_of(&state->met[f], finger_m[f], moved_m[f]);
    allowed_j = allowed_of(modes, state, (const float(*)[3])moved_m);
    advance(modes, tables, pair, (const float(*)[3])moved_m, state);
    for (f = 0; f < HAPTABLE_FINGERS; ++f) vec_sub(finger_m[f], state->met[f].shift_m, shifted_m[f]);
    haptable_pair_step(tables, pair, shifted_m[0], shifted_m[1], now_us, out);
    for (f = 0; f < HAPTABLE_FINGERS; ++f)
        modes_leave(&pair->servo[f].contact, finger_m[f], out[f].force_n, &state->met[f]);
    state->contact_j = stored_of((const float(*)[3])shifted_m, out);
    made_j = state->contact_j + haptable_modes_energy(modes, &state->swings) - allowed_j;
    modes_brake(modes, &state->swings, made_j);
    state->stored_j = state->contact_j + haptable_modes_energy(modes, &state->swings);
    state->stored_j += follow(modes, state, -made_j - state->owed_j);
    for (f = 0; f < HAPTABLE_FINGERS; ++f)
        if (out[f].state == HAPTABLE_FREE) vec_copy(finger_m[f], out[f].god_object_m);
    return state->stored_j - allowed_j;
}

static void scale_vector(float by, float v[3]) {
    v[0] *= by;
    v[1] *= by;
    v[2] *= by;
}

/* The forces of both, as much as has been paid for. */
static void scale_forces(struct haptable_modes_pair* state, struct haptable_pair* pair, struct haptable_output out[]) {
    const float share = state->owed_j < state->contact_j ? 1.0f - state->owed_j / state->contact_j : 0.0f;
    int f;
    int corner;
    if (!(state->owed_j > 0.0f)) return; /* most ticks */
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        scale_vector(share, out[f].force_n);
        scale_vector(share, state->met[f].load_n);
        scale_vector(share, pair->servo[f].given_n);
        for (corner = 0; corner < 3; ++corner) scale_vector(share, out[f].nodal_force_n[corner]);
    }
}

void haptable_modes_pair_step(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                              struct haptable_modes_pair* state, struct haptable_pair* pair,
                              const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                              struct haptable_output out[HAPTABLE_FINGERS]) {
    const float owed_j = state->owed_j + haptable_modes_pair_feel(modes, tables, state, pair, finger_m, now_us, out);
    state->owed_j = owed_j > 0.0f ? owed_j : 0.0f;
    scale_forces(state, pair, out);
}

void haptable_modes_pair_step_finger(const struct haptable_modes* modes, const struct haptable_pair_model* tables,
                                     struct haptable_modes_pair* state, struct haptable_pair* pair, int number,
                                     const float finger_m[3], uint32_t now_us, struct haptable_output* out) {
    static const struct haptable_met away = {.patch = HAPTABLE_NONE};
    struct haptable_servo* servo = &pair->servo[number];
    struct haptable_modes_state one = {state->swings, state->met[number], state->stored_j - state->owed_j};
    haptable_modes_step(modes, &one, servo, finger_m, now_us, out);
    state->swings = one.swings;
    state->met[number] = one.met;
    state->met[1 - number] = away;
    state->stored_j = one.stored_j;
    state->contact_j = state->owed_j = 0.0f;
    pair->touches[number] = (uint8_t)haptable_touches(out->state);
    pair->touches[1 - number] = 0;
    if (tables->law->is_stiffness)
        vec_sub(servo->finger_m, servo->contact.god_object_m, pair->view[number].v);
    else
        vec_copy(one.met.load_n, pair->view[number].v);
}
