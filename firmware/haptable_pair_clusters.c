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

/* So many clusters of the loaded place are kept at once; more of them take another round. */
#define RUNS 16

/* The places of a patch that are of one cluster, and what they load of its basis. */
struct run {
    uint32_t cluster;
    int begin;
    int end;
    int is_projected;
    float z[HAPTABLE_PAIR_RANK][3]; /* sum_j v_j s_j U_j^T, where a core of low rank asked for it */
};

/* A place that is loaded: v_j s_j of what it loads. */
struct loaded {
    const struct haptable_pair_model* tables;
    const struct loads* of;
    float v[HAPTABLE_PAIR_PLACES];
};

/* A round of its clusters. */
struct round {
    const struct loaded* from;
    int runs;
    struct run run[RUNS];
};

/* By the weights of the controls. */
static void load(const struct haptable_pair_model* tables, const struct loads* of, const float weight[],
                 struct loaded* to) {
    const int count = pair_count(tables->law);
    const int is_own = of->place == of->own;
    to->tables = tables;
    to->of = of;
    for (int j = 0; j < of->count; ++j) {
        float sum = is_own ? weight[of->control[j]] : 0.0f;
        for (int c = 0; c < count && !is_own; ++c) sum += weight[c] * share_of(of, j, c);
        to->v[j] = sum * tables->scale[of->place[j]];
    }
}

/* The next clusters that are loaded, from place j on. Returns the place that follows them. */
static int find_runs(const struct loaded* from, int j, struct round* to) {
    to->from = from;
    to->runs = 0;
    while (to->runs < RUNS && j < from->of->count) {
        struct run* run = &to->run[to->runs];
        int loads = 0;
        run->cluster = cluster_of(from->of->place[j]);
        run->begin = j;
        run->end = end_of_run(from->of, j);
        run->is_projected = 0;
        for (; j < run->end; ++j) loads |= from->v[j] != 0.0f;
        if (loads) ++to->runs;
    }
    return j;
}

/* z = sum_j v_j U_j^T */
static void project(const struct haptable_pair_model* tables, int rank, const uint16_t place[], const float v[],
                    int places, float (*z)[3]) {
    for (int r = 0; r < HAPTABLE_PAIR_RANK; ++r) vec_zero(z[r]);
    for (int j = 0; j < places; ++j) {
        const int16_t(*u)[3] = &tables->basis[(size_t)place[j] * tables->rank];
        for (int r = 0; r < rank; ++r) {
            z[r][0] += v[j] * (float)u[r][0];
            z[r][1] += v[j] * (float)u[r][1];
            z[r][2] += v[j] * (float)u[r][2];
        }
    }
}

/* A core of two clusters as the one of them has it that has place `at`. */
struct core {
    uint32_t begin;
    int form;
    float step;
    int is_transposed; /* 1: the other one has the rows of blocks */
};

static inline struct core core_of(const struct haptable_pair_model* tables, uint32_t at, uint32_t of) {
    const uint32_t pair = at >= of ? at * (at + 1u) / 2u + of : of * (of + 1u) / 2u + at;
    const struct core core = {tables->core_begin[pair], tables->core_form[pair], tables->core_step[pair], at < of};
    return core;
}

/* x += w times the steps of the block of places k and l of a dense core. */
static inline void add_steps(const struct haptable_pair_model* tables, const struct core* core, uint32_t k, uint32_t l,
                             float w, float x[9]) {
    const uint32_t at = core->is_transposed ? HAPTABLE_PAIR_CLUSTER * l + k : HAPTABLE_PAIR_CLUSTER * k + l;
    if (core->form == HAPTABLE_PAIR_FINE) {
        const int16_t* steps = tables->fine[core->begin + at];
        for (int a = 0; a < 9; ++a) x[a] += w * (float)steps[a];
    } else {
        const int8_t* steps = &tables->core[core->begin + 9u * at];
        for (int a = 0; a < 9; ++a) x[a] += w * (float)steps[a];
    }
}

/* The sum of `by` times the steps of such a block. */
static inline float pull_of(const struct haptable_pair_model* tables, const struct core* core, uint32_t k, uint32_t l,
                            const float by[9]) {
    float x[9] = {0.0f};
    add_steps(tables, core, k, l, 1.0f, x);
    for (int a = 0; a < 9; ++a) x[a] *= by[a];
    return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7])) + x[8];
}

/* y_i += sum_j v_j s_j step core_ij of the places of a run. */
static void add_dense(const struct loaded* from, const struct run* run, const struct core* core, const uint16_t place[],
                      int places, float (*y)[9]) {
    for (int i = 0; i < places; ++i) {
        float sum[9] = {0.0f}; /* in registers */
        for (int j = run->begin; j < run->end; ++j)
            add_steps(from->tables, core, place[i] % HAPTABLE_PAIR_CLUSTER, from->of->place[j] % HAPTABLE_PAIR_CLUSTER,
                      from->v[j], sum);
        if (core->is_transposed) mat_transpose(sum);
        mat_add(core->step, sum, y[i]);
    }
}

