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

#include "haptable_vector.h"

/* sum += part, with what the sum does not hold kept in low. */
static void add_whole(float part, float* sum, float* low) {
    const float corrected = part - *low;
    const float next = *sum + corrected;
    *low = (next - *sum) - corrected;
    *sum = next;
}

/* phi [count, 3] at a place: 0 where that is held, or none. */
static void shape_at(const struct haptable_modes* modes, const struct haptable_model* model, uint16_t patch,
                     const float alpha[3], float shape[HAPTABLE_MODES][3]) {
    const float(*row[6])[3];
    float weight[6];
    int count = 0;
    int c;
    int k;
    for (c = 0; c < modes->controls && patch != HAPTABLE_NONE; ++c) {
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
    for (k = 0; k < modes->count; ++k) {
        float sum[3] = {0.0f, 0.0f, 0.0f};
        for (c = 0; c < count; ++c) vec_add_scaled(weight[c], row[c][k], sum);
        vec_copy(sum, shape[k]);
    }
}

/* ---- the load -------------------------------------------------------------------------------------------------- */

/* a x = b of n rows, a = L D L^T of its lower half, in place: it is positive definite. b becomes x. */
static void solve_rows(int n, float (*a)[HAPTABLE_ROWS], float b[HAPTABLE_ROWS]) {
    float scaled[HAPTABLE_ROWS];
    int i;
    int j;
    int k;
    for (j = 0; j < n; ++j) {
        float d = a[j][j];
        for (k = 0; k < j; ++k) {
            scaled[k] = a[j][k] * a[k][k];
            d -= a[j][k] * scaled[k];
            b[j] -= a[j][k] * b[k];
        }
        a[j][j] = d;
        for (i = j + 1; i < n; ++i) {
            for (k = 0; k < j; ++k) a[i][j] -= a[i][k] * scaled[k];
            a[i][j] /= d;
        }
    }
    for (i = n - 1; i >= 0; --i) {
        b[i] /= a[i][i];
        for (k = i + 1; k < n; ++k) b[i] -= a[k][i] * b[k];
    }
}

typedef float haptable_shapes[HAPTABLE_FINGERS][HAPTABLE_MODES][3];

/* phi of mode k at those that press, by rows. */
static void row_of(haptable_shapes shape, int k, unsigned presses, float row[HAPTABLE_ROWS]) {
    int f;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) {
        if ((presses >> f & 1u) != 0u)
            vec_copy(shape[f][k], &row[3 * f]);
        else
            vec_zero(&row[3 * f]);
    }
}

static float dot_rows(const float a[HAPTABLE_ROWS], const float b[HAPTABLE_ROWS]) {
    return vec_dot(&a[0], &b[0]) + vec_dot(&a[3], &b[3]);
}

/* How far a mode goes in the tick without a force. */
static float free_change(const struct haptable_mode* mode, float q, float p) {
    return mode->q_by_q * q + mode->q_by_p * p;
}

/* f_m, of the rows up to the last finger that presses. */
static void find_load(const struct haptable_modes* modes, const struct haptable_modes_state* state,
                      haptable_shapes shape, struct haptable_modes_load* load) {
    const int rows = load->presses > 1u ? HAPTABLE_ROWS : 3;
    float more[HAPTABLE_ROWS];
    int k;
    int i;
    int j;
    for (i = 0; i < rows; ++i) more[i] = load->moved_m[i];
    for (k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        float row[HAPTABLE_ROWS];
        float goes;
        row_of(shape, k, load->presses, row);
        goes = free_change(mode, state->q[k], state->p[k]) + mode->q_by_f * dot_rows(row, load->load_n);
        for (i = 0; i < rows; ++i) {
            const float part = 0.5f * mode->q_by_f * row[i];
            more[i] -= 0.5f * goes * row[i];
            for (j = 0; j <= i; ++j) load->compliance[i][j] += part * row[j];
        }
    }
    solve_rows(rows, load->compliance, more);
    for (i = 0; i < rows; ++i) load->load_n[i] += more[i];
}

void haptable_modes_advance(const struct haptable_modes* modes, const struct haptable_model* model,
                            struct haptable_modes_state* state, struct haptable_modes_load* load) {
    haptable_shapes shape;
    int f;
    int k;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) shape_at(modes, model, state->met[f].patch, state->met[f].alpha, shape[f]);
    if (load->presses != 0u) find_load(modes, state, shape, load);
    for (k = 0; k < modes->count; ++k) {
        const struct haptable_mode* mode = &modes->mode[k];
        const float q = state->q[k];
        const float p = state->p[k];
        float row[HAPTABLE_ROWS];
        float force;
        row_of(shape, k, load->presses, row);
        force = dot_rows(row, load->load_n);
        add_whole(free_change(mode, q, p) + mode->q_by_f * force, &state->q[k], &state->q_low[k]);
        add_whole(mode->p_by_q * q + mode->p_by_p * p + mode->q_by_p * force, &state->p[k], &state->p_low[k]);
        for (f = 0; f < HAPTABLE_FINGERS; ++f) vec_add_scaled(state->q[k] - q, shape[f][k], state->met[f].shift_m);
    }
}

/* ---- where the surface is met ------------------------------------------------------------------------------------ */

void haptable_modes_follow(const struct haptable_modes* modes, const struct haptable_model* model,
                           struct haptable_modes_state* state, int finger, const struct haptable_contact* contact,
                           const float load_n[3], float* credit_j) {
    struct haptable_met* met = &state->met[finger];
    float shape[HAPTABLE_MODES][3];
    float apart_m[3];
    float part = 1.0f;
    int k;
    if (contact->patch != HAPTABLE_NONE) {
        met->patch = contact->patch;
        vec_copy(contact->alpha, met->alpha);
    }
    shape_at(modes, model, met->patch, met->alpha, shape);
    vec_zero(apart_m);
    for (k = 0; k < modes->count; ++k) vec_add_scaled(state->q[k], shape[k], apart_m);
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
    int f;
    *state = fresh;
    for (f = 0; f < HAPTABLE_FINGERS; ++f) state->met[f].patch = HAPTABLE_NONE;
}

float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_modes_state* state) {
    float twice_j = 0.0f;
    int k;
    for (k = 0; k < modes->count; ++k)
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
