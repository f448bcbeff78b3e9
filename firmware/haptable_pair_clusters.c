/* SPDX-License-Identifier: MIT
 *
 * x_kl = sum_i w_ki y_il,   y_il = sum_j A_ij v_jl
 * A_ij = s_i s_j step core_ij;   or y_il = s_i U_i t_l^T,   t_l = step core z_l,   z_l = sum_j v_jl s_j U_j^T
 *
 * What couples two places in clusters (a uniform block low rank form): near clusters have a block for each pair, far
 * ones a core between bases that each cluster has once for all the others. All columns l of a patch at once: so each
 * number of the tables is read once.
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
    haptable_pair_controls(tables, patch, control);
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

/* Numbers of a row of all columns, three each. */
#define WIDE (3 * HAPTABLE_PAIR_CONTROLS)

/* Two clusters, and the places of each that are asked for. */
struct two {
    const struct haptable_pair_model* tables;
    const struct loads* at;
    const struct loads* of;
    const float* weight; /* one column: of `of`'s controls; NULL: a column for each of them */
    int columns;
    int at_begin, at_end, of_begin, of_end;
    float v[HAPTABLE_PAIR_CLUSTER][HAPTABLE_PAIR_CONTROLS]; /* of the run of `of`, by columns that it loads */
    int loaded;                                             /* columns that the run loads */
    int column[HAPTABLE_PAIR_CONTROLS];                     /* which: times 3 */
    int is_transposed;                                      /* 1: `at` has the earlier cluster */
    const int8_t* core;
    float step;
};

/* v of a place of `of` */
static float column_of(const struct two* two, int j, int column) {
    float v = 0.0f;
    int c;
    if (!two->weight) return share_of(two->of, j, column);
    for (c = 0; c < pair_count(two->tables->law); ++c) v += two->weight[c] * share_of(two->of, j, c);
    return v;
}

/* The loads of the run of `of`, of the columns that have any there. */
static void load_run(struct two* two) {
    int l;
    int j;
    two->loaded = 0;
    for (l = 0; l < two->columns; ++l) {
        int any = 0;
        for (j = two->of_begin; j < two->of_end; ++j) {
            const float v = column_of(two, j, l);
            two->v[j - two->of_begin][two->loaded] = v;
            if (v != 0.0f) any = 1;
        }
        if (any) two->column[two->loaded++] = 3 * l;
    }
}

/* y += w core */
static inline void add_steps(float w, const int8_t core[9], int is_transposed, int column, float (*y)[WIDE]) {
    int a;
    for (a = 0; a < 3; ++a) {
        float* row = &y[a][column];
        row[0] += w * (float)core[is_transposed ? a : 3 * a];
        row[1] += w * (float)core[is_transposed ? 3 + a : 3 * a + 1];
        row[2] += w * (float)core[is_transposed ? 6 + a : 3 * a + 2];
    }
}

/* y_i += sum_j v_j s_i s_j step core_ij */
static void add_dense(const struct two* two, int is_twice, float (*y)[3][WIDE]) {
    const float* scale = two->tables->scale;
    int i;
    int j;
    int n;
    for (i = two->at_begin; i < two->at_end; ++i)
        for (j = two->of_begin; j < two->of_end; ++j) {
            const uint16_t k = two->at->place[i];
            const uint16_t l = two->of->place[j];
            const size_t row = (two->is_transposed ? l : k) % HAPTABLE_PAIR_CLUSTER;
            const size_t column = (two->is_transposed ? k : l) % HAPTABLE_PAIR_CLUSTER;
            const int8_t* core = two->core + (is_twice ? 18u : 9u) * (HAPTABLE_PAIR_CLUSTER * row + column);
            for (n = 0; n < two->loaded; ++n) {
                const float w = two->v[j - two->of_begin][n] * scale[k] * scale[l] * two->step;
                if (w == 0.0f) continue;
                add_steps(w, core, two->is_transposed, two->column[n], y[i - two->at_begin]);
                if (is_twice)
                    add_steps(w * (1.0f / 254.0f), core + 9, two->is_transposed, two->column[n], y[i - two->at_begin]);
            }
        }
}

/* z = sum_j v_j s_j U_j^T over a run */
static void project(const struct two* two, int rank, float (*z)[WIDE]) {
    const struct haptable_pair_model* tables = two->tables;
    int j;
    int n;
    int r;
    for (r = 0; r < rank; ++r)
        for (n = 0; n < two->loaded; ++n) vec_zero(&z[r][3 * n]);
    for (j = two->of_begin; j < two->of_end; ++j) {
        const uint16_t l = two->of->place[j];
        const int16_t(*u)[3] = &tables->basis[(size_t)l * tables->rank];
        for (n = 0; n < two->loaded; ++n) {
            const float w = two->v[j - two->of_begin][n] * tables->scale[l];
            if (w == 0.0f) continue;
            for (r = 0; r < rank; ++r) {
                z[r][3 * n] += w * (float)u[r][0];
                z[r][3 * n + 1] += w * (float)u[r][1];
                z[r][3 * n + 2] += w * (float)u[r][2];
            }
        }
    }
}

