/* SPDX-License-Identifier: MIT
 *
 * g = argmin E(g) over the surface, E(g) = 1/2 u^T S(g) u, u = x - g, downhill from where g was
 *
 * Within a patch: Newton's step with E's own second derivatives, with their positive part where they are not positive
 * definite, cut at the patch's border and halved until E does not grow. At an edge the patch across is asked, at a
 * vertex the patches around it. Why the energy is never made: with g at a minimum, dE/dx = S u (envelope theorem), and
 * where the minimum ends, g goes to one that is lower.
 */
#include "contact.h"
#include "surface.h"

/* A point of the surface and the energy there. */
struct point {
    struct haptable_contact at;
    struct haptable_energy energy;
};

/* The walk of one tick. */
struct walk {
    const struct haptable_model* model;
    const float* x_m;
    int steps; /* evaluations so far */
    int nearest_steps;
};

static void evaluate(struct walk* walk, struct point* point) {
    ++walk->steps;
    walk->model->energy(walk->model, &point->at, walk->x_m, &point->energy);
}

/* ---- ways within one patch ------------------------------------------------------------------------------------ */

/* dE by alpha_c and the second derivatives, alpha_0 taken as the one that gives way. */
static float slope_of(const struct haptable_energy* e, int c) { return c == 0 ? 0.0f : e->slope_j[c - 1]; }
static float second_of(const float h[3], int c, int d) { return c == 0 || d == 0 ? 0.0f : h[c + d - 2]; }

/* d = -H^-1 slope; 0 where H is not positive definite beyond rounding. */
static int newton(const float h[3], const float slope[2], float d[3]) {
    const float determinant = h[0] * h[2] - h[1] * h[1];
    if (!(h[0] > 0.0f && h[2] > 0.0f && determinant > 1e-5f * h[0] * h[2])) return 0;
    d[1] = (h[1] * slope[1] - h[2] * slope[0]) / determinant;
    d[2] = (h[1] * slope[0] - h[0] * slope[1]) / determinant;
    d[0] = -d[1] - d[2];
    return 1;
}

/* Where E bends downwards its positive part alone would give short steps: they are made this much longer. */
#define STRIDE 8.0f

/* A way downhill inside the patch's plane, as a change of the area coordinates. */
static void way_in_plane(const struct haptable_energy* e, float d[3]) {
    if (newton(e->curvature_j, e->slope_j, d)) return;
    if (newton(e->lower_bound_j, e->slope_j, d)) {
        int c;
        for (c = 0; c < 3; ++c) d[c] *= STRIDE;
        return;
    }
    /* A sliver: each coordinate on its own. */
    d[1] = e->lower_bound_j[0] > 0.0f ? -0.5f * e->slope_j[0] / e->lower_bound_j[0] : 0.0f;
    d[2] = e->lower_bound_j[2] > 0.0f ? -0.5f * e->slope_j[1] / e->lower_bound_j[2] : 0.0f;
    d[0] = -d[1] - d[2];
}

/* The second derivative along the edge from corner a to corner b. */
static float second_along(const float h[3], int a, int b) {
    return second_of(h, a, a) - 2.0f * second_of(h, a, b) + second_of(h, b, b);
}

/* The way along the edge from corner a to corner b, forwards or backwards, to the minimum of E there. Returns by how
 * much E is foreseen to fall. */
static float way_along(const struct haptable_energy* e, int a, int b, float d[3]) {
    const float slope = slope_of(e, b) - slope_of(e, a);
    const float least = second_along(e->lower_bound_j, a, b) / STRIDE;
    float second = second_along(e->curvature_j, a, b);
    if (second < least) second = least;
    vec_zero(d);
    if (second <= 0.0f) return 0.0f;
    d[b] = -slope / second;
    d[a] = -d[b];
    return 0.5f * slope * slope / second;
}

/* 1 where the way keeps every coordinate that is zero from falling below. */
static int stays_inside(const float alpha[3], const float d[3]) {
    int c;
    for (c = 0; c < 3; ++c)
        if (alpha[c] == 0.0f && d[c] < 0.0f) return 0;
    return 1;
}

/* 1 where the way is longer than the tolerance. */
static int is_long(const struct haptable_model* model, uint16_t patch, const float d[3]) {
    float edge1[3];
    float edge2[3];
    float way[3] = {0.0f, 0.0f, 0.0f};
    vec_sub(vertex_of(model, patch, 1), vertex_of(model, patch, 0), edge1);
    vec_sub(vertex_of(model, patch, 2), vertex_of(model, patch, 0), edge2);
    vec_add_scaled(d[1], edge1, way);
    vec_add_scaled(d[2], edge2, way);
    return vec_dot(way, way) > model->tolerance_m * model->tolerance_m;
}

