/* SPDX-License-Identifier: MIT
 *
 * g = argmin E(g) over the surface, E(g) = 1/2 u^T S(g) u, u = x - g, downhill from where g was
 *
 * A tick first follows: g at a minimum goes with the finger as the minimum does, to first order, and Newton's step
 * corrects that. Where it does not do, g slides: Newton's steps with E's own second derivatives, their sizes where they
 * are not positive definite, cut at the patch's border and halved until E does not grow. At an edge the patch across is
 * asked, at a vertex the edges around it; all of them have the same load, so that only the gradient is taken there.
 * A tick that has no steps left stays where it is, and the next goes on: E only falls.
 * Why no energy is made: with g at a minimum, dE/dx = S u (envelope theorem), and where the minimum ends, g goes to one
 * that is lower.
 */
#include "haptable_bounds.h"
#include "haptable_compliance.h"
#include "haptable_contact.h"
#include "haptable_entry.h"
#include "haptable_patch.h"
#include "haptable_surface.h"

/* A point of the surface and the energy there. */
struct point {
    struct haptable_contact at;
    struct haptable_energy energy;
};

/* The walk of one tick. */
struct walk {
    const struct haptable_model* model;
    const float* x_m;
    const struct haptable_contact* freed; /* with friction: where it was; the servo's contact is held. Or NULL */
    int steps;                            /* of its evaluations so far */
    int is_taken;                         /* the load is known where it begins to slide */
    int rests;                            /* it is where no direction leads down; or it met the limit */
    int nearest_steps;
};

static void evaluate(struct walk* walk, struct point* point) {
    walk->steps += STEPS_OF_ENERGY;
    walk->model->energy(walk->model, &point->at, walk->x_m, HAPTABLE_ENERGY_ALL, &point->energy);
}

/* Without what is of second order. */
static void evaluate_slope(struct walk* walk, struct point* point) {
    ++walk->steps;
    walk->model->energy(walk->model, &point->at, walk->x_m, HAPTABLE_ENERGY_SLOPE, &point->energy);
}

/* The gradient alone. before: the load is known. */
static void evaluate_gradient(struct walk* walk, struct point* point) {
    ++walk->steps;
    walk->model->energy(walk->model, &point->at, walk->x_m, HAPTABLE_ENERGY_GRADIENT, &point->energy);
}

/* ---- search directions within one patch
 * ------------------------------------------------------------------------------------ */

/* dE by alpha_c and the second derivatives, alpha_0 being 1 less the others. */
static float slope_of(const struct haptable_energy* e, int c) { return c == 0 ? 0.0f : e->gradient_j[c - 1]; }
static float second_of(const float h[3], int c, int d) { return c == 0 || d == 0 ? 0.0f : h[c + d - 2]; }

/* A Hessian whose determinant is a smaller part of its diagonal's product is not positive definite beyond rounding. */
#define LEAST_DETERMINANT 1e-5f

/* H^-1 11 12 22; 0 where H is not positive definite beyond rounding. */
static int invert(const float h[3], float inverse[3]) {
    const float determinant = h[0] * h[2] - h[1] * h[1];
    if (!(h[0] > 0.0f && h[2] > 0.0f && determinant > LEAST_DETERMINANT * h[0] * h[2])) return 0;
    const float scale = 1.0f / determinant;
    inverse[0] = h[2] * scale;
    inverse[1] = -h[1] * scale;
    inverse[2] = h[0] * scale;
    return 1;
}

/* d = -H^-1 slope */
static inline void newton_by(const float inverse[3], const float slope[2], float d[3]) {
    d[1] = -(inverse[0] * slope[0] + inverse[1] * slope[1]);
    d[2] = -(inverse[1] * slope[0] + inverse[2] * slope[1]);
    d[0] = -d[1] - d[2];
}

/* The same; 0 where H is not positive definite beyond rounding. */
static int newton(const float h[3], const float slope[2], float d[3]) {
    float inverse[3];
    if (!invert(h, inverse)) return 0;
    newton_by(inverse, slope, d);
    return 1;
}

/* Where the curvature of E is less than this part of its positive part's, or negative, a step is as long as with its
 * magnitude, and no longer than with this part. */
#define LEAST_CURVATURE 0.125f

static float curvature_taken(float curvature) {
    const float upwards = vec_magnitude(curvature);
    return upwards > LEAST_CURVATURE ? upwards : LEAST_CURVATURE;
}

/* Two curvatures whose half difference, squared, is a smaller part of their mean's square, or smaller, are equal. */
#define EQUAL_CURVATURES 1e-6f
#define NO_CURVATURE2 1e-12f

