/* SPDX-License-Identifier: MIT
 *
 * X of two places, N = A_1 - X A_2^-1 X^T, and the force and energy of the pair: haptable_pair_terms.h
 */
#include "haptable_pair_terms.h"

void haptable_pair_controls(const struct haptable_pair_model* tables, uint16_t patch, uint16_t control[]) {
    const struct haptable_model* model = tables->model;
    const int is_mask = tables->law->controls == HAPTABLE_PAIR_CONTROLS;
    int c;
    for (c = 0; c < 3; ++c) {
        const uint16_t vertex = model->patch[patch][c];
        control[c] = is_mask || vertex < model->free_count ? vertex : HAPTABLE_NONE;
        if (is_mask) control[3 + c] = (uint16_t)(model->vertex_count + model->compliance->patch_edge[patch][c]);
    }
}

void haptable_pair_inwards(const struct haptable_model* model, uint16_t patch, float u[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    vec_zero(u);
    vec_sub(u, normal, u);
}

/* ---- how two places are coupled ---------------------------------------------------------------------------------- */

/* What was gathered before of a patch, or room for it, then without its patch. */
static inline struct haptable_pair_rows* pair_rows(const struct haptable_pair_view* view, uint16_t patch) {
    struct haptable_pair_rows* rows = (struct haptable_pair_rows*)view->rows; /* of a view, which is no constant */
    if (rows[0].patch != patch) ++rows;
    return rows;
}

static inline const struct haptable_pair_rows* pair_gather(const struct haptable_pair_view* view, uint16_t patch) {
    struct haptable_pair_rows* rows = pair_rows(view, patch);
    if (rows->patch == patch) return rows;
    if (view->rows[0].patch == HAPTABLE_NONE) rows = (struct haptable_pair_rows*)view->rows;
    rows->patch = patch;
    view->tables->cross(view, patch, rows->x);
    return rows;
}

const struct haptable_pair_rows* haptable_pair_gather(const struct haptable_pair_view* view, uint16_t patch) {
    return pair_gather(view, patch);
}

void haptable_pair_look(const struct haptable_pair_model* tables, const struct haptable_contact* contact,
                        struct haptable_pair_view* view) {
    vec_copy(contact->god_object_m, view->at_m);
    view->place.patch = contact->patch;
    haptable_pair_controls(tables, contact->patch, view->place.control);
    pair_weights(pair_count(tables->law), contact->alpha, view->place.weight);
    pair_forget(view);
}

const struct haptable_pair_net* haptable_pair_net_of(const struct haptable_pair_model* tables,
                                                     struct haptable_pair_net* net, uint16_t first, uint16_t second) {
    if (net->patch[0] == first && net->patch[1] == second) return net;
    net->patch[0] = first;
    net->patch[1] = second;
    tables->blocks(tables, first, second, net->block);
    return net;
}

/* How near a place is to the other: 1 where they meet, <= 0 where they are meeting_m apart. */
static inline float pair_nearness(const struct haptable_pair_view* view, const float god_object_m[3]) {
    const float per_m = 1.0f / view->tables->meeting_m;
    return 1.0f - gap2(god_object_m, view->at_m) * per_m * per_m;
}

static inline float pair_share(const struct haptable_pair_view* view, const float god_object_m[3]) {
    const float near = pair_nearness(view, god_object_m);
    return near > 0.0f ? 1.0f - HAPTABLE_PAIR_MEETING * near * near : 1.0f;
}

/* X of a contact. */
static inline void pair_cross_at(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                                 float x[9]) {
    const struct haptable_pair_rows* rows = pair_gather(view, contact->patch);
    const float share = pair_share(view, contact->god_object_m);
    const int count = pair_count(view->tables->law);
    float weight[HAPTABLE_PAIR_CONTROLS];
    pair_weights(count, contact->alpha, weight);
    pair_sum(count, weight, rows->x[0], 9, x);
    if (share < 1.0f) mat_scale(share, x, x);
}

/* ---- the solve --------------------------------------------------------------------------------------------------- */

/* Both fingers' v, the first's place being given by its own terms and X. */
struct pair_solved {
    struct sym_factored n;
    float v[3];     /* of the first */
    float other[3]; /* of the second */
    float t[3];
    float energy_j; /* 1/2 t . v_1: of both, less what the second stores alone */
};

/* How much is left of each finger's compliance by itself, at the least: the mean of A_1^-1 N, which is that of
 * A_2^-1 N_2 too. */
#define LEAST_OWN 0.015625f

/* Places that load one node alone, next to fixed ones, load it alike however far apart they are, and N is nothing.
 * Takes the share of X that leaves LEAST_OWN of it: 1, or less. It is of both fingers alike. Apart from
 * pair_reduce_definite, for hardly any place needs it. */
static float pair_keep_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]) {
    float inverse[6];
    float left;
    float share;
    sym_invert(a, inverse);
    left = (inverse[0] * n[0] + inverse[1] * n[1] + inverse[2] * n[2] +
            2.0f * (inverse[3] * n[3] + inverse[4] * n[4] + inverse[5] * n[5])) *
           (1.0f / 3.0f);
    if (left >= LEAST_OWN) return 1.0f;
    share = (1.0f - LEAST_OWN) / (1.0f - left); /* squared */
    share *= vec_inverse_root(share);
    if (share < 1.0f) {
        mat_scale(share, x, x);
        sym_reduce(a, x, m, xm, n);
    }
    return share;
}

