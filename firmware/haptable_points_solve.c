/* SPDX-License-Identifier: MIT
 *
 * C_TT f_T = u_T with every f_i . n_i <= 0, and n_i . (u_i - sum_j C_ij f_j) >= 0 of each point out of T
 *
 * Linear complementarity along the outward normals n, by an active set that begins with the last tick's. C = L L^T is
 * factored anew for each set: a tick takes one in most ticks.
 */
#include "haptable_pair_terms.h"
#include "haptable_points.h"
#include "haptable_side.h"
#include "haptable_surface.h"

/* A pivot is at least this part of C's own diagonal: points that load one place stay apart. */
#define LEAST_PIVOT 1e-4f

/* A square of L's is at most this part of C's own diagonal, as a definite C's is, to rounding. */
#define ROOM 2.0f

/* ---- C ----------------------------------------------------------------------------------------------------------- */

/* C(i, j), i <= j, above the diagonal and on it; L of T, in its order, below; then 1 / L_rr. */
struct system {
    float* a;
    float* inverse;
    uint32_t width;
};

static struct system system_of(const struct haptable_points_model* of, void* state) {
    struct system to;
    to.width = 3u * of->count;
    to.a = haptable_points_system(of, state);
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

/* Own blocks of the points that are new, or have moved; L is of no point then. */
static void assemble(const struct haptable_points_model* of, void* state) {
    const struct system in = system_of(of, state);
    const struct haptable_servo* servo = haptable_points_servos(of, state);
    struct haptable_point* point = haptable_points_in(of, state);
    for (uint32_t i = 0; i < of->count; ++i) {
        struct haptable_point* at = &point[i];
        if (!at->is_inside || at->is_known) continue;
        of->pair->law->own(of->pair->model, &at->at, servo[i].finger_m, &at->own);
        haptable_pair_place_of(of->pair->law, &at->at, &at->place);
        put_own(&in, i, at->own.a);
        at->is_known = 1;
        at->coupled = 0;
        haptable_points_of(of, state)->count = 0;
        for (uint32_t j = 0; j < of->count; ++j) point[j].coupled &= ~(1u << i);
    }
}

/* What couples the points of T to all others. Two that are out of T need no block. */
static void couple(const struct haptable_points_model* of, void* state) {
    const struct system in = system_of(of, state);
    struct haptable_point* point = haptable_points_in(of, state);
    for (uint32_t j = 1; j < of->count; ++j)
        for (uint32_t i = 0; i < j && point[j].is_inside; ++i) {
            float x[9];
            if (!point[i].is_inside || !(point[i].presses || point[j].presses)) continue;
            if (point[j].coupled >> i & 1u) continue;
            of->couple(of->pair, &point[i].place, &point[j].place, x);
            put_cross(&in, i, j, x);
            point[j].coupled |= 1u << i;
        }
}

/* Above the diagonal and on it, row by row, behind the system. */
static void copy_upper(const struct haptable_points_model* of, void* state, int is_back) {
    const struct system in = system_of(of, state);
    float* kept = in.inverse + in.width;
    for (uint32_t r = 0; r < in.width; ++r)
        for (uint32_t c = r; c < in.width; ++c, ++kept) {
            if (is_back)
                *entry(&in, r, c) = *kept;
            else
                *kept = *entry(&in, r, c);
        }
}

void haptable_points_keep(const struct haptable_points_model* of, void* state) { copy_upper(of, state, 0); }

void haptable_points_take_back(const struct haptable_points_model* of, void* state) {
    copy_upper(of, state, 1);
    haptable_points_of(of, state)->count = 0;
}

void haptable_points_lowered(const struct haptable_points_model* of, void* state, uint32_t i, float lowered_m[3]) {
    const struct system in = system_of(of, state);
    const struct haptable_point* point = haptable_points_in(of, state);
    vec_zero(lowered_m);
    for (uint32_t j = 0; j < of->count; ++j)
        if (point[j].presses) add_product(&in, i, j, point[j].load_n, lowered_m);
}

/* ---- the factor -------------------------------------------------------------------------------------------------- */

/* Points of T, in their order. Returns with how many of them L begins already. */
static uint32_t put_order(const struct haptable_points_model* of, void* state) {
    const struct haptable_point* point = haptable_points_in(of, state);
    struct haptable_points* all = haptable_points_of(of, state);
    const uint32_t count = all->count;
    uint32_t same = 0;
    all->count = 0;
    for (uint32_t i = 0; i < of->count; ++i) {
        if (!point[i].presses) continue;
        if (same == all->count && same < count && all->order[same] == i) ++same;
        all->order[all->count++] = (uint16_t)i;
    }
    return same;
}

/* C_TT = L L^T, by T's order, whose first points L has already; column by column, so that no sum waits for another. Of
 * points that load nearly one place C may be indefinite, by the error of its tables and by rounding: an entry for which
 * there is no room, as in a definite C there is, is left out. */
static void factor(const struct system* in, const struct haptable_points* all, uint32_t has) {
    const uint32_t rows = 3u * all->count;
    uint16_t at[3 * HAPTABLE_POINTS] = {0u}; /* C's row of each of L's */
    for (uint32_t r = 0; r < rows; ++r) at[r] = (uint16_t)(3u * all->order[r / 3u] + r % 3u);
    for (uint32_t c = 0; c < rows; ++c) {
        const float* column = &in->a[c * in->width];
        const uint32_t first = c < 3u * has ? 3u * has : c + 1u;
        if (c >= 3u * has) {
            const float own = *entry(in, at[c], at[c]);
            float pivot = own - haptable_points_dot(column, column, c);
            if (!(pivot > LEAST_PIVOT * own)) pivot = LEAST_PIVOT * own;
            in->inverse[c] = vec_inverse_root(pivot);
        }
        for (uint32_t r = first; r < rows; ++r) {
            float* row = &in->a[r * in->width];
            row[c] = (*entry(in, at[c], at[r]) - haptable_points_dot(row, column, c)) * in->inverse[c];
            if (row[c] * row[c] > ROOM * *entry(in, at[r], at[r])) row[c] = 0.0f;
        }
    }
}

void haptable_points_factor(const struct haptable_points_model* of, void* state) {
    const struct system in = system_of(of, state);
    struct haptable_points* all = haptable_points_of(of, state);
    const uint32_t has = put_order(of, state);
    factor(&in, all, has);
    ++all->sets;
}

static void forward(const struct system* in, uint32_t rows, float x[]) {
    for (uint32_t r = 0; r < rows; ++r)
        x[r] = (x[r] - haptable_points_dot(&in->a[r * in->width], x, r)) * in->inverse[r];
}

static void solve(const struct system* in, uint32_t rows, float x[]) {
    forward(in, rows, x);
    for (uint32_t r = rows; r-- > 0u;) {
        const float* row = &in->a[r * in->width];
        x[r] *= in->inverse[r];
        for (uint32_t c = 0; c < r; ++c) x[c] -= row[c] * x[r];
    }
}

void haptable_points_forward(const struct haptable_points_model* of, void* state, float x[]) {
    const struct system in = system_of(of, state);
    forward(&in, 3u * haptable_points_of(of, state)->count, x);
}

/* ---- what a point's servo has found ------------------------------------------------------------------------------ */

void haptable_points_take_model(const struct haptable_model* from, haptable_force_fn* force, haptable_finish_fn* brake,
                                struct haptable_model* to) {
    *to = *from;
    to->god_object = haptable_god_object_nearest;
    to->force = force;
    to->energy = 0;
    to->frictionless = 0;
    if (to->passivity) to->passivity = brake;
}

void haptable_point_forget(const struct haptable_points_model* of, void* state, uint32_t i) {
    struct haptable_point* point = &haptable_points_in(of, state)[i];
    point->is_inside = point->presses = point->is_known = 0;
    point->raised_m = 0.0f;
    point->unfelt = 0;
    vec_zero(point->sunk_m);
    vec_zero(point->load_n);
}

void haptable_point_see(const struct haptable_points_model* of, void* state, uint32_t i) {
    const struct haptable_servo* servo = &haptable_points_servos(of, state)[i];
    const struct haptable_contact* nearest = &servo->contact;
    struct haptable_point* point = &haptable_points_in(of, state)[i];
    const int is_inside = nearest->patch != HAPTABLE_NONE;
    const int goes_on = is_inside && point->is_inside && point->met == servo->counters.contacts;
    if (!goes_on) haptable_point_forget(of, state, i);
    if (!is_inside) return;
    haptable_side_outward(of->pair->model, nearest, point->normal);
    vec_scale(haptable_side_inverse_length(point->normal), point->normal);
    if (goes_on && (of->settle || gap2(nearest->god_object_m, point->at.god_object_m) == 0.0f)) return;
    point->is_inside = 1;
    point->at = *nearest;
    point->is_known = 0;
}

/* ---- who touches ------------------------------------------------------------------------------------------------- */

/* u, from where the surface was when the contact began, or began anew. */
static void dent_of(const struct haptable_points_model* of, void* state, uint32_t i, float u[3]) {
    const struct haptable_point* point = &haptable_points_in(of, state)[i];
    vec_sub(haptable_points_servos(of, state)[i].finger_m, point->at.god_object_m, u);
    vec_add_scaled(point->raised_m, point->normal, u);
    vec_add(u, point->sunk_m, u);
}

static void put_loads(const struct haptable_points_model* of, void* state) {
    const struct system in = system_of(of, state);
    struct haptable_point* point = haptable_points_in(of, state);
    const struct haptable_points* all = haptable_points_of(of, state);
    float x[3 * HAPTABLE_POINTS];
    couple(of, state);
    haptable_points_factor(of, state);
    for (uint32_t a = 0; a < all->count; ++a) dent_of(of, state, all->order[a], &x[3u * a]);
    solve(&in, 3u * all->count, x);
    for (uint32_t a = 0; a < all->count; ++a) vec_copy(&x[3u * a], point[all->order[a]].load_n);
}

/* Newtons squared: a larger load, or one that is not a number, is none. */
#define LOAD_LIMIT2 1e30f

static int has_loads(const struct haptable_points_model* of, void* state) {
    const struct haptable_points* all = haptable_points_of(of, state);
    for (uint32_t a = 0; a < all->count; ++a)
        if (!(vec_length2(haptable_points_in(of, state)[all->order[a]].load_n) <= LOAD_LIMIT2)) return 0;
    return 1;
}

/* Takes out of T the points whose load would pull the surface. */
static int drop(const struct haptable_points_model* of, void* state) {
    struct haptable_point* point = haptable_points_in(of, state);
    int dropped = 0;
    for (uint32_t i = 0; i < of->count; ++i) {
        if (!point[i].presses || !(vec_dot(point[i].load_n, point[i].normal) > 0.0f)) continue;
        point[i].presses = 0;
        vec_zero(point[i].load_n);
        ++dropped;
    }
    return dropped;
}

static void put_energy(const struct haptable_points_model* of, void* state) {
    const struct haptable_point* point = haptable_points_in(of, state);
    struct haptable_points* all = haptable_points_of(of, state);
    all->energy_j = 0.0f;
    for (uint32_t i = 0; i < of->count; ++i) {
        float u[3];
        if (!point[i].presses) continue;
        dent_of(of, state, i, u);
        all->energy_j += 0.5f * vec_dot(u, point[i].load_n);
    }
}

void haptable_points_press_by_one(const struct haptable_points_model* of, void* state) {
    struct haptable_point* point = haptable_points_in(of, state);
    uint32_t deepest = of->count;
    float least_m = 0.0f;
    for (uint32_t i = 0; i < of->count; ++i) {
        float u[3];
        if (!point[i].presses) continue;
        dent_of(of, state, i, u);
        if (deepest == of->count || vec_dot(u, point[i].normal) < least_m) {
            deepest = i;
            least_m = vec_dot(u, point[i].normal);
        }
        point[i].presses = 0;
        vec_zero(point[i].load_n);
    }
    if (deepest < of->count) point[deepest].presses = 1;
    put_loads(of, state);
    (void)drop(of, state);
    put_energy(of, state);
}

/* How far a point out of T is outside of the surface as the others dent it; u: from there as nobody dents it. */
static float outside_of(const struct haptable_points_model* of, void* state, uint32_t i, float u[3]) {
    float lowered_m[3];
    haptable_points_lowered(of, state, i, lowered_m);
    vec_sub(u, lowered_m, u);
    return vec_dot(u, haptable_points_in(of, state)[i].normal);
}

/* Takes points into T that the dented surface does not leave behind: all of them, or the one that is deepest. */
static int add(const struct haptable_points_model* of, void* state, int takes_all) {
    struct haptable_point* point = haptable_points_in(of, state);
    uint8_t adds[HAPTABLE_POINTS];
    float least = -of->pair->model->tolerance_m;
    uint32_t deepest = of->count;
    int added = 0;
    for (uint32_t i = 0; i < of->count; ++i) {
        float u[3];
        adds[i] = 0;
        if (!point[i].is_inside || point[i].presses) continue;
        dent_of(of, state, i, u);
        const float gap = outside_of(of, state, i, u);
        if (gap < -of->pair->model->tolerance_m) adds[i] = (uint8_t)takes_all;
        if (gap >= least) continue;
        least = gap;
        deepest = i;
    }
    if (deepest < of->count) adds[deepest] = 1;
    for (uint32_t i = 0; i < of->count; ++i) {
        if (!adds[i]) continue;
        point[i].presses = 1;
        ++added;
    }
    return added;
}

/* Of a contact that begins where the others have raised the surface, and of one that gives no force. Returns for how
 * many it has changed. With settle a tick goes by the loads of the last one: E only falls. */
static int put_raised(const struct haptable_points_model* of, void* state) {
    const struct haptable_servo* servo = haptable_points_servos(of, state);
    int fallen = 0;
    for (uint32_t i = 0; i < of->count; ++i) {
        struct haptable_point* at = &haptable_points_in(of, state)[i];
        const int is_new = at->is_inside && at->met != servo[i].counters.contacts;
        float moved_m[3];
        if (!at->is_inside || (!is_new && (at->presses || !(at->raised_m > 0.0f)))) continue;
        haptable_points_lowered(of, state, i, moved_m);
        const float raised_m = vec_dot(moved_m, at->normal);
        at->met = servo[i].counters.contacts;
        if (!is_new && !(raised_m < at->raised_m)) continue;
        at->raised_m = raised_m > 0.0f ? raised_m : 0.0f;
        ++fallen;
    }
    return fallen;
}

float haptable_point_depth(const struct haptable_points_model* of, void* state, uint32_t i) {
    const struct haptable_servo* servo = &haptable_points_servos(of, state)[i];
    float u[3];
    vec_sub(servo->finger_m, servo->contact.god_object_m, u);
    return -outside_of(of, state, i, u) - haptable_points_in(of, state)[i].raised_m;
}

void haptable_point_sink(const struct haptable_points_model* of, void* state, uint32_t i) {
    struct haptable_point* point = &haptable_points_in(of, state)[i];
    if (point->presses) {
        point->unfelt = 0;
        return;
    }
    const float depth_m = haptable_point_depth(of, state, i);
    if (vec_length2(point->sunk_m) == 0.0f) {
        point->unfelt = depth_m > of->pair->model->tolerance_m ? (uint8_t)(point->unfelt + 1u) : 0;
        if (point->unfelt < HAPTABLE_POINTS_UNFELT) return;
        point->unfelt = 0;
    }
    point->at = haptable_points_servos(of, state)[i].contact;
    point->is_known = 0;
    vec_zero(point->sunk_m);
    vec_add_scaled(depth_m > 0.0f ? depth_m : 0.0f, point->normal, point->sunk_m);
}

int haptable_points_solve(const struct haptable_points_model* of, void* state, int most_sets) {
    struct haptable_points* all = haptable_points_of(of, state);
    int goes_on = 1;
    assemble(of, state);
    couple(of, state);
    (void)put_raised(of, state);
    for (int set = 0; goes_on && set < most_sets; ++set) {
        put_loads(of, state);
        if (!has_loads(of, state)) {
            haptable_points_press_by_one(of, state);
            return 1;
        }
        if (of->settle && all->sets == 1u) {
            put_energy(of, state);
            all->paid_j = all->energy_j;
        }
        goes_on = drop(of, state);
        if (goes_on || set >= most_sets / 2) continue;
        goes_on = add(of, state, all->count == 0);
        if (!goes_on && !of->settle) goes_on = put_raised(of, state) && add(of, state, 0);
    }
    put_energy(of, state);
    return !goes_on;
}
