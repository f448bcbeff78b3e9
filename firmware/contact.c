/* SPDX-License-Identifier: MIT
 *
 * g = argmin |x - g| over the surface, by descent from patch to neighbouring patch
 *
 * Why the walk ends: with g on a patch and q the point of that patch nearest to the finger x, |x - q|^2 <=
 * |x - g|^2 - |q - g|^2, because a triangle is convex. Every move to a neighbour therefore brings the god-object
 * nearer by more than tolerance_m squared, and no patch is visited twice.
 */
#include "contact.h"

#include "surface.h"

/* ---- nearest point of one patch ------------------------------------------------------------------------------- */

/* The nearest point of the edge opposite to `corner`. */
static void nearest_on_edge(const struct haptable_model* model, uint16_t patch, int corner, const float x_m[3],
                            struct haptable_contact* nearest) {
    const int a = corner == 2 ? 0 : corner + 1;
    const int b = corner == 0 ? 2 : corner - 1;
    float along[3];
    float to_x[3];
    float length2;
    float t;
    vec_sub(vertex_of(model, patch, b), vertex_of(model, patch, a), along);
    vec_sub(x_m, vertex_of(model, patch, a), to_x);
    length2 = vec_dot(along, along);
    t = length2 > 0.0f ? vec_clamp01(vec_dot(to_x, along) / length2) : 0.0f;
    nearest->patch = patch;
    nearest->alpha[corner] = 0.0f;
    nearest->alpha[a] = 1.0f - t;
    nearest->alpha[b] = t;
    place(model, nearest);
}

/* Area coordinates of x's foot on the patch's plane (eq. 11), by triple products with the normal: these keep their
 * digits on thin patches, where the determinant of the edges' dot products loses them.
 * Returns 0 for a patch without area. */
static int area_coordinates(const struct haptable_model* model, uint16_t patch, const float x_m[3], float alpha[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    float to_x[3];
    float side[3];
    float area2;
    patch_frame(model, patch, edge1, edge2, normal);
    area2 = vec_dot(normal, normal);
    if (!(area2 > 0.0f)) return 0;
    vec_sub(x_m, vertex_of(model, patch, 0), to_x);
    vec_cross(to_x, edge2, side);
    alpha[1] = vec_dot(side, normal) / area2;
    vec_cross(edge1, to_x, side);
    alpha[2] = vec_dot(side, normal) / area2;
    alpha[0] = 1.0f - alpha[1] - alpha[2];
    return 1;
}

/* The nearest point lies inside, or on an edge whose opposite area coordinate is negative. */
void contact_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                     struct haptable_contact* nearest) {
    float alpha[3] = {-1.0f, -1.0f, -1.0f};
    struct haptable_contact on_edge;
    float best = -1.0f;
    int corner;
    if (area_coordinates(model, patch, x_m, alpha) && alpha[0] >= 0.0f && alpha[1] >= 0.0f && alpha[2] >= 0.0f) {
        nearest->patch = patch;
        vec_copy(alpha, nearest->alpha);
        place(model, nearest);
        return;
    }
    for (corner = 0; corner < 3; ++corner) {
        float gap;
        if (alpha[corner] >= 0.0f) continue;
        nearest_on_edge(model, patch, corner, x_m, &on_edge);
        gap = gap2(on_edge.god_object_m, x_m);
        if (best >= 0.0f && gap >= best) continue;
        best = gap;
        *nearest = on_edge;
    }
}

/* ---- sliding -------------------------------------------------------------------------------------------------- */

/* 1 when the neighbour's point lies elsewhere, and so nearer (see the head of this file). */
static int is_move(const struct haptable_model* model, const struct haptable_contact* from,
                   const struct haptable_contact* to) {
    return gap2(from->god_object_m, to->god_object_m) > model->tolerance_m * model->tolerance_m;
}

/* Tries the patch across the edge. Returns 1 when the god-object moved on to it. */
static int cross_edge(const struct haptable_model* model, int corner, const float x_m[3],
                      struct haptable_contact* contact, int* visited) {
    const uint16_t across = model->neighbour[contact->patch][corner];
    struct haptable_contact next;
    if (across == HAPTABLE_NONE) return 0;
    ++*visited;
    contact_nearest(model, across, x_m, &next);
    if (!is_move(model, contact, &next)) return 0;
    *contact = next;
    return 1;
}

/* Tries all patches around the vertex, as far as the budget goes. Returns 1 when the god-object moved to the one that
 * comes nearest to x. */
static int cross_vertex(const struct haptable_model* model, int corner, const float x_m[3],
                        struct haptable_contact* contact, int* visited) {
    struct fan fan = fan_begin(model, contact->patch, corner);
    const struct haptable_contact at_vertex = *contact;
    float best = 0.0f;
    int moved = 0;
    while (*visited < HAPTABLE_WALK_PATCHES && fan_next(model, &fan)) {
        struct haptable_contact next;
        float gap;
        ++*visited;
        contact_nearest(model, fan.patch, x_m, &next);
        gap = gap2(next.god_object_m, x_m);
        if (!is_move(model, &at_vertex, &next) || (moved && gap >= best)) continue;
        best = gap;
        moved = 1;
        *contact = next;
    }
    return moved;
}

/* Slides the god-object down to the nearest point of the surface around it. */
static void slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact,
                  struct haptable_counters* counters) {
    int visited = 1;
    int moving = 1;
    contact_nearest(model, contact->patch, x_m, contact);
    while (moving && visited < HAPTABLE_WALK_PATCHES) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(contact->alpha, &corner);
        moving = 0;
        if (feature == ON_EDGE) moving = cross_edge(model, corner, x_m, contact, &visited);
        if (feature == ON_VERTEX) moving = cross_vertex(model, corner, x_m, contact, &visited);
    }
    if (moving) ++counters->walk_limits;
    if ((uint32_t)visited > counters->most_patches) counters->most_patches = (uint32_t)visited;
}

/* ---- one tick ------------------------------------------------------------------------------------------------- */

/* Moves the god-object of one tick.
 *
 * In contact it slides on the surface towards the finger and lets go when the finger is outside; from there, or from
 * `from_m` when there was no contact, the way to `to_m` is searched for the first patch that it crosses inwards, where
 * contact begins.
 *
 * before: contact->patch is HAPTABLE_NONE, or contact holds a point of the surface; positions are finite and within
 *         reach_m of the body.
 * after:  contact->patch is HAPTABLE_NONE and the finger is outside, or 0 <= alpha <= 1, sum 1,
 *         god_object = sum alpha V, and no neighbouring patch is nearer to the finger (unless a limit was met:
 * counted). cost:   at most HAPTABLE_SLIDES slides of HAPTABLE_WALK_PATCHES patches and as many queries of the spatial
 * index. */
void haptable_god_object_nearest(const struct haptable_model* model, struct haptable_contact* contact,
                                 const float from_m[3], const float to_m[3], struct haptable_counters* counters) {
    struct way way;
    int slides;
    vec_copy(from_m, way.from_m);
    vec_copy(to_m, way.to_m);
    way.begins = AT_FINGER;
    for (slides = 0; slides < HAPTABLE_SLIDES; ++slides) {
        if (contact->patch == HAPTABLE_NONE && !surface_enter(model, &way, contact, counters)) return;
        slide(model, to_m, contact, counters);
        if (!surface_is_outside(model, contact, to_m)) return;
        /* The finger has left this part of the surface. Its way from there may enter another part. */
        vec_copy(contact->god_object_m, way.from_m);
        way.begins = AT_GOD_OBJECT;
        contact->patch = HAPTABLE_NONE;
    }
    ++counters->slide_limits;
}