static inline float pair_reduce_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]) {
    sym_reduce(a, x, m, xm, n);
    return sym_third_of_trace(n) > 3.0f * LEAST_OWN * sym_third_of_trace(a) ? 1.0f : pair_keep_definite(a, m, x, xm, n);
}

float haptable_pair_reduce_definite(const float a[6], const float m[6], float x[9], float xm[9], float n[6]) {
    return pair_reduce_definite(a, m, x, xm, n);
}

/* v of the first, and t; X as pair_reduce_definite leaves it. Returns its share. */
static inline float pair_solve_place(const struct haptable_pair_view* view, const struct haptable_pair_own* own,
                                     float x[9], struct pair_solved* solved) {
    float n[6];
    float xm[9];
    const float share = pair_reduce_definite(own->a, view->m, x, xm, n);
    mat_product(x, view->alone, solved->t);
    vec_sub(own->s, solved->t, solved->t);
    solved->n = sym_factor(n);
    sym_solve(&solved->n, solved->t, solved->v);
    return share;
}

/* ---- both places at once ----------------------------------------------------------------------------------------- */

/* Of u . s: less of it is rounding, where both load one node next to fixed ones and q = 0. */
#define PAIR_NO_DENT 0x1p-16f

/* u . q is not below 0. */
static inline int pair_is_dented(float u_q, float u_s) { return !(u_q < PAIR_NO_DENT * (u_s < 0.0f ? u_s : -u_s)); }

void haptable_pair_press_alone(const struct haptable_pair_law* law, const struct haptable_pair_own* first,
                               const struct haptable_pair_own* second, float u[HAPTABLE_FINGERS][3],
                               float dent[HAPTABLE_FINGERS][3], const float x[9], struct pair_system* system) {
    const struct sym_factored own = sym_factor(first->a);
    float t[3];
    sym_invert(second->a, system->m);
    if (law->is_stiffness) {
        vec_copy(dent[0], system->alone[0]);
        vec_copy(dent[1], system->alone[1]);
    } else {
        sym_solve(&own, first->s, system->alone[0]);
        vec_symmetric_product(system->m, second->s, system->alone[1]);
    }
    mat_product(x, system->alone[1], t);
    vec_sub(first->s, t, system->t);
    mat_transposed_product(x, system->alone[0], t);
    vec_sub(second->s, t, t);
    if (law->is_stiffness) { /* q = A^-1 t */
        float w[3];
        sym_solve(&own, u[0], w);
        system->touches[0] = pair_is_dented(vec_dot(w, system->t), vec_dot(w, first->s));
        vec_symmetric_product(system->m, u[1], w);
        system->touches[1] = pair_is_dented(vec_dot(w, t), vec_dot(w, second->s));
    } else {
        system->touches[0] = pair_is_dented(vec_dot(u[0], system->t), vec_dot(u[0], first->s));
        system->touches[1] = pair_is_dented(vec_dot(u[1], t), vec_dot(u[1], second->s));
    }
}

void haptable_pair_press_both(const struct haptable_pair_own* first, const struct haptable_pair_own* second, float x[9],
                              struct pair_system* system) {
    float n[6];
    float w[3];
    system->lifted = pair_reduce_definite(first->a, system->m, x, system->xm, n) < 1.0f;
    if (system->lifted) {
        float alone[3];
        vec_symmetric_product(system->m, second->s, alone);
        mat_product(x, alone, w);
        vec_sub(first->s, w, system->t);
    }
    system->n = sym_factor(n);
    sym_solve(&system->n, system->t, system->v[0]);
    mat_transposed_product(x, system->v[0], w);
    vec_sub(second->s, w, w);
    vec_symmetric_product(system->m, w, system->v[1]);
}

