/* SPDX-License-Identifier: MIT
 *
 * f = C^-1 u,   E = 1/2 u . f,   dE/db = -e_b . f - 1/2 f^T C_b f,   e_b = dg/db,   C_b = dC/db
 *
 * d2E/db dc = r_b^T C^-1 r_c - 1/2 f^T C_bc f with r_b = e_b + C_b f: the first term is never negative.
 *
 * What haptable_compliance.c (blocks in float32) and haptable_compliance_packed.c (in 16 bits) are made of: one file
 * for each, so that each has it inlined, and a model pays for one of them only.
 */
#ifndef HAPTABLE_NET_H
#define HAPTABLE_NET_H

#include "haptable_compliance.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* ---- the polynomial ------------------------------------------------------------------------------------------- */

/* Control blocks in the order of exponents (n - r, r - k, k): block r (r + 1) / 2 + k, r = 0 .. n, k = 0 .. r. */
struct net {
    const float* block[HAPTABLE_COMPLIANCE_CONTROLS];
    int count;
};

/* The blocks of a patch. An edge's blocks stand from its lower vertex to its higher one. */
static inline void gather(const struct haptable_model* model, const struct haptable_compliance_form* form,
                          uint16_t patch, struct net* net) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const int per_edge = form->degree - 1;
    int corner;
    net->count = form->degree == 4 ? HAPTABLE_COMPLIANCE_CONTROLS : 6;
    for (corner = 0; corner < 3; ++corner) {
        const int forward = v[next_corner(corner)] < v[previous_corner(corner)];
        const int first = c->patch_edge[patch][corner] * per_edge;
        const float(*edge)[6] = &c->edge[first];
        int i;
        net->block[form->vertex[corner]] = c->vertex[v[corner]];
        for (i = 0; i < per_edge; ++i) net->block[form->edge[corner][i]] = edge[forward ? i : per_edge - 1 - i];
        if (form->degree == 4) net->block[form->inside[corner]] = c->patch[3 * patch + corner];
    }
}

/* Bernstein's polynomials of one degree less than C, degree! / (i! j! k!) alpha_0^i alpha_1^j alpha_2^k, in the order
 * of a net. */
static inline void bernstein(int degree, const float alpha[3], float w[10]) {
    const float a = alpha[0];
    const float b = alpha[1];
    const float c = alpha[2];
    if (degree == 2) {
        vec_copy(alpha, w);
        return;
    }
    w[0] = a * a * a;
    w[1] = 3.0f * a * a * b;
    w[2] = 3.0f * a * a * c;
    w[3] = 3.0f * a * b * b;
    w[4] = 6.0f * a * b * c;
    w[5] = 3.0f * a * c * c;
    w[6] = b * b * b;
    w[7] = 3.0f * b * b * c;
    w[8] = 3.0f * b * c * c;
    w[9] = c * c * c;
}

/* out = w B and out += w B, as single statements, which compilers put into wide registers. */
static inline void set_block(float w, const float b[6], float out[6]) {
    out[0] = w * b[0];
    out[1] = w * b[1];
    out[2] = w * b[2];
    out[3] = w * b[3];
    out[4] = w * b[4];
    out[5] = w * b[5];
}

static inline void add_block(float w, const float b[6], float out[6]) {
    out[0] += w * b[0];
    out[1] += w * b[1];
    out[2] += w * b[2];
    out[3] += w * b[3];
    out[4] += w * b[4];
    out[5] += w * b[5];
}

/* The net of degree 1 at alpha (the last but one step of de Casteljau's scheme): C = sum alpha_a linear_a,
 * dC/d alpha_b - dC/d alpha_0 = degree (linear_b - linear_0). */
static inline void linear_net(const struct net* net, int degree, const float alpha[3], float (*restrict linear)[6]) {
    float w[10];
    int n = 0;
    int r;
    int k;
    for (r = 0; r < 3; ++r)
        for (k = 0; k < 6; ++k) linear[r][k] = 0.0f;
    bernstein(degree, alpha, w);
    for (r = 0; r < degree; ++r)
        for (k = 0; k <= r; ++k, ++n) {
            if (w[n] == 0.0f) continue; /* on edges and vertices most are */
            add_block(w[n], net->block[n], linear[0]);
            add_block(w[n], net->block[n + r + 1], linear[1]);
            add_block(w[n], net->block[n + r + 2], linear[2]);
        }
}

static inline void evaluate_c(float linear[3][6], const float alpha[3], float c[6]) {
    int i;
    for (i = 0; i < 6; ++i) c[i] = alpha[0] * linear[0][i] + alpha[1] * linear[1][i] + alpha[2] * linear[2][i];
}

/* ---- fixed vertices ------------------------------------------------------------------------------------------- */

