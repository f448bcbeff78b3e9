/* SPDX-License-Identifier: MIT
 *
 * f = C^-1 u,   E = 1/2 u . f,   dE/db = -e_b . f - 1/2 f^T C_b f,   e_b = dg/db,   C_b = dC/db
 *
 * d2E/db dc = r_b^T C^-1 r_c - 1/2 f^T C_bc f with r_b = e_b + C_b f: the first term is never negative.
 *
 * What haptable_compliance.c (blocks in float32) and haptable_compliance_packed.c (in 16 bits) are made of: one file
 * for each, so that each has it inlined, and a model pays for one of them only.
 */
#ifndef HAPTABLE_POLYNOMIAL_H
#define HAPTABLE_POLYNOMIAL_H

#include "haptable_compliance.h"
#include "haptable_law.h"
#include "haptable_matrix.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

#include <stddef.h>

/* ---- the polynomial ------------------------------------------------------------------------------------------- */

static const struct haptable_compliance_form consistent_form = {2, {0, 3, 5}, {{4}, {2}, {1}}, {0}};
static const struct haptable_compliance_form mask_form = {
    4, {0, 10, 14}, {{11, 12, 13}, {9, 5, 2}, {1, 3, 6}}, {4, 7, 8}};

/* Control blocks in the order of exponents (n - r, r - k, k): block r (r + 1) / 2 + k, r = 0 .. n, k = 0 .. r. */
struct net {
    const float* block[HAPTABLE_COMPLIANCE_CONTROLS];
    int count;
};

/* The blocks of a patch, where they stand; nothing is put into `room`. An edge's blocks stand from its lower vertex to
 * its higher one; degree 2 has one of them. */
static inline void gather(const struct haptable_model* model, const struct haptable_compliance_form* form,
                          uint16_t patch, float (*room)[6], struct net* net) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const uint16_t* e = c->patch_edge[patch];
    (void)room;
    if (form->degree == 2) {
        net->count = 6;
        net->block[0] = c->vertex[v[0]];
        net->block[1] = c->edge[e[2]];
        net->block[2] = c->edge[e[1]];
        net->block[3] = c->vertex[v[1]];
        net->block[4] = c->edge[e[0]];
        net->block[5] = c->vertex[v[2]];
        return;
    }
    net->count = HAPTABLE_COMPLIANCE_CONTROLS;
    for (int corner = 0; corner < 3; ++corner) {
        const int forward = v[next_corner(corner)] < v[previous_corner(corner)];
        const float(*edge)[6] = &c->edge[3 * (size_t)e[corner]];
        const uint8_t* at = form->edge[corner];
        net->block[form->vertex[corner]] = c->vertex[v[corner]];
        net->block[at[0]] = edge[forward ? 0 : 2];
        net->block[at[1]] = edge[1];
        net->block[at[2]] = edge[forward ? 2 : 0];
        net->block[form->inside[corner]] = c->patch[3 * patch + corner];
    }
}

/* The blocks of a patch, expanded into `room`. Those of vertices, edges and patches stand in a row, an edge's from its
 * lower vertex to its higher one. */