void haptable_pair_keep_pressing(const struct haptable_pair_model* tables, const float normal[3],
                                 const struct haptable_pair_own* own, int is_raised, const float u[3], int finger,
                                 struct pair_system* system) {
    float load[3];
    float alone[3];
    if (tables->law->is_stiffness) {
        vec_symmetric_product(own->a, system->v[finger], load);
        vec_symmetric_product(own->a, system->alone[finger], alone);
    } else {
        vec_copy(system->v[finger], load);
        vec_copy(system->alone[finger], alone);
    }
    if (vec_dot(u, load) >= 0.0f) system->touches[finger] = 1;
    if (vec_dot(normal, load) > 0.0f && (is_raised || vec_dot(normal, alone) < 0.0f)) system->touches[finger] = 0;
}

/* ---- the force --------------------------------------------------------------------------------------------------- */

/* The load of v: A v, or v. */
static void put_load(const struct haptable_pair_law* law, const float a[6], const float v[3], float load_n[3]) {
    if (law->is_stiffness)
        vec_symmetric_product(a, v, load_n);
    else
        vec_copy(v, load_n);
}

/* What is felt where A v = s: the load with its sign turned. */
static void put_felt(const struct haptable_pair_law* law, const float a[6], const float v[3], float force_n[3]) {
    float load_n[3];
    put_load(law, a, v, load_n);
    vec_zero(force_n);
    vec_sub(force_n, load_n, force_n);
}

void haptable_pair_force(const struct haptable_model* model, const struct haptable_contact* contact,
                         const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    const struct haptable_pair_view* view = pair_view_of(model);
    const struct haptable_pair_law* law = view->tables->law;
    struct haptable_pair_own own;
    struct pair_solved solved;
    float felt_m[3];
    if (view->is_solved) {
        law->load(model, contact, view->v, nodal_force_n, force_n);
        return;
    }
    pair_felt(view, finger_m, felt_m);
    law->own(model, contact, felt_m, &own);
    if (view->is_coupled) {
        float x[9];
        pair_cross_at(view, contact, x);
        (void)pair_solve_place(view, &own, x, &solved);
    } else if (law->is_stiffness) {
        vec_zero(force_n);
        vec_sub(force_n, own.s, force_n);
        return;
    } else {
        solved.n = sym_factor(own.a);
        sym_solve(&solved.n, own.s, solved.v);
    }
    put_felt(law, own.a, solved.v, force_n);
}

/* ---- the energy -------------------------------------------------------------------------------------------------- */

/* What is left of the coupling, and how that changes with the place of the first: 1 where the fingers are apart. */
struct pair_meeting {
    int is_near;
    float share;
    float first[2];
    float second[3]; /* 11 12 22 */
};

/* e: the patch's edges from corner 0. */
static inline struct pair_meeting pair_meet(const struct haptable_pair_view* view, const float god_object_m[3],
                                            float e[2][3]) {
    struct pair_meeting meeting = {0, 1.0f, {0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    const float near = pair_nearness(view, god_object_m);
    const float scale = -2.0f / (view->tables->meeting_m * view->tables->meeting_m);
    float apart[3];
    float slope[2];
    if (near <= 0.0f) return meeting;
    meeting.is_near = 1;
    vec_sub(god_object_m, view->at_m, apart);
    slope[0] = scale * vec_dot(apart, e[0]); /* of near */
    slope[1] = scale * vec_dot(apart, e[1]);
    meeting.share = 1.0f - HAPTABLE_PAIR_MEETING * near * near;
    meeting.first[0] = -2.0f * HAPTABLE_PAIR_MEETING * near * slope[0];
    meeting.first[1] = -2.0f * HAPTABLE_PAIR_MEETING * near * slope[1];
    meeting.second[0] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[0] * slope[0] + near * scale * vec_dot(e[0], e[0]));
    meeting.second[1] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[0] * slope[1] + near * scale * vec_dot(e[0], e[1]));
    meeting.second[2] = -2.0f * HAPTABLE_PAIR_MEETING * (slope[1] * slope[1] + near * scale * vec_dot(e[1], e[1]));
    return meeting;
}

/* x is, or else has, w dX by alpha_c under a mask, all alpha being free. */
static inline void pair_slope(const float (*control)[9], const float alpha[3], int c, float w, float x[9]) {
    int d;
    for (d = 0; d < 3; ++d) {
        const float share = 2.0f * w * alpha[d];
        if (w > 0.0f && d == 0)
            mat_scale(share, control[pair_control_of(c, d)], x);
        else
            mat_add(share, control[pair_control_of(c, d)], x);
    }
}

/* X of a contact and its first derivatives by alpha_1, alpha_2; and v . X_bc w for the second. */
struct pair_coupling {
    float x[9];
    float first[2][9];
    const float (*control)[9];
    struct pair_meeting meeting;
};

