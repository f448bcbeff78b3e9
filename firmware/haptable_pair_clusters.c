/* SPDX-License-Identifier: MIT
 *
 * x_kl = sum_i w_ki y_il,   y_il = sum_j A_ij v_jl
 * A_ij = s_i s_j step core_ij;   or y_il = s_i U_i t_l^T,   t_l = sum step core z_l,   z_l = sum_j v_jl s_j U_j^T
 *
 * What couples two places in clusters (a uniform block low rank form): near clusters have a block for each pair, far
 * ones a core between bases that each cluster has once for all the others. What a place loads of its clusters' bases is
 * found once, and what they do to another cluster is summed there before it goes to that one's places.
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
    haptable_pair_controls(tables, patch, control);
    for (int c = 0; c < pair_count(tables->law); ++c) {
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

/* So many clusters of the loaded place are projected at once; more of them take another round. */
#define RUNS 16

/* The places of a patch that are of one cluster, and what they load of its basis. */
struct run {
    uint32_t cluster;
    int begin;
    int end;
    float z[HAPTABLE_PAIR_RANK][3]; /* sum_j v_j s_j U_j^T */
};

/* What the loaded place is: v_j s_j of its places, and a round of its clusters. */
struct loaded {
    const struct haptable_pair_model* tables;
    const struct loads* of;
    float v[HAPTABLE_PAIR_PLACES];
    int runs;
    struct run run[RUNS];
};

static void scale_loads(const float weight[], struct loaded* from) {
    const int count = pair_count(from->tables->law);
    for (int j = 0; j < from->of->count; ++j) {
        float v = 0.0f;
        for (int c = 0; c < count; ++c) v += weight[c] * share_of(from->of, j, c);
        from->v[j] = v * from->tables->scale[from->of->place[j]];
    }
}

/* The next clusters that are loaded, from place j on. Returns the place that follows them. */
static int project(struct loaded* from, int j) {
    const struct haptable_pair_model* tables = from->tables;
    from->runs = 0;
    while (from->runs < RUNS && j < from->of->count) {
        struct run* run = &from->run[from->runs];
        int loads = 0;
        run->cluster = cluster_of(from->of->place[j]);
        run->begin = j;
        run->end = end_of_run(from->of, j);
        for (int r = 0; r < tables->rank; ++r) vec_zero(run->z[r]);
        for (; j < run->end; ++j) {
            const int16_t(*u)[3] = &tables->basis[(size_t)from->of->place[j] * tables->rank];
            if (from->v[j] == 0.0f) continue;
            loads = 1;
            for (int r = 0; r < tables->rank; ++r) {
                run->z[r][0] += from->v[j] * (float)u[r][0];
                run->z[r][1] += from->v[j] * (float)u[r][1];
                run->z[r][2] += from->v[j] * (float)u[r][2];
            }
        }
        from->runs += loads;
    }
    return j;
}

/* A core of two clusters as one of them has it: where its rows and columns stand. */
struct core {
    const int8_t* first;
    float step;
    size_t row;
    size_t column;
    int is_transposed; /* 1: the other one has the rows of blocks */
};

/* y += w core */
static inline void add_steps(float w, const int8_t core[9], int is_transposed, float y[9]) {
    for (int a = 0; a < 3; ++a) {
        y[3 * a] += w * (float)core[is_transposed ? a : 3 * a];
        y[3 * a + 1] += w * (float)core[is_transposed ? 3 + a : 3 * a + 1];
        y[3 * a + 2] += w * (float)core[is_transposed ? 6 + a : 3 * a + 2];
    }
}

/* y_i += sum_j v_j s_j step core_ij of the places of a run. */
static void add_dense(const struct loaded* from, const struct run* run, const struct core* core, int is_twice,
                      const uint16_t place[], int places, float (*y)[9]) {
    const size_t bytes = is_twice ? 18u : 9u;
    for (int j = run->begin; j < run->end; ++j) {
        const size_t l = from->of->place[j] % HAPTABLE_PAIR_CLUSTER;
        const float w = from->v[j] * core->step;
        if (w == 0.0f) continue;
        for (int i = 0; i < places; ++i) {
            const size_t k = place[i] % HAPTABLE_PAIR_CLUSTER;
            const int8_t* steps = core->first + bytes * (core->row * k + core->column * l);
            add_steps(w, steps, core->is_transposed, y[i]);
            if (is_twice) add_steps(w * (1.0f / 254.0f), steps + 9, core->is_transposed, y[i]);
        }
    }
}

/* t += step core z */
static void add_low_rank(const struct run* run, const struct core* core, int rank, float (*t)[3]) {
    for (int r = 0; r < rank; ++r) {
        const int8_t* steps = core->first + core->row * (size_t)r;
        float sum[3] = {0.0f, 0.0f, 0.0f};
        for (int b = 0; b < rank; ++b, steps += core->column) {
            const float by = (float)*steps;
            sum[0] += by * run->z[b][0];
            sum[1] += by * run->z[b][1];
            sum[2] += by * run->z[b][2];
        }
        vec_add_scaled(core->step, sum, t[r]);
    }
}

