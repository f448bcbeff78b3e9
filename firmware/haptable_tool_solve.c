/* SPDX-License-Identifier: MIT
 *
 * C_TT f_T = u_T with every f_i . n_i <= 0, and n_i . (u_i - sum_j C_ij f_j) >= 0 of each point out of T
 *
 * Linear complementarity along the outward normals n, by an active set that begins with the last tick's. C = L L^T is
 * factored anew for each set: a tick takes one in most ticks.
 */
#include "haptable_pair_terms.h"
#include "haptable_side.h"
#include "haptable_tool.h"

/* A pivot is at least this part of C's own diagonal: points that load one place stay apart. */
#define LEAST_PIVOT 1e-4f

/* ---- C ----------------------------------------------------------------------------------------------------------- */

/* The system of a tool: C(i, j), i <= j, above the diagonal and on it; L of T, in its order, below; then 1 / L_rr. */
struct system {
    float* a;
    float* inverse;
    uint32_t width;
};

static struct system system_of(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    struct system to;
    to.width = 3u * tool->point_count;
    to.a = haptable_tool_system(tool, state);
    to.inverse = to.a + to.width * to.width;
    return to;
}

/* C's entry of row r and column c, r <= c. */
static inline float* entry(const struct system* in, uint32_t r, uint32_t c) { return &in->a[r * in->width + c]; }

static void put_own(const struct system* in, uint32_t i, const float own[6]) {
    *entry(in, 3u * i, 3u * i) = own[0];
    *entry(in, 3u * i + 1u, 3u * i + 1u) = own[1];
    *entry(in, 3u * i + 2u, 3u * i + 2u) = own[2];
    *entry(in, 3u * i, 3u * i + 1u) = own[3];
    *entry(in, 3u * i + 1u, 3u * i + 2u) = own[4];
    *entry(in, 3u * i, 3u * i + 2u) = own[5];
}

static void put_cross(const struct system* in, uint32_t i, uint32_t j, const float x[9]) {
    for (uint32_t r = 0; r < 3u; ++r) vec_copy(&x[3u * r], entry(in, 3u * i + r, 3u * j));
}

/* out += C_ij v, for any i and j. */
static void add_product(const struct system* in, uint32_t i, uint32_t j, const float v[3], float out[3]) {
    for (uint32_t r = 0; r < 3u; ++r)
        for (uint32_t c = 0; c < 3u; ++c) {
            const uint32_t row = 3u * i + r;
            const uint32_t column = 3u * j + c;
            out[r] += (row <= column ? *entry(in, row, column) : *entry(in, column, row)) * v[c];
        }
}

/* Rows of the points that are new, or have moved. */
static void assemble(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    const struct system in = system_of(tool, state);
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        struct haptable_tool_point* at = &point[i];
        if (!at->is_inside || at->is_known) continue;
        tool->pair->law->own(tool->pair->model, &at->at, at->servo.finger_m, &at->own);
        haptable_pair_place_of(tool->pair->law, &at->at, &at->place);
        put_own(&in, i, at->own.a);
    }
    for (uint32_t j = 1; j < tool->point_count; ++j)
        for (uint32_t i = 0; i < j && point[j].is_inside; ++i) {
            float x[9];
            if (!point[i].is_inside || (point[i].is_known && point[j].is_known)) continue;
            tool->couple(tool->pair, &point[i].place, &point[j].place, x);
            put_cross(&in, i, j, x);
        }
    for (uint32_t i = 0; i < tool->point_count; ++i) point[i].is_known = point[i].is_inside;
}

void haptable_tool_lowered(const struct haptable_tool_model* tool, struct haptable_tool_state* state, uint32_t i,
                           float lowered_m[3]) {
    const struct system in = system_of(tool, state);
    const struct haptable_tool_point* point = haptable_tool_points(tool, state);
    vec_zero(lowered_m);
    for (uint32_t j = 0; j < tool->point_count; ++j)
        if (point[j].presses) add_product(&in, i, j, point[j].load_n, lowered_m);
}

/* ---- the factor -------------------------------------------------------------------------------------------------- */