static inline void pair_couple(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                               float e[2][3], struct pair_coupling* to) {
    const float* alpha = contact->alpha;
    float weight[HAPTABLE_PAIR_CONTROLS];
    const int count = pair_count(view->tables->law);
    float raw[9];
    int b;
    to->control = (const float(*)[9])pair_gather(view, contact->patch)->x;
    pair_weights(count, alpha, weight);
    to->meeting = pair_meet(view, contact->god_object_m, e);
    pair_sum(count, weight, to->control[0], 9, raw);
    mat_scale(to->meeting.share, raw, to->x);
    for (b = 0; b < 2; ++b) {
        if (count == HAPTABLE_PAIR_CONTROLS) {
            pair_slope(to->control, alpha, b + 1, 1.0f, to->first[b]);
            pair_slope(to->control, alpha, 0, -1.0f, to->first[b]);
        } else {
            vec_sub(&to->control[b + 1][0], &to->control[0][0], &to->first[b][0]);
            vec_sub(&to->control[b + 1][3], &to->control[0][3], &to->first[b][3]);
            vec_sub(&to->control[b + 1][6], &to->control[0][6], &to->first[b][6]);
        }
        if (!to->meeting.is_near) continue;
        mat_scale(to->meeting.share, to->first[b], to->first[b]);
        mat_add(to->meeting.first[b], raw, to->first[b]);
    }
}

/* The same of a share of X, which is taken as it is: X has it already. */
static inline void pair_fade(float share, struct pair_coupling* of) {
    int b;
    of->meeting.share *= share;
    for (b = 0; b < 2; ++b) {
        mat_scale(share, of->first[b], of->first[b]);
        of->meeting.first[b] *= share;
    }
    for (b = 0; b < 3; ++b) of->meeting.second[b] *= share;
}

/* v . X_bc w: 11 12 22. share X = X without the fingers' nearness, so that X_b holds share' of it already. */
static inline void pair_couple_twice(const struct haptable_pair_view* view, const struct pair_coupling* of,
                                     const float v[3], const float w[3], float second_j[3]) {
    const struct pair_meeting* m = &of->meeting;
    vec_zero(second_j);
    if (m->is_near) {
        const float x = mat_bilinear(of->x, v, w) / m->share; /* of the tables alone */
        const float x1 = (mat_bilinear(of->first[0], v, w) - m->first[0] * x) / m->share;
        const float x2 = (mat_bilinear(of->first[1], v, w) - m->first[1] * x) / m->share;
        second_j[0] = 2.0f * m->first[0] * x1 + m->second[0] * x;
        second_j[1] = m->first[0] * x2 + m->first[1] * x1 + m->second[1] * x;
        second_j[2] = 2.0f * m->first[1] * x2 + m->second[2] * x;
    }
    if (view->tables->law->controls == HAPTABLE_PAIR_CONTROLS) {
        float q[HAPTABLE_PAIR_CONTROLS];
        int k;
        for (k = 0; k < HAPTABLE_PAIR_CONTROLS; ++k) q[k] = 2.0f * m->share * mat_bilinear(of->control[k], v, w);
        second_j[0] += q[1] - 2.0f * q[pair_control_of(1, 0)] + q[0];
        second_j[1] += q[pair_control_of(1, 2)] - q[pair_control_of(1, 0)] - q[pair_control_of(2, 0)] + q[0];
        second_j[2] += q[2] - 2.0f * q[pair_control_of(2, 0)] + q[0];
    }
}

/* v_2 = A_2^-1 (s_2 - X^T v_1) */
static inline void pair_other(const struct haptable_pair_view* view, const float x[9], const float v[3],
                              float other[3]) {
    float pressed[3];
    mat_transposed_product(x, v, pressed);
    vec_sub(view->s, pressed, pressed);
    vec_symmetric_product(view->m, pressed, other);
}

static inline float pair_solve(const struct haptable_pair_view* view, const struct haptable_pair_own* own, float x[9],
                               struct pair_solved* solved) {
    const float share = pair_solve_place(view, own, x, solved);
    pair_other(view, x, solved->v, solved->other);
    solved->energy_j = 0.5f * vec_dot(solved->t, solved->v);
    return share;
}

