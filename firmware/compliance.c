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

/* Control blocks in the order of exponents (n - r, r - k, k): block r (r + 1) / 2 + k, r = 0 .. n, k = 0 .. r.
 * Derivatives come from the last steps of de Casteljau's scheme: a step takes the block with one exponent more at
 * corner 0, 1, 2 times alpha each. */
struct net {
    const float* block[COMPLIANCE_CONTROLS];
};

/* The blocks of a patch. An edge's blocks stand from its lower vertex to its higher one. */
static void gather(const struct haptable_model* model, const struct compliance_form* form, uint16_t patch,
                   struct net* net) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const int per_edge = form->degree - 1;
    int corner;
    for (corner = 0; corner < 3; ++corner) {
        const int forward = v[next_corner(corner)] < v[previous_corner(corner)];
        const float(*edge)[6] = &c->edge[c->patch_edge[patch][corner] * per_edge];
        int i;
        net->block[form->vertex[corner]] = c->vertex[v[corner]];
        for (i = 0; i < per_edge; ++i) net->block[form->edge[corner][i]] = edge[forward ? i : per_edge - 1 - i];
        if (form->degree == 4) net->block[form->inside[corner]] = c->patch[3 * patch + corner];
    }
}

static inline void mix(const float alpha[3], const float a[6], const float b[6], const float c[6], float out[6]) {
    int i;
    for (i = 0; i < 6; ++i) out[i] = alpha[0] * a[i] + alpha[1] * b[i] + alpha[2] * c[i];
}

/* The first step, from the tables. */
static inline void step_from_tables(int degree, const struct net* net, const float alpha[3], float (*out)[6]) {
    int n = 0;
    int r;
    int k;
    for (r = 0; r < degree; ++r)
        for (k = 0; k <= r; ++k, ++n) mix(alpha, net->block[n], net->block[n + r + 1], net->block[n + r + 2], out[n]);
}

/* A further step, in place: what it writes it has read. */
static inline void step_in_place(int degree, const float alpha[3], float (*block)[6]) {
    int n = 0;
    int r;
    int k;
    for (r = 0; r < degree; ++r)
        for (k = 0; k <= r; ++k, ++n) mix(alpha, block[n], block[n + r + 1], block[n + r + 2], block[n]);
}

/* C and, for its derivatives, the nets of degree 1 and 2 that it is made of. */
struct polynomial {
    float c[6];
    float linear[3][6];
    float quadratic[6][6];
};

static void copy_blocks(int count, float (*from)[6], float (*to)[6]) {
    int n;
    int i;
    for (n = 0; n < count; ++n)
        for (i = 0; i < 6; ++i) to[n][i] = from[n][i];
}

/* C alone, of degree 4. */
static void evaluate_c(const struct net* net, const float alpha[3], float c[6]) {
    float block[10][6];
    step_from_tables(4, net, alpha, block);
    step_in_place(3, alpha, block);
    step_in_place(2, alpha, block);
    mix(alpha, block[0], block[1], block[2], c);
}

static void evaluate_all(const struct net* net, int degree, const float alpha[3], struct polynomial* p) {
    if (degree == 4) {
        float block[10][6];
        step_from_tables(4, net, alpha, block);
        step_in_place(3, alpha, block);
        copy_blocks(6, block, p->quadratic);
        step_in_place(2, alpha, block);
        copy_blocks(3, block, p->linear);
    } else {
        int n;
        int i;
        for (n = 0; n < 6; ++n)
            for (i = 0; i < 6; ++i) p->quadratic[n][i] = net->block[n][i];
        step_from_tables(2, net, alpha, p->linear);
    }
    mix(alpha, p->linear[0], p->linear[1], p->linear[2], p->c);
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

void compliance_solve(const struct haptable_model* model, const struct haptable_contact* contact,
                      const float finger_m[3], float c[6], float load_n[3]) {
    float u[3];
    struct factored factored;
    lift(model, fixed_share(model, contact), c);
    vec_sub(finger_m, contact->god_object_m, u);
    factored = factor(c);
    solve(&factored, u, load_n);
}

void compliance_load(const struct haptable_model* model, const struct compliance_form* form,
                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    struct net net;
    float c[6];
    gather(model, form, contact->patch, &net);
    evaluate_c(&net, contact->alpha, c);
    compliance_solve(model, contact, finger_m, c, load_n);
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

/* out = (sum of weighted blocks) f, less the third of its trace times f where C is lifted. */
static void block_load(const float block[6], const float f[3], int lifted, float out[3]) {
    vec_symmetric_product(block, f, out);
    if (lifted) vec_add_scaled(-third_of_trace(block), f, out);
}

/* b C_0 + c C_1 + d C_2, scaled. */
static void difference(float scale, const float a[6], float b, const float other[6], float c, const float third[6],
                       float out[6]) {
    int i;
    for (i = 0; i < 6; ++i) out[i] = scale * (a[i] + b * other[i] + c * third[i]);
}

/* dC/d alpha_b - dC/d alpha_0 and so on, from the nets of degree 1 and 2 (Farin). */
static void vary(const struct polynomial* p, int degree, const float f[3], int lifted, struct variation* v) {
    const float first = (float)degree;
    const float second = (float)(degree * (degree - 1));
    float block[6];
    float bf[3];
    int b;
    for (b = 0; b < 2; ++b) {
        difference(first, p->linear[b + 1], -1.0f, p->linear[0], 0.0f, p->linear[0], block);
        block_load(block, f, lifted, v->first[b]); /* cppcheck-suppress uninitvar ; it is written here */
    }
    /* quadratic: 200 110 101 020 011 002 */
    difference(second, p->quadratic[3], -2.0f, p->quadratic[1], 1.0f, p->quadratic[0], block);
    block_load(block, f, lifted, bf);
    v->second[0] = vec_dot(f, bf);
    difference(second, p->quadratic[5], -2.0f, p->quadratic[2], 1.0f, p->quadratic[0], block);
    block_load(block, f, lifted, bf);
    v->second[2] = vec_dot(f, bf);
    difference(second, p->quadratic[4], -1.0f, p->quadratic[1], -1.0f, p->quadratic[2], block);
    for (b = 0; b < 6; ++b) block[b] += second * p->quadratic[0][b];
    block_load(block, f, lifted, bf);
    v->second[1] = vec_dot(f, bf);
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
    struct net net;
    struct polynomial p;
    float u[3];
    struct factored factored;
    struct variation v;
    int lifted;
    gather(model, form, contact->patch, &net);
    evaluate_all(&net, form->degree, contact->alpha, &p);
    lifted = lift(model, fixed_share(model, contact), p.c);
    vec_sub(finger_m, contact->god_object_m, u);
    factored = factor(p.c);
    solve(&factored, u, energy->load_n);
    energy->energy_j = 0.5f * vec_dot(u, energy->load_n);
    vary(&p, form->degree, energy->load_n, lifted, &v);
    if (lifted) vary_share(model, contact->patch, energy->load_n, &v);
    derive(model, contact->patch, &factored, &v, energy);
}