/* Four sums, so that they need not wait for one another. */
static float product_of(const float* a, const float* b, uint32_t count) {
    float sum[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    uint32_t k = 0;
    for (; k + 4u <= count; k += 4u) {
        sum[0] += a[k] * b[k];
        sum[1] += a[k + 1u] * b[k + 1u];
        sum[2] += a[k + 2u] * b[k + 2u];
        sum[3] += a[k + 3u] * b[k + 3u];
    }
    for (; k < count; ++k) sum[0] += a[k] * b[k];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

/* Points of T, in their order. */
static void put_order(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    const struct haptable_tool_point* point = haptable_tool_points(tool, state);
    state->count = 0;
    for (uint32_t i = 0; i < tool->point_count; ++i)
        if (point[i].presses) state->order[state->count++] = (uint16_t)i;
}

/* C_TT = L L^T. before: put_order. */
static void factor(const struct system* in, const struct haptable_tool_state* state) {
    const uint32_t rows = 3u * state->count;
    for (uint32_t r = 0; r < rows; ++r) {
        float* row = &in->a[r * in->width];
        const uint32_t at = 3u * state->order[r / 3u] + r % 3u;
        const float own = *entry(in, at, at);
        for (uint32_t c = 0; c < r; ++c) {
            const uint32_t other = 3u * state->order[c / 3u] + c % 3u;
            row[c] = (*entry(in, other, at) - product_of(row, &in->a[c * in->width], c)) * in->inverse[c];
        }
        float pivot = own - product_of(row, row, r);
        if (!(pivot > LEAST_PIVOT * own)) pivot = LEAST_PIVOT * own;
        in->inverse[r] = vec_inverse_root(pivot);
    }
}

static void solve(const struct system* in, uint32_t rows, float x[]) {
    for (uint32_t r = 0; r < rows; ++r) x[r] = (x[r] - product_of(&in->a[r * in->width], x, r)) * in->inverse[r];
    for (uint32_t r = rows; r-- > 0u;) {
        const float* row = &in->a[r * in->width];
        x[r] *= in->inverse[r];
        for (uint32_t c = 0; c < r; ++c) x[c] -= row[c] * x[r];
    }
}

void haptable_tool_stiffness(const struct haptable_tool_model* tool, struct haptable_tool_state* state, float (*k)[6]) {
    const struct system in = system_of(tool, state);
    const struct haptable_tool_point* point = haptable_tool_points(tool, state);
    const uint32_t rows = 3u * state->count;
    float w[6][3 * HAPTABLE_POINTS]; /* L^-1 J by columns */
    for (uint32_t c = 0; c < 6u; ++c)
        for (uint32_t a = 0; a < state->count; ++a) {
            float axis[3] = {0.0f, 0.0f, 0.0f};
            axis[c % 3u] = 1.0f;
            if (c < 3u)
                vec_copy(axis, &w[c][3u * a]);
            else
                vec_cross(axis, point[state->order[a]].r_m, &w[c][3u * a]);
        }
    for (uint32_t c = 0; c < 6u; ++c) {
        for (uint32_t r = 0; r < rows; ++r)
            w[c][r] = (w[c][r] - product_of(in.a + r * in.width, w[c], r)) * in.inverse[r];
        for (uint32_t other = 0; other <= c; ++other) k[c][other] = product_of(w[c], w[other], rows);
    }
}

/* ---- who touches ------------------------------------------------------------------------------------------------- */

/* u, from where the surface was when the contact began. */
static void dent_of(const struct haptable_tool_point* point, float u[3]) {
    vec_sub(point->servo.finger_m, point->at.god_object_m, u);
    vec_add_scaled(point->raised_m, point->normal, u);
}

static void put_loads(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    const struct system in = system_of(tool, state);
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    float x[3 * HAPTABLE_POINTS];
    put_order(tool, state);
    factor(&in, state);
    for (uint32_t a = 0; a < state->count; ++a) dent_of(&point[state->order[a]], &x[3u * a]);
    solve(&in, 3u * state->count, x);
    for (uint32_t a = 0; a < state->count; ++a) vec_copy(&x[3u * a], point[state->order[a]].load_n);
    ++state->sets;
}

/* Takes out of T the points whose load would pull the surface. */
static int drop(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    int dropped = 0;
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        if (!point[i].presses || !(vec_dot(point[i].load_n, point[i].normal) > 0.0f)) continue;
        point[i].presses = 0;
        vec_zero(point[i].load_n);
        ++dropped;
    }
    return dropped;
}

/* How far a point out of T is outside of the surface as the others dent it. */
static float gap_of(const struct haptable_tool_model* tool, struct haptable_tool_state* state, uint32_t i) {
    const struct haptable_tool_point* point = &haptable_tool_points(tool, state)[i];
    float u[3], lowered_m[3];
    dent_of(point, u);
    haptable_tool_lowered(tool, state, i, lowered_m);
    vec_sub(u, lowered_m, u);
    return vec_dot(u, point->normal);
}

/* Takes points into T that the dented surface does not leave behind: all of them, or the one that is deepest. */
static int add(const struct haptable_tool_model* tool, struct haptable_tool_state* state, int takes_all) {
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    uint8_t adds[HAPTABLE_POINTS];
    float least = -tool->pair->model->tolerance_m;
    uint32_t deepest = tool->point_count;
    int added = 0;
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        adds[i] = 0;
        if (!point[i].is_inside || point[i].presses) continue;
        const float gap = gap_of(tool, state, i);
        if (gap < -tool->pair->model->tolerance_m) adds[i] = (uint8_t)takes_all;
        if (gap >= least) continue;
        least = gap;
        deepest = i;
    }
    if (deepest < tool->point_count) adds[deepest] = 1;
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        if (!adds[i]) continue;
        point[i].presses = 1;
        ++added;
    }
    return added;
}

/* Of a contact that begins where the others have raised the surface, and of one that gave no force. */
static void put_raised(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        struct haptable_tool_point* at = &point[i];
        const int is_new = at->is_inside && at->met != at->servo.counters.contacts;
        float moved_m[3];
        if (!at->is_inside || (!is_new && (at->presses || !(at->raised_m > 0.0f)))) continue;
        haptable_tool_lowered(tool, state, i, moved_m);
        const float raised_m = vec_dot(moved_m, at->normal);
        if (is_new || raised_m < at->raised_m) at->raised_m = raised_m > 0.0f ? raised_m : 0.0f;
        at->met = at->servo.counters.contacts;
    }
}

void haptable_tool_solve(const struct haptable_tool_model* tool, struct haptable_tool_state* state, int most_sets) {
    struct haptable_tool_point* point = haptable_tool_points(tool, state);
    int goes_on = 1;
    assemble(tool, state);
    put_raised(tool, state);
    for (int set = 0; goes_on && set < most_sets; ++set) {
        put_loads(tool, state);
        goes_on = drop(tool, state) || (set < most_sets / 2 && add(tool, state, state->count == 0));
    }
    state->energy_j = 0.0f;
    for (uint32_t i = 0; i < tool->point_count; ++i) {
        float u[3];
        if (!point[i].presses) continue;
        dent_of(&point[i], u);
        state->energy_j += 0.5f * vec_dot(u, point[i].load_n);
    }
}