/* From a vertex (the corner where alpha is 1) along one of the patch's two edges there, where that leads down. Returns
 * by how much E is foreseen to fall, 0 where neither does. */
static float way_from_vertex(const struct point* point, int vertex, float d[3]) {
    float best = 0.0f;
    int turn;
    vec_zero(d);
    for (turn = 1; turn <= 2; ++turn) {
        const int other = vertex + turn > 2 ? vertex + turn - 3 : vertex + turn;
        float along[3];
        const float fall = way_along(&point->energy, vertex, other, along);
        if (along[other] <= 0.0f || fall <= best) continue;
        best = fall;
        vec_copy(along, d);
    }
    return best;
}

/* ---- ways over edges and around vertices ---------------------------------------------------------------------- */

/* The same point seen from another patch that shares its edge or vertex. */
static void seen_from(const struct haptable_model* model, const struct haptable_contact* from, uint16_t patch,
                      struct haptable_contact* to) {
    int corner;
    to->patch = patch;
    vec_zero(to->alpha);
    for (corner = 0; corner < 3; ++corner)
        if (from->alpha[corner] > 0.0f)
            to->alpha[corner_of(model, patch, model->patch[from->patch][corner])] = from->alpha[corner];
    vec_copy(from->god_object_m, to->god_object_m);
}

/* 1 where a way leads down within the point's own patch, off its edge or vertex or in its plane. */
static int way_inwards(const struct haptable_model* model, const struct point* point, float d[3]) {
    way_in_plane(&point->energy, d);
    return stays_inside(point->at.alpha, d) && is_long(model, point->at.patch, d);
}

/* On the edge opposite to `corner`: into this patch, into the one across, or along the edge. */
static int way_on_edge(struct walk* walk, int corner, struct point* here, float d[3]) {
    const uint16_t across = walk->model->neighbour[here->at.patch][corner];
    if (way_inwards(walk->model, here, d)) return 1;
    if (across != HAPTABLE_NONE) {
        struct point other;
        seen_from(walk->model, &here->at, across, &other.at);
        evaluate(walk, &other);
        if (way_inwards(walk->model, &other, d)) {
            *here = other;
            return 1;
        }
    }
    way_along(&here->energy, corner == 2 ? 0 : corner + 1, corner == 0 ? 2 : corner - 1, d);
    return is_long(walk->model, here->at.patch, d);
}

/* E's slope is linear on each patch's cone at the vertex, so there is a way down exactly where one of the edges leads
 * down: the steepest of them, and from it into the patch where that is better. */
static int way_on_vertex(struct walk* walk, int corner, struct point* here, float d[3]) {
    struct fan fan = fan_begin(walk->model, here->at.patch, corner);
    struct point start = *here;
    float best = 0.0f;
    int more;
    do {
        struct point next = start;
        float way[3];
        float fall;
        if (fan.patch != start.at.patch) {
            seen_from(walk->model, &start.at, fan.patch, &next.at);
            evaluate(walk, &next);
        }
        fall = way_from_vertex(&next, corner_of(walk->model, fan.patch, fan.vertex), way);
        if (fall > best && is_long(walk->model, fan.patch, way)) {
            best = fall;
            vec_copy(way, d);
            *here = next;
        }
        more = walk->steps < HAPTABLE_ENERGY_STEPS && fan_next(walk->model, &fan);
    } while (more);
    if (best <= 0.0f) return 0;
    {
        float inside[3];
        if (way_inwards(walk->model, here, inside)) vec_copy(inside, d);
    }
    return 1;
}