/* The fraction of alpha on fixed vertices. */
static inline float fixed_fraction(const struct haptable_model* model, const struct haptable_contact* contact) {
    float fraction = 0.0f;
    int corner;
    for (corner = 0; corner < 3; ++corner)
        if (model->patch[contact->patch][corner] >= model->free_count) fraction += contact->alpha[corner];
    return fraction;
}

static inline float third_of_trace(const float s[6]) { return (s[0] + s[1] + s[2]) * (1.0f / 3.0f); }

/* What C's diagonal lacks to the fixed vertices' fraction of 1 / rigid_stiffness. */
static inline float missing_of(const struct haptable_model* model, float fraction, const float c[6]) {
    return fraction / model->rigid_stiffness_n_per_m - third_of_trace(c);
}

/* Lifts C's diagonal by what it lacks. Returns 1 where it did. */
static inline int lift(const struct haptable_model* model, float fraction, float c[6]) {
    float missing;
    int i;
    if (fraction <= 0.0f) return 0;
    missing = missing_of(model, fraction, c);
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

static inline struct factored factor(const float c[6]) {
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

static inline void solve(const struct factored* f, const float b[3], float x[3]) {
    const float y1 = b[1] - f->l10 * b[0];
    const float y2 = b[2] - f->l20 * b[0] - f->l21 * y1;
    x[2] = y2 * f->inverse[2];
    x[1] = y1 * f->inverse[1] - f->l21 * x[2];
    x[0] = b[0] * f->inverse[0] - f->l10 * x[1] - f->l20 * x[2];
}

static inline void load_of(const struct haptable_model* model, const struct net* net, int degree,
                           const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    float linear[3][6];
    float c[6];
    linear_net(net, degree, contact->alpha, linear);
    evaluate_c(linear, contact->alpha, c);
    haptable_compliance_solve(model, contact, finger_m, c, load_n);
}

/* ---- the energy ----------------------------------------------------------------------------------------------- */

/* f . B f of every block; less the third of its trace times f . f where C is lifted. */
static inline void square_net(const struct net* net, const float f[3], int lifted,
                              float square[HAPTABLE_COMPLIANCE_CONTROLS]) {
    const float p[6] = {f[0] * f[0],        f[1] * f[1],        f[2] * f[2],
                        2.0f * f[0] * f[1], 2.0f * f[1] * f[2], 2.0f * f[2] * f[0]};
    int n;
    for (n = 0; n < net->count; ++n) {
        const float* b = net->block[n];
        square[n] = b[0] * p[0] + b[1] * p[1] + b[2] * p[2] + b[3] * p[3] + b[4] * p[4] + b[5] * p[5];
        if (lifted) square[n] -= third_of_trace(b) * (p[0] + p[1] + p[2]);
    }
}

/* A step of de Casteljau's scheme from degree to degree - 1, in place: what it writes it has read. */
static inline void reduce(int degree, const float alpha[3], float* net) {
    int n = 0;
    int r;
    int k;
    for (r = 0; r < degree; ++r)
        for (k = 0; k <= r; ++k, ++n)
            /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): a net of that degree is whole */
            net[n] = alpha[0] * net[n] + alpha[1] * net[n + r + 1] + alpha[2] * net[n + r + 2];
}

/* A block's part that is not isotropic: what C's derivatives are made of where C is lifted. */
static inline void without_trace(float b[6]) {
    const float third = third_of_trace(b);
    int i;
    for (i = 0; i < 3; ++i) b[i] -= third;
}

/* C_b f (b = 1, 2) of a load f from the net of degree 1 (Farin). */
static inline void vary(int degree, float linear[3][6], const float f[3], int lifted, float first_m[2][3]) {
    const float first = (float)degree;
    int b;
    for (b = 0; b < 2; ++b) {
        float block[6];
        int i;
        for (i = 0; i < 6; ++i) block[i] = first * (linear[b + 1][i] - linear[0][i]);
        if (lifted) without_trace(block);
        vec_symmetric_product(block, f, first_m[b]); /* cppcheck-suppress uninitvar ; it is written here */
    }
}

/* f^T C_bc f (11, 12, 22) from the net of degree 2: 200 110 101 020 011 002. */
static inline void vary_twice(const struct net* net, int degree, const float alpha[3], const float f[3], int lifted,
                              float second_j[3]) {
    const float second = (float)(degree * (degree - 1));
    float q[HAPTABLE_COMPLIANCE_CONTROLS];
    square_net(net, f, lifted, q);
    if (degree == 4) {
        reduce(4, alpha, q);
        reduce(3, alpha, q);
    }
    second_j[0] = second * (q[3] - 2.0f * q[1] + q[0]);
    second_j[1] = second * (q[4] - q[1] - q[2] + q[0]);
    second_j[2] = second * (q[5] - 2.0f * q[2] + q[0]);
}

/* The lifted diagonal's own slope: that of the fixed fraction's compliance, times f. */
static inline void vary_fraction(const struct haptable_model* model, uint16_t patch, const float f[3],
                                 float first_m[2][3]) {
    const uint16_t* vertex = model->patch[patch];
    const float compliance = 1.0f / model->rigid_stiffness_n_per_m;
    const int fixed0 = vertex[0] >= model->free_count;
    vec_add_scaled(compliance * (float)((vertex[1] >= model->free_count) - fixed0), f, first_m[0]);
    vec_add_scaled(compliance * (float)((vertex[2] >= model->free_count) - fixed0), f, first_m[1]);
}

/* What C lacks may change its sign within HAPTABLE_CORRECTION of a point, to first order and a tenth. */
#define HAPTABLE_LIFT_REACH (1.1f * HAPTABLE_CORRECTION)

/* 1 where the lift may begin or end there. before: C is not lifted yet. */
static inline int is_at_lift(const struct haptable_model* model, uint16_t patch, float fraction, int degree,
                             float linear[3][6], const float c[6]) {
    const uint16_t* vertex = model->patch[patch];
    const float compliance = 1.0f / model->rigid_stiffness_n_per_m;
    const float missing = missing_of(model, fraction, c);
    const float reach = HAPTABLE_LIFT_REACH * (float)degree;
    float steepest = 0.0f;
    int b;
    for (b = 1; b < 3; ++b) {
        const int more = (vertex[b] >= model->free_count) - (vertex[0] >= model->free_count);
        const float slope =
            compliance * (float)more / (float)degree - third_of_trace(linear[b]) + third_of_trace(linear[0]);
        steepest += slope < 0.0f ? -slope : slope;
    }
    return missing <= reach * steepest && missing >= -reach * steepest;
}

static inline void forget_slope(struct haptable_energy* energy) {
    const float zero = 0.0f;
    int b;
    for (b = 0; b < 2; ++b)
        energy->load_gradient_n[b][0] = energy->load_gradient_n[b][1] = energy->load_gradient_n[b][2] = zero / zero;
}

/* Curvature and the load's slope: r_b = e_b + C_b f. before: hessian_j is f^T C_bc f. */
static inline void bend(const struct factored* factored, float e[2][3], float first_m[2][3],
                        struct haptable_energy* energy) {
    float s_r[2][3];
    int b;
    for (b = 0; b < 2; ++b) {
        vec_add_scaled(1.0f, first_m[b], e[b]);
        solve(factored, e[b], s_r[b]);
        vec_zero(energy->load_gradient_n[b]);
        vec_add_scaled(-1.0f, s_r[b], energy->load_gradient_n[b]);
    }
    energy->gauss_newton_j[0] = vec_dot(e[0], s_r[0]);
    energy->gauss_newton_j[1] = vec_dot(e[0], s_r[1]);
    energy->gauss_newton_j[2] = vec_dot(e[1], s_r[1]);
    for (b = 0; b < 3; ++b) energy->hessian_j[b] = energy->gauss_newton_j[b] - 0.5f * energy->hessian_j[b];
}

static inline void energy_of(const struct haptable_model* model, const struct net* net, int degree,
                             const struct haptable_contact* contact, const float finger_m[3],
                             enum haptable_energy_terms terms, struct haptable_energy* energy) {
    const int whole = terms == HAPTABLE_ENERGY_ALL;
    float* f = energy->load_n;
    struct factored factored;
    float first_m[2][3];
    int lifted;
    int steps = 0; /* the load's slope does */
    {              /* what a scope ends with, the next one's stack is made of */
        float linear[3][6];
        float c[6];
        const float fraction = fixed_fraction(model, contact);
        linear_net(net, degree, contact->alpha, linear);
        evaluate_c(linear, contact->alpha, c);
        if (whole && fraction > 0.0f) steps = is_at_lift(model, contact->patch, fraction, degree, linear, c);
        lifted = lift(model, fraction, c);
        if (whole) {
            float u[3];
            vec_sub(finger_m, contact->god_object_m, u);
            factored = factor(c);
            solve(&factored, u, f);
            energy->energy_j = 0.5f * vec_dot(u, f);
        }
        vary(degree, linear, f, lifted, first_m);
    }
    if (lifted) vary_fraction(model, contact->patch, f, first_m);
    if (whole) vary_twice(net, degree, contact->alpha, f, lifted, energy->hessian_j);
    {
        const float* origin = vertex_of(model, contact->patch, 0);
        float e[2][3];
        int b;
        vec_sub(vertex_of(model, contact->patch, 1), origin, e[0]);
        vec_sub(vertex_of(model, contact->patch, 2), origin, e[1]);
        for (b = 0; b < 2; ++b) energy->gradient_j[b] = -vec_dot(e[b], f) - 0.5f * vec_dot(f, first_m[b]);
        if (whole) bend(&factored, e, first_m, energy);
        if (steps) forget_slope(energy);
    }
}

#endif