/* H v (b = 0) */
static void times_hessian(const float h[3], const float v[3], float out[2]) {
    out[0] = h[0] * v[1] + h[1] * v[2];
    out[1] = h[1] * v[1] + h[2] * v[2];
}

/* Newton's step with H's curvatures over those of the positive part G, in H v = curvature G v, as curvature_taken has
 * them: that function of G^-1 H times G^-1 slope. Returns 0 where G is not positive definite. */
static int direction_over_curvature(const struct haptable_energy* e, float d[3]) {
    const float* h = e->hessian_j;
    const float* g = e->gauss_newton_j;
    const float determinant = g[0] * g[2] - g[1] * g[1];
    float inverse[3], slope[2], more_d[3];
    if (!invert(g, inverse)) return 0;
    newton_by(inverse, e->gradient_j, d);
    const float mean = 0.5f * (h[0] * g[2] - 2.0f * h[1] * g[1] + h[2] * g[0]) / determinant;
    const float half2 = mean * mean - (h[0] * h[2] - h[1] * h[1]) / determinant;
    const float half =
        half2 > EQUAL_CURVATURES * mean * mean && half2 > NO_CURVATURE2 ? half2 * vec_inverse_root(half2) : 0.0f;
    const float more = 1.0f / curvature_taken(mean + half);
    const float less = 1.0f / curvature_taken(mean - half);
    const float across = half > 0.0f ? 0.5f * (more - less) / half : 0.0f;
    times_hessian(h, d, slope);
    newton_by(inverse, slope, more_d);
    for (int c = 0; c < 3; ++c) d[c] = 0.5f * (more + less) * d[c] - across * (more_d[c] + mean * d[c]);
    return 1;
}

/* A search direction in the patch's plane, downhill, as a change of the area coordinates. */
static void direction_in_plane(const struct haptable_energy* e, float d[3]) {
    if (newton(e->hessian_j, e->gradient_j, d) || direction_over_curvature(e, d)) return;
    /* A sliver: each coordinate on its own. */
    d[1] = e->gauss_newton_j[0] > 0.0f ? -0.5f * e->gradient_j[0] / e->gauss_newton_j[0] : 0.0f;
    d[2] = e->gauss_newton_j[2] > 0.0f ? -0.5f * e->gradient_j[1] / e->gauss_newton_j[2] : 0.0f;
    d[0] = -d[1] - d[2];
}

/* The second derivative along the edge from corner a to corner b. */
static float second_along(const float h[3], int a, int b) {
    return second_of(h, a, a) - 2.0f * second_of(h, a, b) + second_of(h, b, b);
}

/* The direction along the edge from corner a to corner b, forwards or backwards, to the minimum of E there. Returns by
 * how much E is foreseen to fall. */
static float direction_along(const struct haptable_energy* e, int a, int b, float d[3]) {
    const float slope = slope_of(e, b) - slope_of(e, a);
    const float least = LEAST_CURVATURE * second_along(e->gauss_newton_j, a, b);
    float second = second_along(e->hessian_j, a, b);
    if (second < 0.0f) second = -second;
    if (second < least) second = least;
    vec_zero(d);
    if (second <= 0.0f) return 0.0f;
    d[b] = -slope / second;
    d[a] = -d[b];
    return 0.5f * slope * slope / second;
}

/* 1 where the direction keeps every coordinate that is zero from falling below. */
static int stays_inside(const float alpha[3], const float d[3]) {
    for (int c = 0; c < 3; ++c)
        if (alpha[c] == 0.0f && d[c] < 0.0f) return 0;
    return 1;
}

/* 1 where d is longer than the tolerance. */
static int is_long(const struct haptable_model* model, uint16_t patch, const float d[3]) {
    float edge1[3], edge2[3];
    float step[3] = {0.0f, 0.0f, 0.0f};
    vec_sub(vertex_of(model, patch, 1), vertex_of(model, patch, 0), edge1);
    vec_sub(vertex_of(model, patch, 2), vertex_of(model, patch, 0), edge2);
    vec_add_scaled(d[1], edge1, step);
    vec_add_scaled(d[2], edge2, step);
    return vec_length2(step) > model->tolerance_m * model->tolerance_m;
}

/* From a vertex (the corner where alpha is 1) along one of the patch's two edges there, where that leads down. Returns
 * by how much E is foreseen to fall, 0 where neither does. */
