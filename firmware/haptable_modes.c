/* SPDX-License-Identifier: MIT
 *
 *   (C + G/2) (f_m - f) = dx - J dq_f / 2,   G = J b J^T,   q+ - q = A (q, p) + b J^T f_m
 *
 * J is phi at the fingers' places, three rows each; f the load that the hands have felt since the last tick, dx how far
 * they went with it, dq_f how far the modes would go under f; C the compliance of the contacts. So modes and contacts
 * gain what the hands gave, f . dx, and dx . C^-1 dx / 2 besides, which is what a wall of that stiffness makes of hands
 * that are felt at ticks: the modes make nothing (docs/design/moving.md).
 */
#include "haptable_modes.h"

#include "haptable_matrix.h"

/* phi [count, 3] at a place: 0 where that is held; nothing where it is none. */
static void shape_at(const struct haptable_modes* modes, const struct haptable_model* model, uint16_t patch,
                     const float alpha[3], float shape[HAPTABLE_MODES][3]) {
    const float(*row[6])[3];
    float weight[6];
    int count = 0;
    if (patch == HAPTABLE_NONE) return;
    for (int c = 0; c < modes->controls; ++c) {
        const uint16_t vertex = model->patch[patch][c % 3];
        uint32_t control = vertex;
        if (modes->controls == 3 && vertex >= model->free_count) continue;
        weight[count] = modes->controls > 3 ? alpha[c % 3] * alpha[c % 3] : alpha[c];
        if (c >= 3) {
            control = (uint32_t)model->vertex_count + model->compliance->patch_edge[patch][c - 3];
            weight[count] = 2.0f * alpha[(c + 1) % 3] * alpha[(c + 2) % 3];
        }
        row[count++] = &modes->shape[control * modes->count];
    }
    for (int k = 0; k < modes->count; ++k) {
        float sum[3] = {0.0f, 0.0f, 0.0f};
        for (int c = 0; c < count; ++c) vec_add_scaled(weight[c], row[c][k], sum);
        vec_copy(sum, shape[k]);
    }
}

/* ---- the load -------------------------------------------------------------------------------------------------- */

/* A block on the diagonal, by its lower half. */
static void block_at(float (*a)[HAPTABLE_ROWS], int at, float block[6]) {
    for (int i = 0; i < 3; ++i) block[i] = a[at + i][at + i];
    block[3] = a[at + 1][at];
    block[4] = a[at + 2][at + 1];
    block[5] = a[at + 2][at];
}

/* a x = b of three rows or six, by blocks of three: a is positive definite. b becomes x. */
static void solve_rows(int rows, float (*a)[HAPTABLE_ROWS], float b[HAPTABLE_ROWS]) {
    float first[6], second[6], inverse[6], x[9], xm[9], n[6], t[3];
    block_at(a, 0, first);
    if (rows == 3) {
        sym_solve_once(first, b, b);
        return;
    }
    block_at(a, 3, second);
    for (int i = 0; i < 3; ++i) vec_copy(a[3 + i], &x[3 * i]);
    sym_invert(first, inverse);
    sym_reduce(second, x, inverse, xm, n);
    mat_product(xm, b, t);
    vec_sub(&b[3], t, t);
    sym_solve_once(n, t, &b[3]);
    mat_transposed_product(x, &b[3], t);
    vec_sub(b, t, t);
    vec_symmetric_product(inverse, t, b);
}

typedef float haptable_shapes[HAPTABLE_FINGERS][HAPTABLE_MODES][3];

/* How far a mode goes in the tick without a force. */
static float free_change(const struct haptable_mode* mode, float q, float p) {
    return mode->q_by_q * q + mode->q_by_p * p;
}

/* phi of mode k along the loads; of one that does not press there is none. */
static float along(const struct haptable_modes_state* state, haptable_shapes shape, int k,
                   const struct haptable_modes_load* load) {
    float force = 0.0f;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        if (state->met[f].patch != HAPTABLE_NONE) force += vec_dot(shape[f][k], &load->load_n[3 * f]);
    return force;
}

