/* SPDX-License-Identifier: MIT
 *
 * f = C^-1 u,   E = 1/2 u . f,   dE/db = -e_b . f - 1/2 f^T C_b f,   e_b = dg/db,   C_b = dC/db
 *
 * d2E/db dc = r_b^T C^-1 r_c - 1/2 f^T C_bc f with r_b = e_b + C_b f: the first term is never negative.
 */
#include "compliance.h"

#include "surface.h"
#include "vector.h"

/* ---- the polynomial ------------------------------------------------------------------------------------------- */

/* The blocks of a patch in the form's order. An edge's blocks stand from its lower vertex to its higher one. */
static void gather(const struct haptable_model* model, uint16_t patch, const float* block[COMPLIANCE_CONTROLS]) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const int per_edge = c->degree - 1;
    int corner;
    int n = 3;
    for (corner = 0; corner < 3; ++corner) {
        const int a = corner == 2 ? 0 : corner + 1;
        const int b = corner == 0 ? 2 : corner - 1;
        const float(*edge)[6] = &c->edge[c->patch_edge[patch][corner] * per_edge];
        int i;
        block[corner] = c->vertex[v[corner]];
        for (i = 0; i < per_edge; ++i) block[n++] = edge[v[a] < v[b] ? i : per_edge - 1 - i];
    }
    for (corner = 0; c->degree == 4 && corner < 3; ++corner) block[n++] = c->patch[3 * patch + corner];
}

/* alpha_c^k for k = 0 .. 4. */
static void powers(const float alpha[3], float power[3][5]) {
    int c;
    for (c = 0; c < 3; ++c) {
        power[c][0] = 1.0f;
        power[c][1] = alpha[c];
        power[c][2] = alpha[c] * alpha[c];
        power[c][3] = power[c][2] * alpha[c];
        power[c][4] = power[c][2] * power[c][2];
    }
}

static float value_of(const struct compliance_control* control, float power[3][5]) {
    return (float)control->factor * power[0][control->exponent[0]] * power[1][control->exponent[1]] *
           power[2][control->exponent[2]];
}

/* x^n derived k times, k = 0, 1, 2, from the powers of x. */
static float derived(const float power[5], int n, int k) {
    if (k == 0) return power[n];
    if (k == 1) return n < 1 ? 0.0f : (float)n * power[n - 1];
    return n < 2 ? 0.0f : (float)(n * (n - 1)) * power[n - 2];
}

/* The control point's weight derived by alpha_c, and once more by alpha_d; d = -1: once. */
static float weight_derived(const struct compliance_control* control, float power[3][5], int c, int d) {
    float product = (float)control->factor;
    int i;
    for (i = 0; i < 3; ++i) product *= derived(power[i], control->exponent[i], (i == c) + (i == d));
    return product;
}

static void add_block(float weight, const float block[6], float sum[6]) {
    int i;
    for (i = 0; i < 6; ++i) sum[i] += weight * block[i];
}

/* ---- fixed vertices ------------------------------------------------------------------------------------------- */

/* The share of alpha on fixed vertices. */
static float fixed_share(const struct haptable_model* model, const struct haptable_contact* contact) {
    float share = 0.0f;
    int corner;
    for (corner = 0; corner < 3; ++corner)
        if (model->patch[contact->patch][corner] >= model->free_count) share += contact->alpha[corner];
    return share;
}

static float third_of_trace(const float s[6]) { return (s[0] + s[1] + s[2]) * (1.0f / 3.0f); }

/* Lifts C's diagonal to the fixed vertices' share of 1 / rigid_stiffness. Returns 1 where it did. */
static int lift(const struct haptable_model* model, float share, float c[6]) {
    float missing;
    int i;
    if (share <= 0.0f) return 0;
    missing = share / model->rigid_stiffness_n_per_m - third_of_trace(c);
    if (missing <= 0.0f) return 0;
    for (i = 0; i < 3; ++i) c[i] += missing;
    return 1;
}

/* ---- the load ------------------------------------------------------------------------------------------------- */

/* C = L D L^T of a symmetric positive definite C, D inverted. */
struct factored {
    float inverse[3]; /* 1 / D */
    float l10, l20, l21;
};

static struct factored factor(const float c[6]) {
    struct factored f;
    float d1;
    float d2;
    f.inverse[0] = 1.0f / c[0];
    f.l10 = c[3] * f.inverse[0];
    f.l20 = c[5] * f.inverse[0];
    d1 = c[1] - f.l10 * c[3];
    f.inverse[1] = 1.0f / d1;
    f.l21 = (c[4] - f.l20 * c[3]) * f.inverse[1];
    d2 = c[2] - f.l20 * c[5] - f.l21 * f.l21 * d1;
    f.inverse[2] = 1.0f / d2;
    return f;
}

static void solve(const struct factored* f, const float b[3], float x[3]) {
    const float y1 = b[1] - f->l10 * b[0];
    const float y2 = b[2] - f->l20 * b[0] - f->l21 * y1;
    x[2] = y2 * f->inverse[2];
    x[1] = y1 * f->inverse[1] - f->l21 * x[2];
    x[0] = b[0] * f->inverse[0] - f->l10 * x[1] - f->l20 * x[2];
}