static float direction_from_vertex(const struct point* point, int vertex, float d[3]) {
    float best = 0.0f;
    vec_zero(d);
    for (int turn = 1; turn <= 2; ++turn) {
        const int other = turn == 1 ? next_corner(vertex) : previous_corner(vertex);
        float along[3];
        const float fall = direction_along(&point->energy, vertex, other, along);
        /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): a corner is 0, 1 or 2 */
        if (along[other] <= 0.0f || fall <= best) continue;
        best = fall;
        vec_copy(along, d);
    }
    return best;
}

/* ---- search directions over edges and around vertices
 * ---------------------------------------------------------------------- */

/* The same point on another patch that shares its edge or vertex. */
static void put_on(const struct haptable_model* model, const struct point* from, uint16_t patch, struct point* to) {
    to->at.patch = patch;
    vec_zero(to->at.alpha);
    for (int corner = 0; corner < 3; ++corner)
        if (from->at.alpha[corner] > 0.0f)
            to->at.alpha[corner_of(model, patch, model->patch[from->at.patch][corner])] = from->at.alpha[corner];
    vec_copy(from->at.god_object_m, to->at.god_object_m);
    vec_copy(from->energy.load_n, to->energy.load_n);
}

/* The same, with the gradient there. */
static void see_from(struct walk* walk, const struct point* from, uint16_t patch, struct point* to) {
    put_on(walk->model, from, patch, to);
    evaluate_gradient(walk, to);
}

/* 1 where a direction leads down within the point's own patch, off its edge or vertex or in its plane. */
static int direction_inwards(const struct haptable_model* model, const struct point* point, float d[3]) {
    direction_in_plane(&point->energy, d);
    return stays_inside(point->at.alpha, d) && is_long(model, point->at.patch, d);
}

/* E's slope from the point towards a corner of its patch. */
static float slope_towards(const struct point* point, int corner) {
    const float* alpha = point->at.alpha;
    const struct haptable_energy* e = &point->energy;
    return slope_of(e, corner) - alpha[1] * e->gradient_j[0] - alpha[2] * e->gradient_j[1];
}

/* The point on the edge opposite to `corner` as a patch across sees it. Returns 1 where E falls into that patch. */
static int falls_across(struct walk* walk, int corner, const struct point* here, struct point* other) {
    struct across across = across_begin(walk->model, here->at.patch, corner);
    for (; across.patch != HAPTABLE_NONE; across_next(walk->model, &across)) {
        int opposite = 0;
        see_from(walk, here, across.patch, other);
        (void)feature_of(other->at.alpha, &opposite);
        if (slope_towards(other, opposite) < 0.0f) return 1;
        if (walk->steps >= HAPTABLE_ENERGY_STEPS) return 0;
    }
    return 0;
}

/* On the edge opposite to `corner`: into this patch, into the one across, or along the edge. */
static int direction_on_edge(struct walk* walk, int corner, struct point* here, float d[3]) {
    struct point other;
    if (direction_inwards(walk->model, here, d)) return 1;
    if (falls_across(walk, corner, here, &other)) {
        evaluate(walk, &other);
        if (direction_inwards(walk->model, &other, d)) {
            *here = other;
            return 1;
        }
    }
    direction_along(&here->energy, next_corner(corner), previous_corner(corner), d);
    return is_long(walk->model, here->at.patch, d);
}

/* 1 where one of the patch's edges at the corner, where the point is, leads down. */
static int falls_along_edge(const struct point* point, int corner) {
    return slope_towards(point, next_corner(corner)) < 0.0f || slope_towards(point, previous_corner(corner)) < 0.0f;
}

/* How steeply the patch's edges at the corner, where the point is, lead down: the sum of what E falls by a length,
 * squared, N^2. */
static float falls_along_edges(const struct haptable_model* model, const struct point* point, int corner) {
    float sum = 0.0f;
    for (int turn = 1; turn <= 2; ++turn) {
        const int other = turn == 1 ? next_corner(corner) : previous_corner(corner);
        const float slope = slope_towards(point, other);
        if (slope < 0.0f) sum += slope * slope / gap2(vertex_of(model, point->at.patch, other), point->at.god_object_m);
    }
    return sum;
}

/* A search that has found a direction down leaves steps to go there: for the patch's second derivatives, and the point.
 */
enum { STEPS_OF_SEARCH = HAPTABLE_ENERGY_STEPS - 2 * STEPS_OF_ENERGY };

/* E's slope is linear on each patch's cone at the vertex, so there is a direction down exactly where one of the edges
 * leads down. Of the patches the one is taken where they do so most steeply, into it or along the better of its edges.
 */
