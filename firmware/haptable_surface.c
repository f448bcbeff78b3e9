/* SPDX-License-Identifier: MIT
 *
 * n . u > 0: the line from the god-object along u begins outside, with n the outward direction of what is nearest to u
 *
 * Around a point of the surface the patches are a cone, and u lies outside of it where it lies on the outer side of the
 * cone's part that is nearest to it: a patch by its normal, an edge by the mean of its patches' normals, the vertex
 * itself by their mean weighted by angles (Baerentzen and Aanaes 2005; means with other weights do not tell).
 */
#include "haptable_surface.h"

#include <stddef.h>

#include "haptable_patch.h"

static struct fan fan_at(const struct haptable_model* model, struct fan fan, uint16_t patch) {
    fan.patch = patch;
    if (patch != HAPTABLE_NONE) fan.corner = corner_of(model, patch, fan.vertex);
    return fan;
}

struct fan haptable_surface_fan_turned(const struct haptable_model* model, struct fan fan) {
    if (!fan.clockwise && fan_turn(model, &fan) == HAPTABLE_NONE) {
        uint16_t next;
        fan = fan_at(model, fan, fan.first);
        fan.clockwise = 1;
        next = fan_turn(model, &fan);
        if (next != HAPTABLE_NONE) return fan_at(model, fan, next);
    }
    if (model->hinge_count == 0) return fan_at(model, fan, HAPTABLE_NONE); /* most bodies */
    fan.first = haptable_hinge_next_ring(model, fan.vertex, fan.first, fan.begin);
    fan.clockwise = 0;
    return fan_at(model, fan, fan.first);
}

/* arccos x for -1 <= x <= 1, to 7e-5 rad (Abramowitz and Stegun 4.4.45). It weighs normals: no digit of a force. */
static float angle_of_cosine(float x) {
    const float c = x < 0.0f ? -x : x;
    const float polynomial = 1.5707288f + c * (-0.2121144f + c * (0.0742610f - c * 0.0187293f));
    const float rest = 1.0f - c;
    const float angle = rest > 1e-30f ? rest * vec_inverse_root(rest) * polynomial : 0.0f;
    return x < 0.0f ? 3.1415927f - angle : angle;
}

/* 1 / |n| of a patch's normal; 0 where the patch has no area. */
static float inverse_length(const float normal[3]) {
    const float length2 = vec_dot(normal, normal);
    return length2 < 1e-30f ? 0.0f : vec_inverse_root(length2);
}