/* f_m, of the rows up to the last finger that presses. */
static void find_load(const struct haptable_modes* modes, const struct haptable_modes_state* state,
                      haptable_shapes shape, struct haptable_modes_load* load) {
    const int rows = load->presses > 1u ? HAPTABLE_ROWS : 3;
    float more[HAPTABLE_ROWS];
    for (int i = 0; i < rows; ++i) more[i] = load->moved_m[i];
    for (int k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        const float goes = free_change(mode, state->q[k], state->p[k]) + mode->q_by_f * along(state, shape, k, load);
        for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
            const float* row = shape[f][k];
            if ((load->presses >> f & 1u) == 0u) continue;
            vec_add_scaled(-0.5f * goes, row, &more[3 * f]);
            HAPTABLE_UNROLLED
            for (int i = 0; i < 3; ++i) {
                const float part = 0.5f * mode->q_by_f * row[i];
                float* c = load->compliance[3 * f + i];
                if (load->presses == 3u && f == 1) vec_add_scaled(part, shape[0][k], c);
                HAPTABLE_UNROLLED
                for (int j = 0; j <= i; ++j) c[3 * f + j] += part * row[j];
            }
        }
    }
    solve_rows(rows, load->compliance, more);
    for (int i = 0; i < rows; ++i) load->load_n[i] += more[i];
}

void haptable_modes_advance(const struct haptable_modes* modes, const struct haptable_model* model,
                            struct haptable_modes_state* state, struct haptable_modes_load* load) {
    haptable_shapes shape;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        shape_at(modes, model, state->met[f].patch, state->met[f].alpha, shape[f]);
    if (load->presses != 0u) find_load(modes, state, shape, load);
    for (int k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        const float q = state->q[k];
        const float p = state->p[k];
        const float force = along(state, shape, k, load);
        add_whole(free_change(mode, q, p) + mode->q_by_f * force, &state->q[k], &state->q_low[k]);
        add_whole(mode->p_by_q * q + mode->p_by_p * p + mode->q_by_p * force, &state->p[k], &state->p_low[k]);
        for (int f = 0; f < HAPTABLE_FINGERS; ++f)
            if (state->met[f].patch != HAPTABLE_NONE)
                vec_add_scaled(state->q[k] - q, shape[f][k], state->met[f].shift_m);
    }
}

/* ---- where the surface is met ------------------------------------------------------------------------------------ */

void haptable_modes_follow(const struct haptable_modes* modes, const struct haptable_model* model,
                           struct haptable_modes_state* state, int finger, const struct haptable_contact* contact,
                           const float load_n[3], float* credit_j) {
    struct haptable_met* met = &state->met[finger];
    float shape[HAPTABLE_MODES][3], apart_m[3];
    float part = 1.0f;
    if (contact->patch != HAPTABLE_NONE) {
        met->patch = contact->patch;
        vec_copy(contact->alpha, met->alpha);
    }
    if (met->patch == HAPTABLE_NONE) return;
    shape_at(modes, model, met->patch, met->alpha, shape);
    vec_zero(apart_m);
    for (int k = 0; k < modes->count; ++k) vec_add_scaled(state->q[k], shape[k], apart_m);
    vec_add_scaled(-1.0f, met->shift_m, apart_m);
    if (contact->patch != HAPTABLE_NONE) {
        const float cost_j =
            0.5f * model->stiffness_limit_n_per_m * vec_dot(apart_m, apart_m) - vec_dot(load_n, apart_m);
        if (cost_j > *credit_j) part = *credit_j > 0.0f ? *credit_j / cost_j : 0.0f;
        if (cost_j > 0.0f) *credit_j -= part * cost_j;
    }
    vec_add_scaled(part, apart_m, met->shift_m);
}

void haptable_modes_init(struct haptable_modes_state* state) {
    static const struct haptable_modes_state fresh = {0};
    *state = fresh;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) state->met[f].patch = HAPTABLE_NONE;
}

float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_modes_state* state) {
    float twice_j = 0.0f;
    for (int k = 0; k < modes->count; ++k)
        twice_j += state->p[k] * state->p[k] + modes->mode[k].stiffness * state->q[k] * state->q[k];
    return 0.5f * twice_j;
}

struct haptable_span haptable_span_of_modes(const void* tables, uint32_t field) {
    const struct haptable_modes* modes = (const struct haptable_modes*)tables;
    const struct haptable_span span[] = {
        {&modes->count, (uint32_t)sizeof modes->count},
        {&modes->controls, (uint32_t)sizeof modes->controls},
        {&modes->control_count, (uint32_t)sizeof modes->control_count},
        {modes->mode, modes->count * (uint32_t)sizeof *modes->mode},
        {modes->shape, (uint32_t)modes->control_count * modes->count * (uint32_t)sizeof *modes->shape},
        {modes, HAPTABLE_SPAN_END}};
    return span[field < 5u ? field : 5u];
}

const struct haptable_modes_part haptable_part_modes = {.init = haptable_modes_init,
                                                        .advance = haptable_modes_advance,
                                                        .follow = haptable_modes_follow,
                                                        .energy = haptable_modes_energy,
                                                        .span = haptable_span_of_modes};