/* Finds a way down from the point, which may change the patch it is seen from. 0 at a minimum. */
static int find_way(struct walk* walk, struct point* here, float d[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(here->at.alpha, &corner);
    if (feature == ON_EDGE) return way_on_edge(walk, corner, here, d);
    if (feature == ON_VERTEX) return way_on_vertex(walk, corner, here, d);
    return way_inwards(walk->model, here, d);
}

/* ---- the slide ------------------------------------------------------------------------------------------------ */

/* Moves alpha by t d, at most to the border, where the coordinate that ends there is exactly 0. Returns how much of d
 * was gone. */
static float move_by(const struct haptable_model* model, const struct haptable_contact* from, const float d[3], float t,
                     struct haptable_contact* to) {
    int ends = -1;
    int c;
    int largest = 0;
    for (c = 0; c < 3; ++c)
        if (from->alpha[c] + t * d[c] <= 0.0f && d[c] < 0.0f && from->alpha[c] > 0.0f) {
            t = from->alpha[c] / -d[c];
            ends = c;
        }
    *to = *from;
    for (c = 0; c < 3; ++c) {
        to->alpha[c] = from->alpha[c] == 0.0f && d[c] <= 0.0f ? 0.0f : vec_clamp01(from->alpha[c] + t * d[c]);
        if (c == ends) to->alpha[c] = 0.0f;
        if (to->alpha[c] > to->alpha[largest]) largest = c;
    }
    to->alpha[largest] = 1.0f - to->alpha[largest == 0 ? 1 : 0] - to->alpha[largest == 2 ? 1 : 2];
    place(model, to);
    return t;
}

/* Changes of E below this share of it are lost in its rounding: there the slope decides, so that g settles where the
 * slope is 0 and not where E's digits end. */
#define ENERGY_ROUNDING 4e-6f

/* dE along d. */
static float slope_along(const struct haptable_energy* e, const float d[3]) {
    return e->slope_j[0] * d[1] + e->slope_j[1] * d[2];
}

/* 1 where a step of t d led down: E fell by more than its rounding; or it can only fall within it, and the way still
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
    int tries;
    for (tries = 0; tries < 8 && walk->steps < HAPTABLE_ENERGY_STEPS; ++tries) {
        struct point next;
        const float gone = move_by(walk->model, &here->at, d, t, &next.at);
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

/* Downhill to where E has no way down. Returns 0 where it met the limit. */
static int slide(struct walk* walk, struct point* here) {
    float d[3];
    evaluate(walk, here);
    while (walk->steps < HAPTABLE_ENERGY_STEPS && find_way(walk, here, d) && advance(walk, d, here)) {
    }
    return walk->steps < HAPTABLE_ENERGY_STEPS;
}

/* ---- letting go ----------------------------------------------------------------------------------------------- */

/* 1 where the finger is surely inside at the god-object: under a patch, not far aside, and pressing on it. */
static int surely_presses(const struct haptable_model* model, const struct point* here, const float x_m[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    float u[3];
    float depth;
    int corner = 0;
    if (feature_of(here->at.alpha, &corner) != INSIDE) return 0;
    patch_frame(model, here->at.patch, edge1, edge2, normal);
    vec_sub(x_m, here->at.god_object_m, u);
    depth = -vec_dot(normal, u);
    return depth > 0.0f && 2.0f * depth * depth > vec_dot(normal, normal) * vec_dot(u, u) &&
           vec_dot(normal, here->energy.load_n) < 0.0f;
}

/* One slide of a tick. Returns 1 when the finger is outside of the body, as the nearest point around the god-object
 * tells, which then is `nearest`. A finger inside keeps its contact even where the surface would have to be pulled: its
 * energy is still stored. A slide that met the limit keeps it too. */
static int has_left(struct walk* walk, struct point* here, struct haptable_contact* nearest,
                    struct haptable_counters* counters) {
    const int rests = slide(walk, here);
    int found;
    if (!rests) ++counters->walk_limits;
    if ((uint32_t)walk->steps > counters->most_energies) counters->most_energies = (uint32_t)walk->steps;
    if (surely_presses(walk->model, here, walk->x_m)) return 0;
    *nearest = here->at;
    found = contact_slide(walk->model, walk->x_m, nearest, &walk->nearest_steps);
    if ((uint32_t)walk->nearest_steps > counters->most_steps) counters->most_steps = (uint32_t)walk->nearest_steps;
    return found && surface_is_outside(walk->model, nearest, walk->x_m);
}

/* Moves the god-object of one tick. Conditions as for the nearest one, but that it rests where E has no way down.
 * cost: at most HAPTABLE_ENERGY_STEPS + 2 HAPTABLE_SLIDES evaluations, the walk of the nearest god-object, and
 *       HAPTABLE_SLIDES queries of the spatial index. */
void haptable_god_object_least_energy(const struct haptable_model* model, struct haptable_contact* contact,
                                      struct haptable_way* way, const float x_m[3],
                                      struct haptable_counters* counters) {
    struct walk walk;
    struct point here;
    struct haptable_contact nearest;
    int slides;
    walk.model = model;
    walk.steps = 0;
    walk.nearest_steps = 0;
    walk.x_m = x_m;
    for (slides = 0; slides < HAPTABLE_SLIDES; ++slides) {
        if (contact->patch == HAPTABLE_NONE && !surface_enter(model, x_m, way, contact, counters)) return;
        int left;
        here.at = *contact;
        left = has_left(&walk, &here, &nearest, counters);
        *contact = here.at;
        if (!left) return;
        surface_way(nearest.god_object_m, x_m, nearest.patch, way);
        contact->patch = HAPTABLE_NONE;
    }
    ++counters->slide_limits;
}