static inline void gather_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                 uint16_t patch, float (*room)[6], struct net* net) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const uint32_t per_edge = form->degree - 1u;
    const uint32_t edges = model->vertex_count;
    const uint32_t patches = edges + per_edge * c->edge_count;
    net->count = form->degree == 4 ? HAPTABLE_COMPLIANCE_CONTROLS : 6;
    for (int corner = 0; corner < 3; ++corner) {
        const int forward = v[next_corner(corner)] < v[previous_corner(corner)];
        const uint32_t first = edges + per_edge * c->patch_edge[patch][corner];
        model->unpack(model, v[corner], room[form->vertex[corner]]);
        for (uint32_t i = 0; i < per_edge; ++i)
            model->unpack(model, first + (forward ? i : per_edge - 1u - i), room[form->edge[corner][i]]);
        if (form->degree == 4)
            model->unpack(model, patches + 3u * (uint32_t)patch + (uint32_t)corner, room[form->inside[corner]]);
    }
    for (int n = 0; n < net->count; ++n) net->block[n] = room[n];
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
    for (int r = 0; r < 3; ++r)
        for (int k = 0; k < 6; ++k) linear[r][k] = 0.0f;
    bernstein(degree, alpha, w);
    for (int r = 0; r < degree; ++r)
        for (int k = 0; k <= r; ++k, ++n) {
            if (w[n] == 0.0f) continue; /* on edges and vertices most are */
            add_block(w[n], net->block[n], linear[0]);
            add_block(w[n], net->block[n + r + 1], linear[1]);
            add_block(w[n], net->block[n + r + 2], linear[2]);
        }
}

static inline void evaluate_c(float linear[3][6], const float alpha[3], float c[6]) {
    for (int i = 0; i < 6; ++i) c[i] = alpha[0] * linear[0][i] + alpha[1] * linear[1][i] + alpha[2] * linear[2][i];
}

/* Sums of weighted blocks, with every number of a block a statement of its own: in registers, wide ones where there are
 * any. */
static inline void mix_three(const float w[3], const float a[6], const float b[6], const float c[6],
                             float* restrict out) {
    out[0] = w[0] * a[0] + w[1] * b[0] + w[2] * c[0];
    out[1] = w[0] * a[1] + w[1] * b[1] + w[2] * c[1];
    out[2] = w[0] * a[2] + w[1] * b[2] + w[2] * c[2];
    out[3] = w[0] * a[3] + w[1] * b[3] + w[2] * c[3];
    out[4] = w[0] * a[4] + w[1] * b[4] + w[2] * c[4];
    out[5] = w[0] * a[5] + w[1] * b[5] + w[2] * c[5];
}

static inline void mix_six(const float w[6], const float* const block[6], float* restrict out) {
    const float* a = block[0];
    const float* b = block[1];
    const float* c = block[2];
    const float* d = block[3];
    const float* e = block[4];
    const float* f = block[5];
    out[0] = w[0] * a[0] + w[1] * b[0] + w[2] * c[0] + w[3] * d[0] + w[4] * e[0] + w[5] * f[0];
    out[1] = w[0] * a[1] + w[1] * b[1] + w[2] * c[1] + w[3] * d[1] + w[4] * e[1] + w[5] * f[1];
    out[2] = w[0] * a[2] + w[1] * b[2] + w[2] * c[2] + w[3] * d[2] + w[4] * e[2] + w[5] * f[2];
    out[3] = w[0] * a[3] + w[1] * b[3] + w[2] * c[3] + w[3] * d[3] + w[4] * e[3] + w[5] * f[3];
    out[4] = w[0] * a[4] + w[1] * b[4] + w[2] * c[4] + w[3] * d[4] + w[4] * e[4] + w[5] * f[4];
    out[5] = w[0] * a[5] + w[1] * b[5] + w[2] * c[5] + w[3] * d[5] + w[4] * e[5] + w[5] * f[5];
}

static inline void add_three(const float w[3], const float* const block[3], float* restrict out) {
    float more[6];
    mix_three(w, block[0], block[1], block[2], more);
    for (int i = 0; i < 6; ++i) out[i] += more[i];
}

/* Bernstein's polynomials of degree 2, in the order of a net. */
static inline void bernstein_two(const float alpha[3], float w[6]) {
    w[0] = alpha[0] * alpha[0];
    w[1] = 2.0f * alpha[0] * alpha[1];
    w[2] = 2.0f * alpha[0] * alpha[2];
    w[3] = alpha[1] * alpha[1];
    w[4] = 2.0f * alpha[1] * alpha[2];
    w[5] = alpha[2] * alpha[2];
}