/* t += step core z */
static void add_low_rank(const struct loaded* from, struct run* run, const struct core* core, float (*t)[3]) {
    const struct haptable_pair_model* tables = from->tables;
    const int rank = core->form;
    const int row = core->is_transposed ? 1 : rank;
    const int column = core->is_transposed ? rank : 1;
    if (!run->is_projected)
        project(tables, tables->rank, &from->of->place[run->begin], &from->v[run->begin], run->end - run->begin,
                run->z);
    run->is_projected = 1;
    for (int r = 0; r < rank; ++r) {
        const int8_t* steps = &tables->core[core->begin + (uint32_t)(row * r)];
        float sum[3] = {0.0f, 0.0f, 0.0f};
        for (int b = 0; b < rank; ++b) vec_add_scaled((float)steps[column * b], run->z[b], sum);
        vec_add_scaled(core->step, sum, t[r]);
    }
}

/* What the loaded place's clusters of low rank do to another cluster, added to t. Returns how many vectors t has. */
static int sum_low_ranks(struct round* round, uint32_t at, float (*t)[3]) {
    int rank = 0;
    for (int r = 0; r < round->runs; ++r) {
        const struct core core = core_of(round->from->tables, at, round->run[r].cluster);
        if (core.form >= HAPTABLE_PAIR_DENSE) continue;
        if (rank < core.form) rank = core.form;
        add_low_rank(round->from, &round->run[r], &core, t);
    }
    return rank;
}

/* y_i += sum_j A_ij v_j of places of one cluster, without s_i. */
static void respond(struct round* round, const uint16_t place[], int places, float (*y)[9]) {
    const struct haptable_pair_model* tables = round->from->tables;
    const uint32_t at = cluster_of(place[0]);
    float t[HAPTABLE_PAIR_RANK][3] = {{0.0f}};
    const int rank = sum_low_ranks(round, at, t);
    for (int r = 0; r < round->runs; ++r) {
        const struct core core = core_of(tables, at, round->run[r].cluster);
        if (core.form >= HAPTABLE_PAIR_DENSE) add_dense(round->from, &round->run[r], &core, place, places, y);
    }
    for (int i = 0; i < places; ++i)
        for (int r = 0; r < rank; ++r) {
            const int16_t* u = tables->basis[(size_t)place[i] * tables->rank + (size_t)r];
            for (int a = 0; a < 3; ++a) vec_add_scaled((float)u[a], t[r], &y[i][3 * a]);
        }
}

/* A row for each control of `at`, each `next` after the one before. */
static void add_rows(struct round* round, const struct loads* at, float (*x)[9], int next) {
    const struct haptable_pair_model* tables = round->from->tables;
    const int count = pair_count(tables->law);
    int end;
    for (int begin = 0; begin < at->count; begin = end) {
        float y[HAPTABLE_PAIR_CLUSTER][9] = {{0.0f}};
        end = end_of_run(at, begin);
        respond(round, &at->place[begin], end - begin, y);
        for (int i = begin; i < end; ++i)
            for (int k = 0; k < count; ++k) {
                const float w = tables->scale[at->place[i]] * share_of(at, i, k);
                if (w != 0.0f) mat_add(w, y[i - begin], x[k * next]);
            }
    }
}

