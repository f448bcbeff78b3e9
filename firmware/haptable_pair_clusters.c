/* SPDX-License-Identifier: MIT
 *
 * x_k = sum_i w_ki y_i,   y_i = sum_j A_ij v_j,   v_j = sum_l w_l w_lj
 * A_ij = s_i s_j step core_ij;   or s_i U_i t^T,   t = step core z,   z = sum_j v_j s_j U_j^T
 *
 * What couples two places in clusters (a uniform block low rank form): near clusters have a block for each pair, far
 * ones a core between bases that each cluster has once for all the others.
 */
#include "haptable_pair_terms.h"

#define PART (1.0f / 32767.0f)

/* The places that a patch loads. */
struct loads {
    const uint16_t* place;
    const int16_t (*share)[6]; /* where places are not controls, which are `own` */
    uint16_t own[HAPTABLE_PAIR_CONTROLS];
    uint8_t control[HAPTABLE_PAIR_CONTROLS]; /* of own */
    int count;
};

static void see_loads(const struct haptable_pair_model* tables, uint16_t patch, struct loads* to) {
    uint16_t control[HAPTABLE_PAIR_CONTROLS];
    int c;
    if (tables->load_count > 0) {
        const uint32_t begin = tables->load_begin[patch];
        to->place = &tables->load_place[begin];
        to->share = &tables->load_share[begin];
        to->count = (int)(tables->load_begin[patch + 1u] - begin);
        return;
    }
    to->place = to->own;
    to->share = 0;
    to->count = 0;
    pair_controls(tables, patch, control);
    for (c = 0; c < pair_count(tables->law); ++c) {
        if (control[c] == HAPTABLE_NONE) continue;
        to->own[to->count] = tables->place[control[c]];
        to->control[to->count++] = (uint8_t)c;
    }
}

/* How much of a control's load a place takes. */
static float share_of(const struct loads* loads, int i, int control) {
    if (loads->place == loads->own) return loads->control[i] == control ? 1.0f : 0.0f;
    return PART * (float)loads->share[i][control];
}

static uint32_t cluster_of(uint16_t place) { return place / HAPTABLE_PAIR_CLUSTER; }

/* Where the run of places of one cluster ends that begins at i. */
static int end_of_run(const struct loads* loads, int i) {
    const uint32_t cluster = cluster_of(loads->place[i]);
    do ++i;
    while (i < loads->count && cluster_of(loads->place[i]) == cluster);
    return i;
}

static void add_steps(float w, const int8_t core[9], int is_transposed, float y[9]) {
    int a;
    int b;
    for (a = 0; a < 3; ++a)
        for (b = 0; b < 3; ++b) y[3 * a + b] += w * (float)core[is_transposed ? 3 * b + a : 3 * a + b];
}

/* Two clusters, and the places of each that are asked for. */
struct two {
    const struct haptable_pair_model* tables;
    const struct loads* at;
    const struct loads* of;
    const float* v; /* of each place of `of` */
    int at_begin, at_end, of_begin, of_end;
    int is_transposed; /* 1: `at` has the earlier cluster */
    const int8_t* core;
    float step;
};

/* y_i += sum_j v_j s_i s_j step core_ij */
static void add_dense(const struct two* two, int is_twice, float (*y)[9]) {
    const float* scale = two->tables->scale;
    int i;
    int j;
    for (i = two->at_begin; i < two->at_end; ++i)
        for (j = two->of_begin; j < two->of_end; ++j) {
            const uint16_t k = two->at->place[i];
            const uint16_t l = two->of->place[j];
            const size_t row = (two->is_transposed ? l : k) % HAPTABLE_PAIR_CLUSTER;
            const size_t column = (two->is_transposed ? k : l) % HAPTABLE_PAIR_CLUSTER;
            const int8_t* core = two->core + (is_twice ? 18u : 9u) * (HAPTABLE_PAIR_CLUSTER * row + column);
            const float w = two->v[j] * scale[k] * scale[l] * two->step;
            if (w == 0.0f) continue;
            add_steps(w, core, two->is_transposed, y[i]);
            if (is_twice) add_steps(w * (1.0f / 254.0f), core + 9, two->is_transposed, y[i]);
        }
}

/* t = step core z */
static void core_product(const struct two* two, int rank, float (*z)[3], float (*t)[3]) {
    int a;
    int b;
    for (a = 0; a < rank; ++a) {
        vec_zero(t[a]);
        for (b = 0; b < rank; ++b)
            vec_add_scaled(two->step * (float)two->core[two->is_transposed ? rank * b + a : rank * a + b], z[b], t[a]);
    }
}