/* Those of degree 4: products of those of degree 2, by the pairs that have the same exponents. */
static inline void bernstein_four(const float alpha[3], float w[15]) {
    float q[6];
    bernstein_two(alpha, q);
    w[0] = q[0] * q[0];
    w[1] = 2.0f * q[0] * q[1];
    w[2] = 2.0f * q[0] * q[2];
    w[3] = 6.0f * q[0] * q[3];
    w[4] = 6.0f * q[0] * q[4];
    w[5] = 6.0f * q[0] * q[5];
    w[6] = 2.0f * q[1] * q[3];
    w[7] = 6.0f * q[2] * q[3];
    w[8] = 6.0f * q[1] * q[5];
    w[9] = 2.0f * q[2] * q[5];
    w[10] = q[3] * q[3];
    w[11] = 2.0f * q[3] * q[4];
    w[12] = 6.0f * q[3] * q[5];
    w[13] = 2.0f * q[4] * q[5];
    w[14] = q[5] * q[5];
}

/* The net of degree 2 at alpha of one of degree 4 (two steps of de Casteljau's scheme): every block of it a sum over
 * those of the six whose exponents are its own and two more. At a vertex it is the six blocks around that. */
static inline void quadratic_net(const struct net* net, const float alpha[3], enum place_on_patch feature, int corner,
                                 struct reduced* quadratic) {
    static const uint8_t at[6][6] = {{0, 1, 2, 3, 4, 5},    {1, 3, 4, 6, 7, 8},    {2, 4, 5, 7, 8, 9},
                                     {3, 6, 7, 10, 11, 12}, {4, 7, 8, 11, 12, 13}, {5, 8, 9, 12, 13, 14}};
    static const uint8_t around_vertex[3] = {0, 3, 5};
    float w[6];
    if (feature == ON_VERTEX) {
        for (int n = 0; n < 6; ++n) quadratic->block[n] = net->block[at[around_vertex[corner]][n]];
        return;
    }
    bernstein_two(alpha, w);
    for (int n = 0; n < 6; ++n) {
        const float* around[6];
        for (int m = 0; m < 6; ++m) around[m] = net->block[at[n][m]];
        mix_six(w, around, quadratic->room[n]); /* cppcheck-suppress uninitvar ; it is written here */
        quadratic->block[n] = quadratic->room[n];
    }
}

/* The net of degree 1 at alpha of one of degree 2: C = sum alpha_a linear_a, dC/d alpha_b - dC/d alpha_0 = degree
 * (linear_b - linear_0). */
static inline void linear_of(const float* const block[6], const float alpha[3], float linear[3][6]) {
    mix_three(alpha, block[0], block[1], block[2], linear[0]);
    mix_three(alpha, block[1], block[3], block[4], linear[1]);
    mix_three(alpha, block[2], block[4], block[5], linear[2]);
}