static int direction_on_vertex(struct walk* walk, int corner, struct point* here, float d[3]) {
    struct fan fan = fan_begin(walk->model, here->at.patch, corner);
    float most = falls_along_edges(walk->model, here, corner);
    uint16_t patch = here->at.patch;
    struct point next;
    while (walk->steps < (most > 0.0f ? STEPS_OF_SEARCH : HAPTABLE_ENERGY_STEPS) && fan_next(walk->model, &fan)) {
        see_from(walk, here, fan.patch, &next);
        const float falls = falls_along_edges(walk->model, &next, fan.corner);
        if (falls <= most) continue;
        most = falls;
        patch = fan.patch;
    }
    if (most <= 0.0f) { /* with no steps left, the next tick goes on from where this one ends */
        if (walk->steps >= HAPTABLE_ENERGY_STEPS && fan.patch != here->at.patch) here->at = next.at;
        return 0;
    }
    if (patch != here->at.patch) { /* again: a copy of the best one would lie on the stack through every tick */
        put_on(walk->model, here, patch, &next);
        evaluate(walk, &next);
        *here = next;
    }
    if (direction_inwards(walk->model, here, d)) return 1;
    (void)feature_of(here->at.alpha, &corner);
    return direction_from_vertex(here, corner, d) > 0.0f && is_long(walk->model, patch, d);
}