/* y_i = sum_j A_ij v_j of places of one cluster, without s_i. */
static void respond(const struct loaded* from, const uint16_t place[], int places, float (*y)[9]) {
    const struct haptable_pair_model* tables = from->tables;
    const uint32_t at = cluster_of(place[0]);
    float t[HAPTABLE_PAIR_RANK][3];
    int most = 0;
    for (int i = 0; i < places; ++i)
        for (int a = 0; a < 9; ++a) y[i][a] = 0.0f;
    for (int r = 0; r < HAPTABLE_PAIR_RANK; ++r) vec_zero(t[r]);
    for (int r = 0; r < from->runs; ++r) {
        const struct run* run = &from->run[r];
        const uint32_t of = run->cluster;
        const uint32_t at_core = at >= of ? at * (at + 1u) / 2u + of : of * (of + 1u) / 2u + at;
        const int form = tables->core_form[at_core];
        const size_t size = form >= HAPTABLE_PAIR_DENSE ? HAPTABLE_PAIR_CLUSTER : (size_t)form;
        struct core core;
        if (form == 0) continue;
        core.first = &tables->core[tables->core_begin[at_core]];
        core.step = tables->core_step[at_core];
        core.is_transposed = at < of;
        core.row = at < of ? 1u : size;
        core.column = at < of ? size : 1u;
        if (form >= HAPTABLE_PAIR_DENSE) {
            add_dense(from, run, &core, form == HAPTABLE_PAIR_TWICE, place, places, y);
        } else {
            add_low_rank(run, &core, form, t);
            if (form > most) most = form;
        }
    }
    for (int i = 0; i < places; ++i)
        for (int r = 0; r < most; ++r) {
            const int16_t* u = tables->basis[(size_t)place[i] * tables->rank + (size_t)r];
            vec_add_scaled((float)u[0], t[r], &y[i][0]);
            vec_add_scaled((float)u[1], t[r], &y[i][3]);
            vec_add_scaled((float)u[2], t[r], &y[i][6]);
        }
}

/* x: a row for each control of `first`, each `next` after the one before. */
static void couple(const struct haptable_pair_model* tables, const struct loads* at, const struct loads* of,
                   const float weight[], float (*x)[9], int next) {
    const int count = pair_count(tables->law);
    struct loaded from;
    int j = 0;
    from.tables = tables;
    from.of = of;
    scale_loads(weight, &from);
    for (int k = 0; k < count; ++k) {
        for (int a = 0; a < 9; ++a) x[k * next][a] = 0.0f;
    }
    while (j < of->count) {
        int end;
        j = project(&from, j);
        for (int begin = 0; begin < at->count; begin = end) {
            float y[HAPTABLE_PAIR_CLUSTER][9];
            end = end_of_run(at, begin);
            respond(&from, &at->place[begin], end - begin, y);
            for (int i = begin; i < end; ++i)
                for (int k = 0; k < count; ++k) {
                    const float w = tables->scale[at->place[i]] * share_of(at, i, k);
                    if (w != 0.0f) mat_add(w, y[i - begin], x[k * next]);
                }
        }
    }
}

void haptable_pair_cross_clusters(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]) {
    struct loads at, of;
    see_loads(view->tables, patch, &at);
    see_loads(view->tables, view->place.patch, &of);
    couple(view->tables, &at, &of, view->place.weight, x, 1);
}

void haptable_pair_blocks_clusters(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                   float (*block)[9]) {
    const int count = pair_count(tables->law);
    struct loads at, of;
    see_loads(tables, first, &at);
    see_loads(tables, second, &of);
    for (int l = 0; l < count; ++l) {
        float weight[HAPTABLE_PAIR_CONTROLS] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        weight[l] = 1.0f;
        couple(tables, &at, &of, weight, block + l, count);
    }
}

/* x_k = sum_l w_l C_kl by the first's controls. */
static void rows_between(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                         const struct haptable_pair_place* second, float (*x)[9]) {
    struct loads at, of;
    see_loads(tables, first->patch, &at);
    see_loads(tables, second->patch, &of);
    couple(tables, &at, &of, second->weight, x, 1);
}

void haptable_pair_couple_clusters(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                   const struct haptable_pair_place* second, float x[9]) {
    float row[HAPTABLE_PAIR_CONTROLS][9];
    rows_between(tables, first, second, row);
    pair_sum_blocks(pair_count(tables->law), first->weight, row[0], 9, x);
}

void haptable_pair_pull_clusters(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                 const struct haptable_pair_place* second, const float v[3], const float w[3],
                                 float q[HAPTABLE_PAIR_CONTROLS], float r[HAPTABLE_PAIR_CONTROLS]) {
    const int count = pair_count(tables->law);
    float row[HAPTABLE_PAIR_CONTROLS][9];
    rows_between(tables, first, second, row);
    for (int k = 0; k < count; ++k) q[k] = mat_bilinear(row[k], v, w);
    rows_between(tables, second, first, row);
    for (int l = 0; l < count; ++l) r[l] = mat_bilinear(row[l], w, v);
}
