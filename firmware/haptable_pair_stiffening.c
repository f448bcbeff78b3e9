/* SPDX-License-Identifier: MIT
 *
 * E = E_lin(v_1, v_2),   v_c = r(e_c) u_c,   r^2 = Psi(e) / e,   e_c = 1/2 u_c . C_cc^-1 u_c
 *
 * Two fingers on a body whose dents stiffen: the linear pair with u stretched, which is Psi where one is alone. So the
 * coupling, who touches and where both rest are the linear pair's, and E is a function of fingers and god-objects:
 *
 *   F_c = r f_c + k (u . f_c) / (2 e) q,   q = C_cc^-1 u,   k = 2 e dr/de = (Psi' - Psi / e) / r
 *
 * Its terms: s = r s_lin, s_b = r s_lin,b + r_b s_lin by a coordinate b, r_b = k e_b / (2 e).
 */
#include "haptable_pair_stiffening.h"

#include "haptable_pair_laws.h"
#include "haptable_stiffening.h"

/* Psi / e of part = e / e_0. */
static float stored_per_energy(const float c[4], float part, float s, float factor) {
    const float within = stiffening_mean(c, s);
    return part < 1.0f ? within : factor + (within - factor) / part;
}

/* before: u and q; A v = s of the contact alone. */
static void put_stretch(const struct haptable_model* model, struct stretch* to) {
    const float* c = model->stiffening;
    to->work_j = vec_dot(to->u, to->q);
    const float part = to->work_j * c[HAPTABLE_STIFFENING_PER_WORK];
    const float s = stiffening_root(part);
    const float factor = stiffening_factor(c, s);
    const float per_energy = stored_per_energy(c, part, s, factor);
    const float slope = part < 1.0f ? stiffening_slope(c, s) : 0.0f;
    const float inverse = vec_inverse_root(per_energy);
    to->r = per_energy * inverse;
    to->k = (factor - per_energy) * inverse;
    to->m = (slope - 2.0f * (factor - per_energy) - to->k * to->k) * inverse - 2.0f * to->k;
    to->per_j = to->work_j > HAPTABLE_ROOT_LEAST ? 1.0f / to->work_j : 0.0f;
}

void haptable_pair_stretch(const struct haptable_model* model, const float a[6], int is_stiffness, const float u[3],
                           struct stretch* to) {
    vec_copy(u, to->u);
    if (is_stiffness)
        vec_symmetric_product(a, u, to->q);
    else
        sym_solve_once(a, u, to->q);
    put_stretch(model, to);
}

/* Of a finger that sees the other: by its own terms. */
static void stretch_of(const struct haptable_model* model, const struct haptable_contact* contact,
                       const float finger_m[3], struct stretch* to) {
    const struct haptable_pair_view* view = pair_view_of(model);
    const struct haptable_pair_law* law = view->tables->law;
    struct haptable_pair_own own;
    float felt_m[3], u[3];
    pair_felt(view, finger_m, felt_m);
    law->own(model, contact, felt_m, &own);
    vec_sub(felt_m, contact->god_object_m, u);
    haptable_pair_stretch(model, own.a, law->is_stiffness, u, to);
}

/* f -> r f + k (u . f) / (2 e) q */
static void felt_of(const struct stretch* stretch, float f[3]) {
    const float along = stretch->k * stretch->per_j * vec_dot(stretch->u, f);
    vec_scale(stretch->r, f);
    vec_add_scaled(along, stretch->q, f);
}

/* Its inverse: u . F = (r + k) u . f. */
static void load_of(const struct stretch* stretch, float f[3]) {
    const float along = stretch->k * stretch->per_j * vec_dot(stretch->u, f) / (stretch->r + stretch->k);
    vec_add_scaled(-along, stretch->q, f);
    vec_scale(1.0f / stretch->r, f);
}

static void force_of(const struct haptable_model* model, const struct haptable_contact* contact,
                     const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    struct stretch stretch;
    haptable_pair_force(model, contact, finger_m, nodal_force_n, force_n);
    stretch_of(model, contact, finger_m, &stretch);
    felt_of(&stretch, force_n);
    if (!pair_view_of(model)->is_solved) return; /* nobody asks for the nodes' loads */
    for (int corner = 0; corner < 3; ++corner) vec_scale(1.0f / stretch.r, nodal_force_n[corner]);
}

static float stiffened_of(const struct haptable_model* model, const struct haptable_servo* servo,
                          struct haptable_stiffened* stiffened) {
    struct stretch stretch;
    stretch_of(model, &servo->contact, servo->finger_m, &stretch);
    return haptable_stiffening_put(model->stiffening, stretch.work_j, stiffened);
}