/* y_i += s_i U_i t^T, t = step core z: a row of t at a time */
static void add_low_rank(const struct two* two, int rank, float (*z)[WIDE], float (*y)[3][WIDE]) {
    const struct haptable_pair_model* tables = two->tables;
    int r;
    int b;
    int i;
    int a;
    int n;
    for (r = 0; r < rank; ++r) {
        float t[WIDE];
        for (n = 0; n < two->loaded; ++n) vec_zero(&t[3 * n]);
        for (b = 0; b < rank; ++b) {
            const float by = two->step * (float)two->core[two->is_transposed ? rank * b + r : rank * r + b];
            for (n = 0; n < two->loaded; ++n) vec_add_scaled(by, &z[b][3 * n], &t[3 * n]);
        }
        for (i = two->at_begin; i < two->at_end; ++i) {
            const uint16_t k = two->at->place[i];
            const int16_t* u = tables->basis[(size_t)k * tables->rank + (size_t)r];
            for (a = 0; a < 3; ++a) {
                const float by = tables->scale[k] * (float)u[a];
                float* row = y[i - two->at_begin][a];
                for (n = 0; n < two->loaded; ++n) vec_add_scaled(by, &t[3 * n], &row[two->column[n]]);
            }
        }
    }
}

/* Between a run of each: y += A v. */
static void add_core(struct two* two, float (*y)[3][WIDE]) {
    const struct haptable_pair_model* tables = two->tables;
    const uint32_t at = cluster_of(two->at->place[two->at_begin]);
    const uint32_t of = cluster_of(two->of->place[two->of_begin]);
    const uint32_t core = at >= of ? at * (at + 1u) / 2u + of : of * (of + 1u) / 2u + at;
    const int form = tables->core_form[core];
    if (form == 0) return;
    two->is_transposed = at < of;
    two->core = &tables->core[tables->core_begin[core]];
    two->step = tables->core_step[core];
    load_run(two);
    if (form >= HAPTABLE_PAIR_DENSE) {
        add_dense(two, form == HAPTABLE_PAIR_TWICE, y);
    } else {
        float z[HAPTABLE_PAIR_RANK][WIDE];
        project(two, form, z);
        add_low_rank(two, form, z, y);
    }
}

/* x_kl += sum_i w_ki y_il over a run */
static void gather_run(const struct two* two, float (*y)[3][WIDE], float (*x)[9]) {
    const int count = pair_count(two->tables->law);
    int i;
    int k;
    int l;
    for (k = 0; k < count; ++k, x += two->columns)
        for (i = two->at_begin; i < two->at_end; ++i) {
            const float share = share_of(two->at, i, k);
            if (share == 0.0f) continue;
            for (l = 0; l < two->columns; ++l) {
                float(*from)[WIDE] = y[i - two->at_begin];
                vec_add_scaled(share, &from[0][3 * l], &x[l][0]);
                vec_add_scaled(share, &from[1][3 * l], &x[l][3]);
                vec_add_scaled(share, &from[2][3 * l], &x[l][6]);
            }
        }
}

/* x: rows of so many columns for each control of `first`. */
static void couple(const struct haptable_pair_model* tables, uint16_t first, uint16_t second, const float weight[],
                   float (*x)[9]) {
    const int count = pair_count(tables->law);
    struct loads at;
    struct loads of;
    struct two two;
    int i;
    int a;
    see_loads(tables, first, &at);
    see_loads(tables, second, &of);
    two.tables = tables;
    two.at = &at;
    two.of = &of;
    two.weight = weight;
    two.columns = weight ? 1 : count;
    for (i = 0; i < count * two.columns; ++i)
        for (a = 0; a < 9; ++a) x[i][a] = 0.0f;
    for (two.at_begin = 0; two.at_begin < at.count; two.at_begin = two.at_end) {
        float y[HAPTABLE_PAIR_CLUSTER][3][WIDE];
        two.at_end = end_of_run(&at, two.at_begin);
        for (i = 0; i < two.at_end - two.at_begin; ++i)
            for (a = 0; a < 3 * WIDE; ++a) y[i][a / WIDE][a % WIDE] = 0.0f;
        for (two.of_begin = 0; two.of_begin < of.count; two.of_begin = two.of_end) {
            two.of_end = end_of_run(&of, two.of_begin);
            add_core(&two, y);
        }
        gather_run(&two, y, x);
    }
}

void haptable_pair_cross_clusters(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]) {
    couple(view->tables, patch, view->place.patch, view->place.weight, x);
}

void haptable_pair_blocks_clusters(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                   float (*block)[9]) {
    couple(tables, first, second, 0, block);
}