/* Finds a direction down from the point, which may change the patch it is seen from. 0 at a minimum. */
static int find_direction(struct walk* walk, struct point* here, float d[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(here->at.alpha, &corner);
    if (feature == ON_EDGE) return direction_on_edge(walk, corner, here, d);
    if (feature == ON_VERTEX) return direction_on_vertex(walk, corner, here, d);
    return direction_inwards(walk->model, here, d);
}

/* ---- the slide ------------------------------------------------------------------------------------------------ */

/* Changes of E below this fraction of it are lost in its rounding: there the slope decides, so that g rests where the
 * slope is 0 and not where E's digits end. */
#define ENERGY_ROUNDING 4e-6f

/* dE along d. */
static float slope_along(const struct haptable_energy* e, const float d[3]) {
    return e->gradient_j[0] * d[1] + e->gradient_j[1] * d[2];
}

/* 1 where a step of t d led down: E fell by more than its rounding; or it can only fall within it, and d still
 * leads down at the patch's border, or has become half as steep. */
static int is_down(const struct haptable_energy* from, const struct haptable_energy* to, const float d[3], float t,
                   int cut) {
    const float rounding = from->energy_j * ENERGY_ROUNDING;
    const float before = slope_along(from, d);
    const float after = slope_along(to, d);
    if (to->energy_j < from->energy_j - rounding) return 1;
    if (-0.5f * t * before > rounding) return to->energy_j < from->energy_j;
    return (cut && after <= 0.0f) || 4.0f * after * after <= before * before;
}

/* Goes along d, half as far where that does not lead down. Returns 0, and stays, where none of eight tries does. */
static int advance(struct walk* walk, const float d[3], struct point* here) {
    float t = 1.0f;
    for (int tries = 0; tries < 8 && walk->steps < HAPTABLE_ENERGY_STEPS; ++tries) {
        struct point next;
        const float gone = haptable_patch_move(walk->model, &here->at, d, t, &next.at);
        evaluate(walk, &next);
        if (is_down(&here->energy, &next.energy, d, gone, gone < t)) {
            *here = next;
            return 1;
        }
        t = 0.5f * gone;
        if (-t * slope_along(&here->energy, d) < here->energy.energy_j * ENERGY_ROUNDING) return 0;
    }
    return 0;
}

/* Downhill to where no direction leads down. Returns 0 where it met the limit. before: the energy is taken. */
static int slide(struct walk* walk, struct point* here) {
    float d[3] = {0.0f, 0.0f, 0.0f};
    while (walk->steps < HAPTABLE_ENERGY_STEPS && find_direction(walk, here, d) && advance(walk, d, here)) {
    }
    return walk->steps < HAPTABLE_ENERGY_STEPS;
}

/* ---- following ------------------------------------------------------------------------------------------------ */

/* Moves alpha by d within the patch's inside or the edge that it is on. Returns 0, and leaves the point, where d leads
 * off it. */
static int move_on(const struct haptable_model* model, const float d[3], struct haptable_contact* point) {
    float alpha[3];
    for (int c = 0; c < 3; ++c) {
        alpha[c] = point->alpha[c] + d[c];
        if (point->alpha[c] == 0.0f ? d[c] != 0.0f : alpha[c] <= 0.0f) return 0;
    }
    haptable_patch_complete(alpha);
    vec_copy(alpha, point->alpha);
    place(model, point);
    return 1;
}

/* d from alpha_1 and alpha_2. */
static void direction_of(float d1, float d2, float d[3]) {
    d[1] = d1;
    d[2] = d2;
    d[0] = -(d1 + d2);
}

/* 1 where E falls into neither patch of the edge opposite to `corner`, and is convex along it; d leads to its
 * minimum there. */
static int rests_on_edge(struct walk* walk, int corner, const struct point* here, float d[3]) {
    const int a = next_corner(corner);
    const int b = previous_corner(corner);
    struct point other;
    if (!(second_along(here->energy.hessian_j, a, b) > 0.0f) || slope_towards(here, corner) < 0.0f ||
        falls_across(walk, corner, here, &other))
        return 0;
    direction_along(&here->energy, a, b, d);
    return 1;
}

/* Newton's step d to the minimum of E nearby, without leaving the inside or the edge. Returns 0 where E has none
 * there. */
static int correction(struct walk* walk, const struct point* here, float d[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(here->at.alpha, &corner);
    if (feature == INSIDE) return newton(here->energy.hessian_j, here->energy.gradient_j, d);
    return feature == ON_EDGE && rests_on_edge(walk, corner, here, d);
}

/* 1 where the correction is so small that it ends the tick. */
static int is_small(const float d[3]) {
    for (int c = 0; c < 3; ++c)
        if (!(d[c] < HAPTABLE_CORRECTION && d[c] > -HAPTABLE_CORRECTION)) return 0;
    return 1;
}

/* 1 where it is known how the god-object goes with the finger: after a tick within a patch or on an edge, where E is
 * convex. */
static int is_known(float sensitivity_per_m[2][3]) {
    return vec_length2(sensitivity_per_m[0]) + vec_length2(sensitivity_per_m[1]) > 0.0f;
}

/* The load is taken to first order where neither it nor u = x - g changes by more than this part of itself: what is
 * left out is of the order of both squared, below 1e-4 of the load. The one alone does not tell: what the two do to the
 * load may cancel. */
#define LOAD_CORRECTION 2.5e-3f

/* Moves to the corrected point, with the load there: to first order where that does, or else evaluated. A load without
 * a derivative compares as neither. */
static void correct(struct walk* walk, const float d[3], const struct haptable_contact* corrected, struct point* here) {
    const float most = LOAD_CORRECTION * LOAD_CORRECTION;
    struct haptable_energy* e = &here->energy;
    const float moved2 = gap2(here->at.god_object_m, corrected->god_object_m);
    float change[3] = {0.0f, 0.0f, 0.0f};
    here->at = *corrected;
    vec_add_scaled(d[1], e->load_gradient_n[0], change);
    vec_add_scaled(d[2], e->load_gradient_n[1], change);
    if (vec_length2(change) <= most * vec_length2(e->load_n) && moved2 <= most * gap2(walk->x_m, here->at.god_object_m))
        vec_add_scaled(1.0f, change, e->load_n);
    else
        evaluate(walk, here);
}

/* How alpha_1 and alpha_2 of a minimum within a patch go with the finger: H d = -(derivative of the gradient by x) .
 * dx. */
static void sensitivity_in_plane(const struct haptable_energy* e, float sensitivity_per_m[2][3]) {
    float inverse[3];
    if (!invert(e->hessian_j, inverse)) return;
    for (int b = 0; b < 2; ++b) {
        vec_add_scaled(-inverse[b], e->load_gradient_n[0], sensitivity_per_m[b]);
        vec_add_scaled(-inverse[b + 1], e->load_gradient_n[1], sensitivity_per_m[b]);
    }
}

/* The same along the edge from corner a to corner b. */
static void sensitivity_along(const struct haptable_energy* e, int a, int b, float sensitivity_per_m[2][3]) {
    const float second = second_along(e->hessian_j, a, b);
    float rate[3] = {0.0f, 0.0f, 0.0f}; /* of alpha_b; that of alpha_a is the opposite */
    if (!(second > 0.0f)) return;
    if (a > 0) vec_add_scaled(1.0f / second, e->load_gradient_n[a - 1], rate);
    if (b > 0) vec_add_scaled(-1.0f / second, e->load_gradient_n[b - 1], rate);
    if (a > 0) vec_add_scaled(-1.0f, rate, sensitivity_per_m[a - 1]);
    if (b > 0) vec_add_scaled(1.0f, rate, sensitivity_per_m[b - 1]);
}

static void forget_sensitivity(struct haptable_servo* servo) {
    vec_zero(servo->sensitivity_per_m[0]);
    vec_zero(servo->sensitivity_per_m[1]);
}

/* What the next tick may foresee. */
static void find_sensitivity(const struct point* here, struct haptable_servo* servo) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(here->at.alpha, &corner);
    forget_sensitivity(servo);
    if (feature == INSIDE) sensitivity_in_plane(&here->energy, servo->sensitivity_per_m);
    if (feature == ON_EDGE)
        sensitivity_along(&here->energy, next_corner(corner), previous_corner(corner), servo->sensitivity_per_m);
}

/* Goes as the minimum goes with the finger. Returns 0, and stays, where the correction to that is not small. */
static int follow(struct walk* walk, float sensitivity_per_m[2][3], const float from_m[3], struct point* here) {
    const struct haptable_contact start = here->at;
    float motion[3], d[3];
    vec_sub(walk->x_m, from_m, motion);
    direction_of(vec_dot(sensitivity_per_m[0], motion), vec_dot(sensitivity_per_m[1], motion), d);
    if (move_on(walk->model, d, &here->at)) {
        evaluate(walk, here);
        struct haptable_contact end = here->at;
        if (correction(walk, here, d) && is_small(d) && move_on(walk->model, d, &end)) {
            correct(walk, d, &end, here);
            walk->is_taken = 1;
            return 1;
        }
    }
    here->at = start;
    return 0;
}

/* ---- letting go ----------------------------------------------------------------------------------------------- */

/* 1 where the finger is under the plane of the patch with that normal, not far aside, and pressing on it. */
static inline int presses_under(const float normal[3], const float u[3], const float load_n[3]) {
    const float depth = -vec_dot(normal, u);
    return depth > 0.0f && 2.0f * depth * depth > vec_length2(normal) * vec_length2(u) &&
           vec_dot(normal, load_n) < 0.0f;
}

static int presses_on(const struct haptable_model* model, uint16_t patch, const float u[3], const float load_n[3]) {
    float edge1[3], edge2[3], normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    return presses_under(normal, u, load_n);
}

/* 1 where the patch presses and is not so thin at a point of its edge from a to b that what lies beyond must press too.
 */
static int presses_from_edge(const struct haptable_model* model, uint16_t patch, uint16_t a, uint16_t b,
                             const float at_m[3], const float u[3], const float load_n[3]) {
    const int opposite = 3 - corner_of(model, patch, a) - corner_of(model, patch, b);
    return presses_on(model, patch, u, load_n) &&
           haptable_patch_ends_beyond(model, patch, opposite, at_m, HAPTABLE_EDGE_REACH * model->tolerance_m) < 0;
}

/* See surely_presses; on the edge opposite to `corner`. */
static int presses_on_edge(const struct haptable_model* model, const struct haptable_contact* at, int corner,
                           const float u[3], const float load_n[3]) {
    const uint16_t a = vertex_after(model, at->patch, corner);
    const uint16_t b = vertex_before(model, at->patch, corner);
    struct across across = across_begin(model, at->patch, corner);
    if (model->neighbour[at->patch][corner] == HAPTABLE_NONE) return 0;
    for (; across.patch != HAPTABLE_NONE; across_next(model, &across))
        if (!presses_from_edge(model, across.patch, a, b, at->god_object_m, u, load_n)) return 0;
    return presses_from_edge(model, at->patch, a, b, at->god_object_m, u, load_n);
}

/* See surely_presses; at an edge or a vertex, or next to one. */
static int presses_on_border(const struct haptable_model* model, const struct haptable_contact* here,
                             const float load_n[3], const float x_m[3]) {
    struct haptable_contact at = *here;
    int corner = 0;
    float u[3];
    haptable_patch_onto_border(model, &at);
    const enum place_on_patch feature = feature_of(at.alpha, &corner);
    vec_sub(x_m, at.god_object_m, u);
    if (feature == ON_EDGE) return presses_on_edge(model, &at, corner, u, load_n);
    if (!presses_on(model, at.patch, u, load_n)) return 0;
    if (feature == ON_VERTEX) {
        struct fan fan = fan_begin(model, at.patch, corner);
        while (fan_next(model, &fan))
            if (!presses_on(model, fan.patch, u, load_n)) return 0;
    }
    return 1;
}

/* 1 where the finger is surely inside at the god-object: it presses on all patches there. */
static inline int surely_presses(const struct haptable_model* model, const struct haptable_contact* at,
                                 const float load_n[3], const float x_m[3]) {
    float edge1[3], edge2[3], normal[3], u[3];
    if (haptable_patch_is_on_rim(at->alpha)) return presses_on_border(model, at, load_n, x_m);
    patch_frame(model, at->patch, edge1, edge2, normal);
    if (model->slivers && model->slivers->is_thin && haptable_patch_has_thin_frame(model, edge1, edge2, normal))
        return presses_on_border(model, at, load_n, x_m);
    vec_sub(x_m, at->god_object_m, u);
    return presses_under(normal, u, load_n);
}

int haptable_contact_surely_presses(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float x_m[3]) {
    return surely_presses(model, contact, contact->load_n, x_m);
}

static enum haptable_sight look_from(const struct walk* walk, struct haptable_servo* servo,
                                     const struct haptable_contact* from) {
    return haptable_surface_sight(walk->model, servo, from, walk->x_m);
}

/* Looks at the finger from where the god-object of a tick rests and, where it is not seen from there, from the nearest
 * point around that. A finger inside keeps its contact even where the surface would have to be pulled: its energy is
 * still stored. earlier: what a look of an earlier tick saw in this one. */
static enum haptable_sight look(struct walk* walk, struct haptable_servo* servo, const struct point* here,
                                enum haptable_sight earlier) {
    struct haptable_contact nearest = here->at;
    enum haptable_sight sight = earlier;
    if (earlier == HAPTABLE_SIGHT_UNFINISHED) return sight;
    if (surely_presses(walk->model, &here->at, here->energy.load_n, walk->x_m)) {
        servo->slide_patch = HAPTABLE_NONE;
        return HAPTABLE_SIGHT_INSIDE;
    }
    if (earlier != HAPTABLE_SIGHT_BLOCKED) sight = look_from(walk, servo, &here->at);
    if (sight == HAPTABLE_SIGHT_CLEAR || sight == HAPTABLE_SIGHT_UNFINISHED) return sight;
    if (sight == HAPTABLE_SIGHT_INSIDE && !walk->rests) return sight; /* it goes on: asked again where it rests */
    const int rests = haptable_contact_slide_on(walk->model, servo, walk->x_m, &nearest, &walk->nearest_steps);
    if (gap2(nearest.god_object_m, here->at.god_object_m) > 0.0f) sight = look_from(walk, servo, &nearest);
    return rests || sight == HAPTABLE_SIGHT_CLEAR ? sight : HAPTABLE_SIGHT_UNFINISHED;
}

static void note_energies(const struct walk* walk, struct haptable_servo* servo) {
    if ((uint32_t)walk->steps > servo->counters.most_energies) servo->counters.most_energies = (uint32_t)walk->steps;
}

/* What a contact stores, whose load is known. */
static float stored_by(const struct haptable_contact* contact, const float load_n[3], const float x_m[3]) {
    float u[3];
    vec_sub(x_m, contact->god_object_m, u);
    return 0.5f * vec_dot(u, load_n);
}

/* 1 where the point stores no more than the contact: with friction it may be elsewhere. before: its load is known. */
static int stores_no_more(const struct walk* walk, const struct haptable_servo* servo, const struct point* here) {
    return !walk->freed || stored_by(&here->at, here->energy.load_n, walk->x_m) <=
                               stored_by(&servo->contact, servo->contact.load_n, walk->x_m);
}

/* To where the contact is, whose load is known. */
static void go_back(const struct haptable_servo* servo, struct point* here) {
    here->at = servo->contact;
    vec_copy(servo->contact.load_n, here->energy.load_n);
}

/* Slides on from where it is or, where that stores more than the contact, from there. Returns 0 where it met the limit.
 */
static int slide_from(struct walk* walk, const struct haptable_servo* servo, struct point* here) {
    int is_whole = !walk->is_taken;
    if (is_whole) evaluate(walk, here);
    if (!stores_no_more(walk, servo, here)) {
        go_back(servo, here);
        is_whole = 0;
    }
    if (walk->steps >= HAPTABLE_ENERGY_STEPS) return 0;
    if (!is_whole) evaluate(walk, here);
    return slide(walk, here);
}

/* 1 where E falls along an edge of another patch around the vertex at `corner`, or no step is left to tell: then `seen`
 * is the same point on that one. */
static int falls_around(struct walk* walk, int corner, const struct point* here, struct point* seen) {
    struct fan fan = fan_begin(walk->model, here->at.patch, corner);
    while (fan_next(walk->model, &fan)) {
        see_from(walk, here, fan.patch, seen);
        if (falls_along_edge(seen, fan.corner) || walk->steps >= HAPTABLE_ENERGY_STEPS) return 1;
    }
    return 0;
}

int haptable_contact_falls(const struct haptable_model* model, const float x_m[3], int most, uint16_t* looks,
                           struct haptable_contact* contact) {
    struct walk walk = {.model = model, .x_m = x_m, .steps = HAPTABLE_ENERGY_STEPS - most + (int)*looks};
    struct point here, seen;
    int corner = 0;
    here.at = *contact;
    vec_copy(contact->load_n, here.energy.load_n); /* cppcheck-suppress uninitvar ; it is written here */
    const int falls = feature_of(contact->alpha, &corner) == ON_EDGE ? falls_across(&walk, corner, &here, &seen)
                                                                     : falls_around(&walk, corner, &here, &seen);
    if (falls) {
        contact->patch = seen.at.patch;
        vec_copy(seen.at.alpha, contact->alpha);
    }
    *looks = (uint16_t)(walk.steps - HAPTABLE_ENERGY_STEPS + most);
    return falls;
}

/* 1 where it is on a vertex and no edge there leads down, so that it rests on. Otherwise it is seen from a patch with
 * an edge that leads down or, where the tick's steps end before, from the last: there the next search begins. */
static int rests_on_vertex(struct walk* walk, struct point* here) {
    int corner = 0;
    struct point seen;
    if (feature_of(here->at.alpha, &corner) != ON_VERTEX) return 0;
    evaluate_slope(walk, here);
    walk->is_taken = 1;
    if (falls_along_edge(here, corner)) return 0;
    if (!falls_around(walk, corner, here, &seen)) return 1;
    here->at = seen.at;
    return 0;
}

/* Goes with the finger, or rests. Returns 0 where it has to slide. */
static int goes_on(struct walk* walk, struct haptable_servo* servo, struct point* here) {
    return is_known(servo->sensitivity_per_m) ? follow(walk, servo->sensitivity_per_m, servo->finger_m, here)
                                              : rests_on_vertex(walk, here);
}

/* To where the god-object of a tick rests. Where it rested and the finger stays, it stays to the last bit. */
static void minimise(struct walk* walk, struct haptable_servo* servo, int is_new, struct point* here) {
    const int rested = !is_new && is_known(servo->sensitivity_per_m);
    here->at = walk->freed ? *walk->freed : servo->contact;
    vec_copy(here->at.load_n, here->energy.load_n);
    walk->rests = 1;
    if (rested && gap2(walk->x_m, servo->finger_m) == 0.0f) return;
    walk->rests =
        (!is_new && goes_on(walk, servo, here) && stores_no_more(walk, servo, here)) || slide_from(walk, servo, here);
    if (walk->rests) {
        find_sensitivity(here, servo);
    } else {
        ++servo->counters.walk_limits;
        forget_sensitivity(servo);
    }
    note_energies(walk, servo);
}

/* 1 where less energy is stored at the point where the segment enters than at the contact; then `here` is there, a new
 * contact. */
static int enters_lower(struct walk* walk, struct haptable_servo* servo, struct point* here) {
    const struct haptable_contact* contact = &servo->contact;
    if (walk->steps >= HAPTABLE_ENERGY_STEPS) return 0;
    haptable_segment_entry(walk->model, &servo->segment, &here->at);
    evaluate(walk, here);
    walk->is_taken = 1;
    note_energies(walk, servo);
    if (here->energy.energy_j >= stored_by(contact, contact->load_n, walk->x_m)) return 0;
    walk->freed = 0;
    ++servo->counters.contacts;
    return 1;
}

/* Moves the god-object of one tick. Conditions as for the nearest one, but that it rests where E has no direction down,
 * and that contact goes over to another part of the surface only where that stores less.
 * cost: evaluations of at most MOST_ENERGIES steps, and the walk of the nearest god-object. */
void haptable_god_object_least_energy(const struct haptable_model* model, struct haptable_servo* servo,
                                      const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    const enum haptable_sight earlier = haptable_contact_look_on(model, servo);
    int is_new = contact->patch == HAPTABLE_NONE;
    struct walk walk = {.model = model, .x_m = x_m, .freed = haptable_freed_contact(model, servo)};
    struct point here;
    if (is_new && !haptable_surface_enter(model, servo, x_m)) return;
    for (int slides = 0; slides < HAPTABLE_SLIDES; ++slides) {
        minimise(&walk, servo, is_new, &here);
        *contact = here.at;
        vec_copy(here.energy.load_n, contact->load_n);
        if (haptable_contact_decide(model, servo, look(&walk, servo, &here, earlier))) return;
        if (!enters_lower(&walk, servo, &here)) return;
        *contact = here.at;
        vec_copy(here.energy.load_n, contact->load_n);
        is_new = 1;
    }
    ++servo->counters.slide_limits;
}