/* Curvature: hessian_j holds v . s_bc - 1/2 v A_bc v; y holds s_b - A_b v, and becomes N^-1 y. */
static inline void pair_bend(const struct haptable_pair_view* view, const struct pair_coupling* coupling,
                             const struct pair_solved* solved, float y[2][3], struct haptable_energy* energy) {
    float r[2][3];
    float mr[2][3];
    float z[2][3];
    float second_j[3];
    int b;
    pair_couple_twice(view, coupling, solved->v, solved->other, second_j);
    for (b = 0; b < 2; ++b) {
        float more[3];
        mat_transposed_product(coupling->first[b], solved->v, r[b]);
        vec_symmetric_product(view->m, r[b], mr[b]); /* of -r_b */
        mat_product(coupling->x, mr[b], more);
        vec_add_scaled(1.0f, more, y[b]);
        mat_product(coupling->first[b], solved->other, more);
        vec_sub(y[b], more, y[b]);
        sym_solve(&solved->n, y[b], z[b]);
    }
    energy->gauss_newton_j[0] = vec_dot(y[0], z[0]) + vec_dot(r[0], mr[0]);
    energy->gauss_newton_j[1] = vec_dot(y[0], z[1]) + vec_dot(r[0], mr[1]);
    energy->gauss_newton_j[2] = vec_dot(y[1], z[1]) + vec_dot(r[1], mr[1]);
    for (b = 0; b < 3; ++b) energy->hessian_j[b] += energy->gauss_newton_j[b] - second_j[b];
    for (b = 0; b < 2; ++b) vec_copy(z[b], y[b]);
}

/* What an evaluation has before the load is known. */
struct point {
    struct haptable_pair_point own;
    struct pair_coupling coupling;
};

/* The load's slope is v's, or A_b v + A v_b. */
static void put_load_slope(const struct haptable_pair_law* law, const struct haptable_pair_point* own,
                           const struct haptable_pair_slope* slope, float load_gradient_n[2][3]) {
    int b;
    for (b = 0; b < 2; ++b) {
        put_load(law, own->own.a, slope->y[b], load_gradient_n[b]);
        if (law->is_stiffness) vec_add_scaled(1.0f, slope->a_v[b], load_gradient_n[b]);
    }
}

static void put_bend(const struct haptable_pair_view* view, const struct point* point, const struct pair_solved* solved,
                     struct haptable_pair_slope* slope, struct haptable_energy* energy) {
    vec_copy(slope->second_j, energy->hessian_j);
    pair_bend(view, &point->coupling, solved, slope->y, energy);
    put_load_slope(view->tables->law, &point->own, slope, energy->load_gradient_n);
    if (point->own.steps) {
        vec_no_number(energy->load_gradient_n[0]);
        vec_no_number(energy->load_gradient_n[1]);
    }
}

static void put_energy(const struct haptable_pair_view* view, const struct haptable_contact* contact,
                       const float finger_m[3], enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_model* tables = view->tables;
    const int is_known = terms == HAPTABLE_ENERGY_GRADIENT && !tables->law->is_stiffness; /* v: the load */
    struct haptable_pair_slope slope;
    struct pair_solved solved;
    struct point point;
    int b;
    tables->bend->open(tables->model, contact, finger_m, &point.own);
    pair_couple(view, contact, point.own.e, &point.coupling);
    if (is_known) {
        vec_copy(energy->load_n, solved.v);
        if (view->share < 1.0f) { /* the same place as another patch sees it */
            mat_scale(view->share, point.coupling.x, point.coupling.x);
            pair_fade(view->share, &point.coupling);
        }
        pair_other(view, point.coupling.x, solved.v, solved.other);
    } else {
        struct haptable_pair_view* told = (struct haptable_pair_view*)view; /* of a model, which is no constant */
        told->share = pair_solve(view, &point.own.own, point.coupling.x, &solved);
        if (view->share < 1.0f) pair_fade(view->share, &point.coupling);
        energy->energy_j = solved.energy_j;
        put_load(tables->law, point.own.own.a, solved.v, energy->load_n);
        if (terms == HAPTABLE_ENERGY_LOAD) return;
    }
    tables->bend->slope(tables->model, contact, &point.own, solved.v, &slope);
    for (b = 0; b < 2; ++b)
        energy->gradient_j[b] = slope.first_j[b] - mat_bilinear(point.coupling.first[b], solved.v, solved.other);
    if (terms == HAPTABLE_ENERGY_ALL) put_bend(view, &point, &solved, &slope, energy);
}

void haptable_pair_energy(const struct haptable_model* model, const struct haptable_contact* contact,
                          const float finger_m[3], enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const struct haptable_pair_view* view = pair_view_of(model);
    float felt_m[3];
    pair_felt(view, finger_m, felt_m);
    if (view->is_coupled)
        put_energy(view, contact, felt_m, terms, energy);
    else
        view->tables->model->energy(model, contact, felt_m, terms, energy);
}