/* frictionless: friction holds the force that the hand feels within its cone; least energy goes on with the load f, or
 * alone with q. */
static void god_object(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    const int is_alone = !pair_view_of(model)->is_coupled;
    struct haptable_contact* contact = &servo->contact;
    struct stretch stretch;
    if (model->energy && contact->patch != HAPTABLE_NONE) {
        stretch_of(model, contact, x_m, &stretch);
        load_of(&stretch, contact->load_n);
        if (is_alone) vec_scale(1.0f / stretch.r, contact->load_n);
    }
    pair_view_of(model)->tables->model->frictionless(model, servo, x_m);
    if (!model->energy || contact->patch == HAPTABLE_NONE) return;
    stretch_of(model, contact, x_m, &stretch);
    if (is_alone) vec_scale(stretch.r, contact->load_n);
    felt_of(&stretch, contact->load_n);
}

static void see(struct haptable_model* view) {
    view->force = force_of;
    view->stiffen = stiffened_of;
    if (view->relax == haptable_stiffening) view->relax = 0; /* the force is stiffened already */
    if (view->frictionless) view->frictionless = god_object;
}

/* Newton's steps: Psi is convex enough for a few, from where it is linear. */
#define STRAIGHTEN_STEPS 6

/* v = r u: s r(s) = sqrt(e_v / e_0) of u's s, where Psi(e_u) = e_v. */
static void straighten(const struct haptable_model* model, float work_j, float v[3]) {
    const float* c = model->stiffening;
    const float part = work_j * c[HAPTABLE_STIFFENING_PER_WORK];
    float e = part; /* e_u / e_0: Psi lies above e, where the curve rises */
    if (!(part > HAPTABLE_ROOT_LEAST)) return;
    for (int k = 0; k < STRAIGHTEN_STEPS; ++k) {
        const float s = stiffening_root(e);
        const float factor = stiffening_factor(c, s);
        const float next = e - (e * stored_per_energy(c, e, s, factor) - part) / factor;
        e = next > 0.0f ? next : 0.5f * e;
    }
    const float s = stiffening_root(e);
    const float per_energy = stored_per_energy(c, e, s, stiffening_factor(c, s));
    vec_scale(vec_inverse_root(per_energy), v);
}

static void straighten_by_stiffness(const struct haptable_model* model, const float a[6], float v[3]) {
    float f[3];
    vec_symmetric_product(a, v, f);
    straighten(model, vec_dot(v, f), v);
}

static void straighten_by_compliance(const struct haptable_model* model, const float a[6], float v[3]) {
    float f[3];
    sym_solve_once(a, v, f);
    straighten(model, vec_dot(v, f), v);
}

static const struct haptable_pair_stiffening of_stiffness = {see, straighten_by_stiffness};
static const struct haptable_pair_stiffening of_compliance = {see, straighten_by_compliance};

/* ---- the laws ---------------------------------------------------------------------------------------------------- */

/* s, of the linear law's terms. */
static void stretch_own(const struct haptable_model* model, const struct haptable_contact* contact,
                        const float finger_m[3], int is_stiffness, struct haptable_pair_own* own) {
    struct stretch stretch;
    float u[3];
    vec_sub(finger_m, contact->god_object_m, u);
    haptable_pair_stretch(model, own->a, is_stiffness, u, &stretch);
    vec_scale(stretch.r, own->s);
}

#define LAW(name, count, is_stiffness, load, kind)                                                                 \
    static void own_##name(const struct haptable_model* model, const struct haptable_contact* contact,             \
                           const float finger_m[3], struct haptable_pair_own* own) {                               \
        haptable_pair_own_##name(model, contact, finger_m, own);                                                   \
        stretch_own(model, contact, finger_m, is_stiffness, own);                                                  \
    }                                                                                                              \
    const struct haptable_pair_law haptable_pair_stiffening_##name = {(count), (is_stiffness), own_##name, (load), \
                                                                      &(kind)};

LAW(interpolated, 3, 1, haptable_pair_load_interpolated, of_stiffness)
LAW(consistent, 3, 0, haptable_pair_load_of_compliance, of_compliance)
LAW(pressure_mask, HAPTABLE_PAIR_CONTROLS, 0, haptable_pair_load_of_compliance, of_compliance)
LAW(consistent_packed, 3, 0, haptable_pair_load_of_compliance, of_compliance)
LAW(pressure_mask_packed, HAPTABLE_PAIR_CONTROLS, 0, haptable_pair_load_of_compliance, of_compliance)