/* y_i += s_i U_i t^T */
static void add_low_rank(const struct two* two, int rank, float (*z)[3], float (*y)[9]) {
    const struct haptable_pair_model* tables = two->tables;
    float t[HAPTABLE_PAIR_RANK][3];
    size_t a;
    int i;
    int r;
    core_product(two, rank, z, t);
    for (i = two->at_begin; i < two->at_end; ++i) {
        const uint16_t k = two->at->place[i];
        const int16_t(*u)[3] = &tables->basis[(size_t)k * tables->rank];
        for (r = 0; r < rank; ++r)
            for (a = 0; a < 3; ++a) vec_add_scaled(tables->scale[k] * (float)u[r][a], t[r], &y[i][3 * a]);
    }
}

/* z = sum_j v_j s_j U_j^T over a run; 0 where nothing of it is loaded. */
static int project(const struct two* two, float (*z)[3]) {
    const struct haptable_pair_model* tables = two->tables;
    int any = 0;
    int j;
    int r;
    for (r = 0; r < tables->rank; ++r) vec_zero(z[r]);
    for (j = two->of_begin; j < two->of_end; ++j) {
        const uint16_t l = two->of->place[j];
        const int16_t(*u)[3] = &tables->basis[(size_t)l * tables->rank];
        const float w = two->v[j] * tables->scale[l];
        if (w == 0.0f) continue;
        any = 1;
        for (r = 0; r < tables->rank; ++r) {
            z[r][0] += w * (float)u[r][0];
            z[r][1] += w * (float)u[r][1];
            z[r][2] += w * (float)u[r][2];
        }
    }
    return any;
}

/* Between a run of each: y += A v. */
static void add_core(struct two* two, float (*z)[3], float (*y)[9]) {
    const struct haptable_pair_model* tables = two->tables;
    const uint32_t at = cluster_of(two->at->place[two->at_begin]);
    const uint32_t of = cluster_of(two->of->place[two->of_begin]);
    const uint32_t core = at >= of ? at * (at + 1u) / 2u + of : of * (of + 1u) / 2u + at;
    const int form = tables->core_form[core];
    two->is_transposed = at < of;
    two->core = &tables->core[tables->core_begin[core]];
    two->step = tables->core_step[core];
    if (form >= HAPTABLE_PAIR_DENSE)
        add_dense(two, form == HAPTABLE_PAIR_TWICE, y);
    else
        add_low_rank(two, form, z, y);
}

/* y_i = sum_j A_ij v_j, for each place that `at` loads. */
static void couple(const struct haptable_pair_model* tables, const struct loads* at, const struct loads* of,
                   const float v[], float (*y)[9]) {
    struct two two = {tables, at, of, v, 0, 0, 0, 0, 0, 0, 0.0f};
    const int count = at->count;
    float z[HAPTABLE_PAIR_RANK][3];
    int i;
    int a;
    for (i = 0; i < count; ++i)
        for (a = 0; a < 9; ++a) y[i][a] = 0.0f;
    for (two.of_begin = 0; two.of_begin < of->count; two.of_begin = two.of_end) {
        two.of_end = end_of_run(of, two.of_begin);
        if (!project(&two, z)) continue;
        for (two.at_begin = 0; two.at_begin < count; two.at_begin = two.at_end) {
            two.at_end = end_of_run(at, two.at_begin);
            add_core(&two, z, y);
        }
    }
}

/* x = sum_i w_ki y_i */
static void gather_control(const struct loads* at, float (*y)[9], int control, float x[9]) {
    int i;
    int a;
    for (a = 0; a < 9; ++a) x[a] = 0.0f;
    for (i = 0; i < at->count; ++i) {
        const float share = share_of(at, i, control);
        if (share != 0.0f) pair_add(share, y[i], x);
    }
}

void haptable_pair_cross_clusters(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]) {
    const struct haptable_pair_model* tables = view->tables;
    struct loads at;
    struct loads of;
    float v[HAPTABLE_PAIR_PLACES];
    float y[HAPTABLE_PAIR_PLACES][9];
    int i;
    int c;
    see_loads(tables, patch, &at);
    see_loads(tables, view->place.patch, &of);
    for (i = 0; i < of.count; ++i) {
        v[i] = 0.0f;
        for (c = 0; c < pair_count(tables->law); ++c) v[i] += view->place.weight[c] * share_of(&of, i, c);
    }
    couple(tables, &at, &of, v, y);
    for (c = 0; c < pair_count(tables->law); ++c) gather_control(&at, y, c, x[c]);
}

void haptable_pair_blocks_clusters(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                   float (*block)[9]) {
    const int count = pair_count(tables->law);
    struct loads at;
    struct loads of;
    float v[HAPTABLE_PAIR_PLACES];
    float y[HAPTABLE_PAIR_PLACES][9];
    int i;
    int k;
    int l;
    see_loads(tables, first, &at);
    see_loads(tables, second, &of);
    for (l = 0; l < count; ++l) {
        for (i = 0; i < of.count; ++i) v[i] = share_of(&of, i, l);
        couple(tables, &at, &of, v, y);
        for (k = 0; k < count; ++k) gather_control(&at, y, k, block[k * count + l]);
    }
}