/* The same of one of degree 4: with Bernstein's polynomials of degree 3. */
static inline void linear_of_four(const struct net* net, const float alpha[3], float linear[3][6]) {
    static const uint8_t at[3][10] = {
        {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, {1, 3, 4, 6, 7, 8, 10, 11, 12, 13}, {2, 4, 5, 7, 8, 9, 11, 12, 13, 14}};
    float w[10];
    bernstein(4, alpha, w);
    for (int r = 0; r < 3; ++r) {
        const float* block[10];
        float last[6];
        for (int n = 0; n < 10; ++n) block[n] = net->block[at[r][n]];
        mix_six(w, block, linear[r]);
        mix_three(w + 6, block[6], block[7], block[8], last);
        for (int i = 0; i < 6; ++i) linear[r][i] += last[i] + w[9] * block[9][i];
    }
}

/* ---- the load ------------------------------------------------------------------------------------------------- */

/* C of degree 4 at once: half the work of its derivatives' nets. */
static inline void quartic_c(const struct net* net, const float alpha[3], float c[6]) {
    float w[15];
    bernstein_four(alpha, w);
    mix_six(w, net->block, c);
    add_three(w + 6, net->block + 6, c);
    add_three(w + 9, net->block + 9, c);
    add_three(w + 12, net->block + 12, c);
}

static inline void quadratic_c(const struct net* net, const float alpha[3], float c[6]) {
    float w[6];
    bernstein_two(alpha, w);
    mix_six(w, net->block, c);
}

/* c: C as it was inverted. */
static inline void load_of(const struct haptable_model* model, const struct net* net, int degree,
                           const struct haptable_contact* contact, const float finger_m[3], float c[6],
                           float load_n[3]) {
    if (degree == 4)
        quartic_c(net, contact->alpha, c);
    else
        quadratic_c(net, contact->alpha, c);
    haptable_compliance_solve(model, contact, finger_m, c, load_n);
}

/* ---- the energy ----------------------------------------------------------------------------------------------- */

/* The products of a load's numbers that f . B f is made of, for a block B. */
static inline void square_of_load(const float f[3], float p[6]) {
    p[0] = f[0] * f[0];
    p[1] = f[1] * f[1];
    p[2] = f[2] * f[2];
    p[3] = 2.0f * f[0] * f[1];
    p[4] = 2.0f * f[1] * f[2];
    p[5] = 2.0f * f[2] * f[0];
}

static inline float squared(const float b[6], const float p[6]) {
    return b[0] * p[0] + b[1] * p[1] + b[2] * p[2] + b[3] * p[3] + b[4] * p[4] + b[5] * p[5];
}

/* The net of degree 1 at a vertex: the blocks of it and of the two edges there. before: corner's alpha is 1. */
static inline void blocks_around_vertex(const struct net* net, int degree, int corner, const float* around[3]) {
    static const uint8_t quadratic[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    static const uint8_t quartic[3][3] = {{0, 1, 2}, {6, 10, 11}, {9, 13, 14}};
    const uint8_t* at = degree == 4 ? quartic[corner] : quadratic[corner];
    around[0] = net->block[at[0]];
    around[1] = net->block[at[1]];
    around[2] = net->block[at[2]];
}

/* A block's part that is not isotropic: what C's derivatives are made of where C is lifted. */
static inline void without_trace(float b[6]) {
    const float third = sym_third_of_trace(b);
    for (int i = 0; i < 3; ++i) b[i] -= third;
}

/* C_b f (b = 1, 2) of a load f from the net of degree 1 (Farin). */
static inline void vary(int degree, float linear[3][6], const float f[3], int lifted, float first_m[2][3]) {
    const float first = (float)degree;
    for (int b = 0; b < 2; ++b) {
        float block[6];
        for (int i = 0; i < 6; ++i) block[i] = first * (linear[b + 1][i] - linear[0][i]);
        if (lifted) without_trace(block);
        vec_symmetric_product(block, f, first_m[b]); /* cppcheck-suppress uninitvar ; it is written here */
    }
}

/* f^T C_bc f (11, 12, 22) from C's net of degree 2: 200 110 101 020 011 002. */
static inline void bend_net(const float* const block[6], int degree, const float f[3], int lifted, float second_j[3]) {
    const float second = (float)(degree * (degree - 1));
    float square[6], q[6];
    square_of_load(f, square);
    for (int n = 0; n < 6; ++n) {
        q[n] = squared(block[n], square);
        if (lifted) q[n] -= sym_third_of_trace(block[n]) * (square[0] + square[1] + square[2]);
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
    for (int b = 1; b < 3; ++b) {
        const int more = (vertex[b] >= model->free_count) - (vertex[0] >= model->free_count);
        const float slope =
            compliance * (float)more / (float)degree - sym_third_of_trace(linear[b]) + sym_third_of_trace(linear[0]);
        steepest += slope < 0.0f ? -slope : slope;
    }
    return missing <= reach * steepest && missing >= -reach * steepest;
}

/* Curvature and the load's slope: r_b = e_b + C_b f. before: hessian_j is f^T C_bc f. */
static inline void put_second_order(const struct sym_factored* factored, float e[2][3], float first_m[2][3],
                                    struct haptable_energy* energy) {
    float s_r[2][3];
    for (int b = 0; b < 2; ++b) {
        vec_add_scaled(1.0f, first_m[b], e[b]);
        sym_solve(factored, e[b], s_r[b]);
        vec_zero(energy->load_gradient_n[b]);
        vec_add_scaled(-1.0f, s_r[b], energy->load_gradient_n[b]);
    }
    energy->gauss_newton_j[0] = vec_dot(e[0], s_r[0]);
    energy->gauss_newton_j[1] = vec_dot(e[0], s_r[1]);
    energy->gauss_newton_j[2] = vec_dot(e[1], s_r[1]);
    for (int b = 0; b < 3; ++b) energy->hessian_j[b] = energy->gauss_newton_j[b] - 0.5f * energy->hessian_j[b];
}

/* The patch's edges from corner 0. */
static inline void edges_of(const struct haptable_model* model, uint16_t patch, float e[2][3]) {
    const float* origin = vertex_of(model, patch, 0);
    vec_sub(vertex_of(model, patch, 1), origin, e[0]);
    vec_sub(vertex_of(model, patch, 2), origin, e[1]);
}

/* The gradient alone, where C is not lifted, from the blocks of the net of degree 1. */
static inline void slope_of_load(const struct haptable_model* model, uint16_t patch, int degree,
                                 const float* const linear[3], struct haptable_energy* energy) {
    const float* f = energy->load_n;
    const float half = 0.5f * (float)degree;
    float square[6], e[2][3];
    square_of_load(f, square);
    const float first = half * squared(linear[0], square);
    edges_of(model, patch, e);
    energy->gradient_j[0] = first - half * squared(linear[1], square) - vec_dot(e[0], f);
    energy->gradient_j[1] = first - half * squared(linear[2], square) - vec_dot(e[1], f);
}

/* The same where it may be lifted. */
static inline void lifted_slope(const struct haptable_model* model, const struct haptable_contact* contact, int degree,
                                float fraction, float linear[3][6], struct haptable_energy* energy) {
    const float* f = energy->load_n;
    float first_m[2][3], c[6], e[2][3];
    evaluate_c(linear, contact->alpha, c);
    const int lifted = lift(model, fraction, c);
    vary(degree, linear, f, lifted, first_m);
    if (lifted) vary_fraction(model, contact->patch, f, first_m);
    edges_of(model, contact->patch, e);
    for (int b = 0; b < 2; ++b) energy->gradient_j[b] = -vec_dot(e[b], f) - 0.5f * vec_dot(f, first_m[b]);
}

/* The net of degree 1: at a vertex three of C's blocks. */
static inline void find_linear(const struct net* net, int degree, const float alpha[3], enum place_on_patch feature,
                               int corner, struct reduced* linear) {
    if (feature == ON_VERTEX) {
        blocks_around_vertex(net, degree, corner, linear->block);
        return;
    }
    if (degree == 2)
        linear_of(net->block, alpha, linear->room);
    else
        linear_of_four(net, alpha, linear->room);
    linear->block[0] = linear->room[0];
    linear->block[1] = linear->room[1];
    linear->block[2] = linear->room[2];
}

static inline void gradient_of(const struct haptable_model* model, const struct net* net, int degree,
                               const struct haptable_contact* contact, enum place_on_patch feature, int corner,
                               struct haptable_energy* energy) {
    const float fraction = fixed_fraction(model, contact);
    struct reduced linear;
    if (fraction > 0.0f) {
        float room[3][6];
        linear_net(net, degree, contact->alpha, room);
        lifted_slope(model, contact, degree, fraction, room, energy);
        return;
    }
    find_linear(net, degree, contact->alpha, feature, corner, &linear);
    slope_of_load(model, contact->patch, degree, linear.block, energy);
}

/* The energy, the load and the gradient. before: no fixed vertex has a part in the contact. */
static inline void energy_and_slope(const struct haptable_model* model, const struct net* net, int degree,
                                    const struct haptable_contact* contact, const float finger_m[3],
                                    enum place_on_patch feature, int corner, struct haptable_energy* energy) {
    const float* alpha = contact->alpha;
    struct reduced linear;
    float c[6], u[3];
    find_linear(net, degree, alpha, feature, corner, &linear);
    mix_three(alpha, linear.block[0], linear.block[1], linear.block[2], c);
    vec_sub(finger_m, contact->god_object_m, u);
    const struct sym_factored factored = sym_factor(c);
    sym_solve(&factored, u, energy->load_n);
    energy->energy_j = 0.5f * vec_dot(u, energy->load_n);
    slope_of_load(model, contact->patch, degree, linear.block, energy);
}

/* All of it, from C's net of degree 2. */
static inline void whole_energy(const struct haptable_model* model, const float* const block[6], int degree,
                                const struct haptable_contact* contact, const float finger_m[3],
                                struct haptable_energy* energy) {
    float* f = energy->load_n;
    struct sym_factored factored;
    float first_m[2][3], e[2][3];
    int lifted = 0;
    int steps = 0; /* the load's slope does */
    {
        float linear[3][6], c[6], u[3];
        const float fraction = fixed_fraction(model, contact);
        linear_of(block, contact->alpha, linear);
        mix_three(contact->alpha, linear[0], linear[1], linear[2], c);
        if (fraction > 0.0f) {
            steps = is_at_lift(model, contact->patch, fraction, degree, linear, c);
            lifted = lift(model, fraction, c);
        }
        vec_sub(finger_m, contact->god_object_m, u);
        factored = sym_factor(c);
        sym_solve(&factored, u, f);
        energy->energy_j = 0.5f * vec_dot(u, f);
        vary(degree, linear, f, lifted, first_m);
    }
    if (lifted) vary_fraction(model, contact->patch, f, first_m);
    bend_net(block, degree, f, lifted, energy->hessian_j);
    edges_of(model, contact->patch, e);
    for (int b = 0; b < 2; ++b) energy->gradient_j[b] = -vec_dot(e[b], f) - 0.5f * vec_dot(f, first_m[b]);
    put_second_order(&factored, e, first_m, energy);
    if (steps) {
        vec_no_number(energy->load_gradient_n[0]);
        vec_no_number(energy->load_gradient_n[1]);
    }
}

static inline void energy_of(const struct haptable_model* model, const struct net* net, int degree,
                             const struct haptable_contact* contact, const float finger_m[3],
                             enum haptable_energy_terms terms, struct haptable_energy* energy) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(contact->alpha, &corner);
    struct reduced quadratic;
    if (terms == HAPTABLE_ENERGY_LOAD) {
        float u[3];
        load_of(model, net, degree, contact, finger_m, energy->compliance_m_per_n, energy->load_n);
        vec_sub(finger_m, contact->god_object_m, u);
        energy->energy_j = 0.5f * vec_dot(u, energy->load_n);
    } else if (terms == HAPTABLE_ENERGY_GRADIENT) {
        gradient_of(model, net, degree, contact, feature, corner, energy);
    } else if (terms == HAPTABLE_ENERGY_SLOPE && fixed_fraction(model, contact) <= 0.0f) {
        energy_and_slope(model, net, degree, contact, finger_m, feature, corner, energy);
    } else if (degree == 4) {
        quadratic_net(net, contact->alpha, feature, corner, &quadratic);
        whole_energy(model, quadratic.block, degree, contact, finger_m, energy);
    } else {
        whole_energy(model, net->block, degree, contact, finger_m, energy);
    }
}

#endif