void compliance_load(const struct haptable_model* model, const struct compliance_form* form,
                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    const float* block[COMPLIANCE_CONTROLS];
    float power[3][5];
    float c[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    float u[3];
    struct factored factored;
    int k;
    gather(model, contact->patch, block);
    powers(contact->alpha, power);
    for (k = 0; k < form->count; ++k) add_block(value_of(&form->control[k], power), block[k], c);
    lift(model, fixed_share(model, contact), c);
    vec_sub(finger_m, contact->god_object_m, u);
    factored = factor(c);
    solve(&factored, u, load_n);
}

void compliance_share(const float load_n[3], const struct haptable_contact* contact, float nodal_force_n[3][3],
                      float force_n[3]) {
    int corner;
    vec_zero(force_n);
    vec_add_scaled(-1.0f, load_n, force_n);
    for (corner = 0; corner < 3; ++corner) {
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], load_n, nodal_force_n[corner]);
    }
}

/* ---- the energy ----------------------------------------------------------------------------------------------- */

/* What the derivatives of C do to a load: C_b f (b = 1, 2) and f^T C_bc f (11, 12, 22). */
struct variation {
    float first[2][3];
    float second[3];
};

/* Adds one control point's part; `pf` is its block times f (less its trace's third where C was lifted). */
static void vary(const struct compliance_control* control, float power[3][5], const float pf[3], float f_pf,
                 struct variation* v) {
    const float by0 = weight_derived(control, power, 0, -1);
    const float by00 = weight_derived(control, power, 0, 0);
    const float by01 = weight_derived(control, power, 0, 1);
    const float by02 = weight_derived(control, power, 0, 2);
    vec_add_scaled(weight_derived(control, power, 1, -1) - by0, pf, v->first[0]);
    vec_add_scaled(weight_derived(control, power, 2, -1) - by0, pf, v->first[1]);
    v->second[0] += f_pf * (weight_derived(control, power, 1, 1) - 2.0f * by01 + by00);
    v->second[1] += f_pf * (weight_derived(control, power, 1, 2) - by01 - by02 + by00);
    v->second[2] += f_pf * (weight_derived(control, power, 2, 2) - 2.0f * by02 + by00);
}

/* The lifted diagonal's own slope: the fixed share's, times f. */
static void vary_share(const struct haptable_model* model, uint16_t patch, const float f[3], struct variation* v) {
    const uint16_t* vertex = model->patch[patch];
    const float compliance = 1.0f / model->rigid_stiffness_n_per_m;
    const int fixed0 = vertex[0] >= model->free_count;
    vec_add_scaled(compliance * (float)((vertex[1] >= model->free_count) - fixed0), f, v->first[0]);
    vec_add_scaled(compliance * (float)((vertex[2] >= model->free_count) - fixed0), f, v->first[1]);
}

/* Fills in slope and curvature from the load, the variation and the patch's edges. */
static void derive(const struct haptable_model* model, uint16_t patch, const struct factored* factored,
                   struct variation* v, struct haptable_energy* energy) {
    const float* f = energy->load_n;
    float e[2][3];
    float s_r[2][3];
    int b;
    vec_sub(vertex_of(model, patch, 1), vertex_of(model, patch, 0), e[0]);
    vec_sub(vertex_of(model, patch, 2), vertex_of(model, patch, 0), e[1]);
    for (b = 0; b < 2; ++b) {
        energy->slope_j[b] = -vec_dot(e[b], f) - 0.5f * vec_dot(f, v->first[b]);
        vec_add_scaled(1.0f, e[b], v->first[b]); /* r_b = e_b + C_b f */
        solve(factored, v->first[b], s_r[b]);
    }
    energy->lower_bound_j[0] = vec_dot(v->first[0], s_r[0]);
    energy->lower_bound_j[1] = vec_dot(v->first[0], s_r[1]);
    energy->lower_bound_j[2] = vec_dot(v->first[1], s_r[1]);
    for (b = 0; b < 3; ++b) energy->curvature_j[b] = energy->lower_bound_j[b] - 0.5f * v->second[b];
}

void compliance_energy(const struct haptable_model* model, const struct compliance_form* form,
                       const struct haptable_contact* contact, const float finger_m[3],
                       struct haptable_energy* energy) {
    const float* block[COMPLIANCE_CONTROLS];
    float power[3][5];
    float c[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    float u[3];
    struct factored factored;
    struct variation v = {{{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}}, {0.0f, 0.0f, 0.0f}};
    int lifted;
    int k;
    gather(model, contact->patch, block);
    powers(contact->alpha, power);
    for (k = 0; k < form->count; ++k) add_block(value_of(&form->control[k], power), block[k], c);
    lifted = lift(model, fixed_share(model, contact), c);
    vec_sub(finger_m, contact->god_object_m, u);
    factored = factor(c);
    solve(&factored, u, energy->load_n);
    energy->energy_j = 0.5f * vec_dot(u, energy->load_n);
    for (k = 0; k < form->count; ++k) {
        float pf[3];
        vec_symmetric_product(block[k], energy->load_n, pf);
        if (lifted) vec_add_scaled(-third_of_trace(block[k]), energy->load_n, pf);
        vary(&form->control[k], power, pf, vec_dot(energy->load_n, pf), &v);
    }
    if (lifted) vary_share(model, contact->patch, energy->load_n, &v);
    derive(model, contact->patch, &factored, &v, energy);
}