/* x: a row for each control of `at`, each `next` after the one before. */
static void couple(const struct haptable_pair_model* tables, const struct loads* at, const struct loads* of,
                   const float weight[], float (*x)[9], int next) {
    const int count = pair_count(tables->law);
    struct loaded from = {0, 0, {0.0f}};
    struct round round;
    int j = 0;
    load(tables, of, weight, &from);
    for (int k = 0; k < count; ++k)
        for (int a = 0; a < 9; ++a) x[k * next][a] = 0.0f;
    while (j < of->count) {
        j = find_runs(&from, j, &round);
        add_rows(&round, at, x, next);
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

/* Of dense cores: x_0 += sum_ij v_i v_j A_ij, x_1 of those that stand transposed. Returns 1 where others are left. */
static int add_blocks(const struct loaded* at, const struct loaded* of, float x[2][9]) {
    const struct haptable_pair_model* tables = at->tables;
    int is_left = 0;
    for (int i = 0; i < at->of->count; ++i) {
        const uint32_t k = at->of->place[i];
        if (at->v[i] == 0.0f) continue;
        for (int j = 0; j < of->of->count; ++j) {
            const uint32_t l = of->of->place[j];
            const struct core core = core_of(tables, cluster_of((uint16_t)k), cluster_of((uint16_t)l));
            if (core.form < HAPTABLE_PAIR_DENSE)
                is_left = 1;
            else
                add_steps(tables, &core, k % HAPTABLE_PAIR_CLUSTER, l % HAPTABLE_PAIR_CLUSTER,
                          at->v[i] * of->v[j] * core.step, x[core.is_transposed]);
        }
    }
    return is_left;
}

/* The same of cores of low rank. */
static void add_cores(const struct loaded* at, struct round* of, float x[9]) {
    int end;
    for (int begin = 0; begin < at->of->count; begin = end) {
        const uint16_t* first = &at->of->place[begin];
        float t[HAPTABLE_PAIR_RANK][3] = {{0.0f}};
        float z[HAPTABLE_PAIR_RANK][3];
        end = end_of_run(at->of, begin);
        const int rank = sum_low_ranks(of, cluster_of(*first), t);
        project(at->tables, rank, first, &at->v[begin], end - begin, z);
        for (int r = 0; r < rank; ++r)
            for (int a = 0; a < 3; ++a) vec_add_scaled(z[r][a], t[r], &x[3 * a]);
    }
}

void haptable_pair_couple_clusters(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                   const struct haptable_pair_place* second, float x[9]) {
    struct loads loads[2];
    struct loaded at;
    struct loaded of;
    struct round round;
    float sum[2][9] = {{0.0f}};
    see_loads(tables, first->patch, &loads[0]);
    see_loads(tables, second->patch, &loads[1]);
    load(tables, &loads[0], first->weight, &at);
    load(tables, &loads[1], second->weight, &of);
    if (add_blocks(&at, &of, sum))
        for (int j = 0; j < loads[1].count;) {
            j = find_runs(&of, j, &round);
            add_cores(&at, &round, sum[0]);
        }
    mat_copy(sum[0], x);
    mat_add_transposed(1.0f, sum[1], x);
}

/* Of dense cores: p_i += sum_j v_j v . A_ij w, p_j += sum_i v_i v . A_ij w. Returns 1 where others are left. */
static int add_block_pulls(const struct loaded* at, const struct loaded* of, const float v[3], const float w[3],
                           float p_at[], float p_of[]) {
    const struct haptable_pair_model* tables = at->tables;
    float by[2][9]; /* v w^T, and transposed: no branch on the order of two clusters */
    int is_left = 0;
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) by[0][3 * a + b] = by[1][3 * b + a] = v[a] * w[b];
    for (int i = 0; i < at->of->count; ++i)
        for (int j = 0; j < of->of->count; ++j) {
            const uint32_t k = at->of->place[i];
            const uint32_t l = of->of->place[j];
            const struct core core = core_of(tables, cluster_of((uint16_t)k), cluster_of((uint16_t)l));
            float pull = 0.0f;
            if (core.form < HAPTABLE_PAIR_DENSE) {
                is_left = 1;
                continue;
            }
            pull = core.step *
                   pull_of(tables, &core, k % HAPTABLE_PAIR_CLUSTER, l % HAPTABLE_PAIR_CLUSTER, by[core.is_transposed]);
            p_at[i] += of->v[j] * pull;
            p_of[j] += at->v[i] * pull;
        }
    return is_left;
}

/* The same of cores of low rank, of the one side: p_i += sum_j v_j v . A_ij w */
static void add_core_pulls(const struct loaded* at, struct round* of, const float v[3], const float w[3], float p[]) {
    const struct haptable_pair_model* tables = at->tables;
    int end;
    for (int begin = 0; begin < at->of->count; begin = end) {
        float t[HAPTABLE_PAIR_RANK][3] = {{0.0f}};
        const int rank = sum_low_ranks(of, cluster_of(at->of->place[begin]), t);
        end = end_of_run(at->of, begin);
        for (int r = 0; r < rank; ++r) {
            const float along = vec_dot(t[r], w);
            for (int i = begin; i < end; ++i) {
                const int16_t* u = tables->basis[(size_t)at->of->place[i] * tables->rank + (size_t)r];
                p[i] += along * (v[0] * (float)u[0] + v[1] * (float)u[1] + v[2] * (float)u[2]);
            }
        }
    }
}

/* q_k of what places load of each control. */
static void gather(const struct loaded* at, const float p[], float q[]) {
    const int count = pair_count(at->tables->law);
    for (int k = 0; k < count; ++k) {
        q[k] = 0.0f;
        for (int i = 0; i < at->of->count; ++i)
            q[k] += at->tables->scale[at->of->place[i]] * share_of(at->of, i, k) * p[i];
    }
}

void haptable_pair_pull_clusters(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                 const struct haptable_pair_place* second, const float v[3], const float w[3],
                                 float q[HAPTABLE_PAIR_CONTROLS], float r[HAPTABLE_PAIR_CONTROLS]) {
    struct loads loads[2];
    struct loaded at = {0, 0, {0.0f}};
    struct loaded of = {0, 0, {0.0f}};
    struct round round;
    float p[2][HAPTABLE_PAIR_PLACES] = {{0.0f}};
    see_loads(tables, first->patch, &loads[0]);
    see_loads(tables, second->patch, &loads[1]);
    load(tables, &loads[0], first->weight, &at);
    load(tables, &loads[1], second->weight, &of);
    if (add_block_pulls(&at, &of, v, w, p[0], p[1])) {
        for (int j = 0; j < loads[1].count;) {
            j = find_runs(&of, j, &round);
            add_core_pulls(&at, &round, v, w, p[0]);
        }
        for (int i = 0; i < loads[0].count;) {
            i = find_runs(&at, i, &round);
            add_core_pulls(&of, &round, w, v, p[1]);
        }
    }
    gather(&at, p[0], q);
    gather(&of, p[1], r);
}