/* Adds the unit normal of a patch. */
static void add_normal(const struct haptable_model* model, uint16_t patch, float sum[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    vec_add_scaled(inverse_length(normal), normal, sum);
}

/* Adds the unit normal of the patch between two edges of a vertex, weighted by the angle between them. */
static inline void add_weighted_normal(const float one[3], const float two[3], float sum[3]) {
    const float lengths2 = vec_dot(one, one) * vec_dot(two, two);
    const float cosine = lengths2 > 1e-30f ? vec_dot(one, two) * vec_inverse_root(lengths2) : 1.0f;
    float normal[3];
    vec_cross(one, two, normal);
    vec_add_scaled(inverse_length(normal) * angle_of_cosine(cosine > 1.0f ? 1.0f : (cosine < -1.0f ? -1.0f : cosine)),
                   normal, sum);
}

/* Adds those of the fan's patches. */
static void add_vertex_normals(const struct haptable_model* model, struct fan fan, float sum[3]) {
    const float* at_m = model->vertex_m[fan.vertex];
    int patches = 0;
    do {
        float one[3];
        float two[3];
        vec_sub(vertex_of(model, fan.patch, next_corner(fan.corner)), at_m, one);
        vec_sub(vertex_of(model, fan.patch, previous_corner(fan.corner)), at_m, two);
        add_weighted_normal(one, two, sum);
    } while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
}

void haptable_surface_outward(const struct haptable_model* model, const struct haptable_contact* contact,
                              float normal[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(contact->alpha, &corner);
    vec_zero(normal);
    if (feature == ON_VERTEX) {
        add_vertex_normals(model, fan_begin(model, contact->patch, corner), normal);
        return;
    }
    add_normal(model, contact->patch, normal);
    if (feature == ON_EDGE) {
        struct across across = across_begin(model, contact->patch, corner);
        for (; across.patch != HAPTABLE_NONE; across_next(model, &across)) add_normal(model, across.patch, normal);
    }
}

/* ---- on which side a line begins ------------------------------------------------------------------------------ */

/* What an edge's patches say about u. */
struct around_edge {
    float sum;     /* of u over their planes */
    float nearest; /* u along the patch that is nearest to it, square to the edge; 0: the edge itself is nearest */
    int is_over;   /* that patch: u is on its outer side */
};

/* One patch of the edge from vertex_m[a] to vertex_m[b]. across: (b - a) x u. */
static void look_over(const struct haptable_model* model, uint16_t patch, uint16_t a, uint16_t b, const float u[3],
                      const float across[3], struct around_edge* edge) {
    const int runs_along = corner_of(model, patch, b) == next_corner(corner_of(model, patch, a));
    float edge1[3];
    float edge2[3];
    float normal[3];
    float scale;
    float over;
    float inwards;
    patch_frame(model, patch, edge1, edge2, normal);
    scale = inverse_length(normal);
    over = scale * vec_dot(normal, u);
    inwards = scale * vec_dot(normal, across); /* (n x (b - a)) . u: n x (b - a) leads into the patch */
    if (!runs_along) inwards = -inwards;
    edge->sum += over;
    if (inwards <= edge->nearest) return;
    edge->nearest = inwards;
    edge->is_over = over > HAPTABLE_ROUNDING * model->tolerance_m;
}

/* Slivers that may lie side by side along an edge. */
#define SLIVERS 4

/* The same; where the patch is so thin at the point at_m that its normal says nothing, what lies beyond its other edge
 * there. at_m may be NULL: not at any point. */
static void look_beyond(const struct haptable_model* model, uint16_t patch, uint16_t a, uint16_t b, const float at_m[3],
                        const float u[3], const float across[3], struct around_edge* edge) {
    int slivers;
    for (slivers = 0; at_m && slivers < SLIVERS; ++slivers) {
        const int corner_a = corner_of(model, patch, a);
        const int opposite = 3 - corner_a - corner_of(model, patch, b);
        const uint16_t far_vertex = model->patch[patch][opposite];
        const int beyond = haptable_patch_ends_beyond(model, patch, opposite, at_m);
        const uint16_t other = beyond < 0 ? HAPTABLE_NONE : across_begin(model, patch, beyond).patch;
        if (other == HAPTABLE_NONE) break;
        if (beyond == corner_a)
            a = far_vertex;
        else
            b = far_vertex;
        patch = other;
    }
    look_over(model, patch, a, b, u, across, edge);
}

/* See haptable_surface_begins_outside; on the edge opposite to `corner`, at at_m of it where that is not NULL. */
static int is_over_edge(const struct haptable_model* model, uint16_t patch, int corner, const float at_m[3],
                        const float u[3]) {
    struct across other = across_begin(model, patch, corner);
    const uint16_t a = model->patch[patch][next_corner(corner)];
    const uint16_t b = model->patch[patch][previous_corner(corner)];
    struct around_edge edge = {0.0f, 0.0f, 0};
    float along[3];
    float across[3];
    vec_sub(model->vertex_m[b], model->vertex_m[a], along);
    vec_cross(along, u, across);
    look_beyond(model, patch, a, b, at_m, u, across, &edge);
    for (; other.patch != HAPTABLE_NONE; across_next(model, &other))
        look_beyond(model, other.patch, a, b, at_m, u, across, &edge);
    return edge.nearest > 0.0f ? edge.is_over : edge.sum > HAPTABLE_ROUNDING * model->tolerance_m;
}

/* The part of a vertex's cone that is nearest to u: by how far u, squared, reaches along it. */
struct nearest_part {
    float reach2; /* 0: the vertex itself */
    uint16_t patch;
    int corner; /* of it, opposite to the edge; -1: the patch's inside */
};

static void note_part(float reach2, uint16_t patch, int corner, struct nearest_part* nearest) {
    if (reach2 <= nearest->reach2) return;
    nearest->reach2 = reach2;
    nearest->patch = patch;
    nearest->corner = corner;
}

/* Takes the fan's patch or one of its two edges, where u reaches farther along it. */
static void note_parts(const struct fan* fan, const struct edge* one, const struct edge* two, const float u[3],
                       struct nearest_part* nearest) {
    if (leads_between(one, two)) {
        float normal[3];
        float over;
        vec_cross(one->along, two->along, normal);
        over = vec_dot(normal, u);
        note_part(vec_dot(u, u) - over * over / vec_dot(normal, normal), fan->patch, -1, nearest);
        return;
    }
    if (one->rise > 0.0f)
        note_part(one->rise * one->rise / one->length2, fan->patch, previous_corner(fan->corner), nearest);
    if (two->rise > 0.0f)
        note_part(two->rise * two->rise / two->length2, fan->patch, next_corner(fan->corner), nearest);
}

/* What the patches of a vertex say about u, without a length or an angle. */
struct around_vertex {
    int is_over_one;  /* of their planes */
    int is_under_one; /* of their planes */
    int rises;        /* an edge leads along u */
};

static struct around_vertex look_around(const struct haptable_model* model, struct fan fan, const float u[3]) {
    const float* at_m = model->vertex_m[fan.vertex];
    struct around_vertex around = {0, 0, 0};
    int patches = 0;
    do {
        const uint16_t* v = model->patch[fan.patch];
        float one[3];
        float two[3];
        float normal[3];
        vec_sub(model->vertex_m[v[next_corner(fan.corner)]], at_m, one);
        vec_sub(model->vertex_m[v[previous_corner(fan.corner)]], at_m, two);
        vec_cross(one, two, normal);
        if (is_over_plane(model, normal, u))
            around.is_over_one = 1;
        else
            around.is_under_one = 1;
        if (vec_dot(one, u) > 0.0f || vec_dot(two, u) > 0.0f) around.rises = 1;
    } while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
    return around;
}

static struct nearest_part part_nearest_to(const struct haptable_model* model, struct fan fan, const float u[3]) {
    const float* at_m = model->vertex_m[fan.vertex];
    struct nearest_part nearest = {0.0f, HAPTABLE_NONE, -1};
    int patches = 0;
    do {
        const uint16_t* v = model->patch[fan.patch];
        const struct edge one = edge_to(model, v[next_corner(fan.corner)], at_m, u);
        const struct edge two = edge_to(model, v[previous_corner(fan.corner)], at_m, u);
        note_parts(&fan, &one, &two, u, &nearest);
    } while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
    return nearest;
}

/* See haptable_surface_begins_outside; on a vertex. Over all planes there, or under all, is over or under whatever part
 * is the nearest. */
static int is_over_vertex(const struct haptable_model* model, uint16_t patch, int corner, const float u[3]) {
    const struct fan fan = fan_begin(model, patch, corner);
    const struct around_vertex around = look_around(model, fan, u);
    struct nearest_part nearest;
    float normal[3] = {0.0f, 0.0f, 0.0f};
    if (!around.is_over_one || !around.is_under_one) return around.is_over_one;
    if (!around.rises) {
        add_vertex_normals(model, fan, normal);
        return is_over_plane(model, normal, u);
    }
    nearest = part_nearest_to(model, fan, u);
    if (nearest.corner < 0) return is_over_patch(model, nearest.patch, u);
    return is_over_edge(model, nearest.patch, nearest.corner, NULL, u);
}

int haptable_surface_begins_outside(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float u[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(contact->alpha, &corner);
    if (feature == ON_VERTEX) return is_over_vertex(model, contact->patch, corner, u);
    if (feature == ON_EDGE) return is_over_edge(model, contact->patch, corner, contact->god_object_m, u);
    return is_over_patch(model, contact->patch, u);
}
