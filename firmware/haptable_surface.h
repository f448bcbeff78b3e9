/* SPDX-License-Identifier: MIT
 *
 * The triangle surface of a model: its patches and the fans around its vertices.
 */
#ifndef HAPTABLE_SURFACE_H
#define HAPTABLE_SURFACE_H

#include "haptable_model.h"
#include "haptable_vector.h"

static inline int next_corner(int corner) { return corner == 2 ? 0 : corner + 1; }

static inline int previous_corner(int corner) { return corner == 0 ? 2 : corner - 1; }

/* The vertices of a patch's edge opposite to `corner`: after the corner, and before it. */
HAPTABLE_INLINE uint16_t vertex_after(const struct haptable_model* model, uint16_t patch, int corner) {
    return model->patch[patch][next_corner(corner)];
}

HAPTABLE_INLINE uint16_t vertex_before(const struct haptable_model* model, uint16_t patch, int corner) {
    return model->patch[patch][previous_corner(corner)];
}

static inline const float* vertex_of(const struct haptable_model* model, uint16_t patch, int corner) {
    return model->vertex_m[model->patch[patch][corner]];
}

/* The two edges from corner 0, and their cross product: along the outward normal, twice the patch's area long. */
HAPTABLE_INLINE void patch_frame(const struct haptable_model* model, uint16_t patch, float edge1[3], float edge2[3],
                                 float normal[3]) {
    const float* origin = vertex_of(model, patch, 0);
    vec_sub(vertex_of(model, patch, 1), origin, edge1);
    vec_sub(vertex_of(model, patch, 2), origin, edge2);
    vec_cross(edge1, edge2, normal);
}

HAPTABLE_INLINE float gap2(const float a[3], const float b[3]) {
    float d[3];
    vec_sub(a, b, d);
    return vec_length2(d);
}

HAPTABLE_INLINE void place(const struct haptable_model* model, struct haptable_contact* contact) {
    const float* a = vertex_of(model, contact->patch, 0);
    const float* b = vertex_of(model, contact->patch, 1);
    const float* c = vertex_of(model, contact->patch, 2);
    const float* alpha = contact->alpha;
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) contact->god_object_m[i] = alpha[0] * a[i] + alpha[1] * b[i] + alpha[2] * c[i];
}

/* ---- walking around a vertex ---------------------------------------------------------------------------------- */

HAPTABLE_INLINE int corner_of(const struct haptable_model* model, uint16_t patch, uint16_t vertex) {
    const uint16_t* v = model->patch[patch];
    if (v[0] == vertex) return 0;
    return v[1] == vertex ? 1 : 2;
}

/* The patches around one vertex, one after the other: counter-clockwise until the ring closes or meets the border of
 * the touch region, then, from the first patch, clockwise; at a hinge then the vertex's other rings. */
struct fan {
    uint16_t vertex;
    uint16_t begin; /* where the first ring began */
    uint16_t first; /* where this ring began */
    uint16_t patch;
    int corner; /* of the patch, where the vertex is */
    int clockwise;
};

HAPTABLE_INLINE struct fan fan_begin(const struct haptable_model* model, uint16_t patch, int corner) {
    struct fan fan;
    fan.vertex = model->patch[patch][corner];
    fan.begin = patch;
    fan.first = patch;
    fan.patch = patch;
    fan.corner = corner;
    fan.clockwise = 0;
    return fan;
}

static inline uint16_t fan_turn(const struct haptable_model* model, const struct fan* fan) {
    const int across = fan->clockwise ? previous_corner(fan->corner) : next_corner(fan->corner);
    return model->neighbour[fan->patch][across];
}

/* Goes on to the next patch of the fan; 0 when all were visited. */
HAPTABLE_INLINE int fan_next(const struct haptable_model* model, struct fan* fan) {
    const uint16_t next = fan_turn(model, fan);
    if (next == HAPTABLE_NONE || next == fan->first) {
        if (!model->hinges) return 0; /* most bodies */
        *fan = model->hinges->turned(model, *fan);
        return fan->patch != HAPTABLE_NONE;
    }
    fan->patch = next;
    fan->corner = corner_of(model, next, fan->vertex);
    return 1;
}

/* What a vertex sees of a patch around it: one piece between two edges. Where the edge opposite to the vertex is nearer
 * than thin_m, the patch is a sliver and its normal says nothing: then two pieces of what lies beyond. */
struct haptable_seen {
    uint16_t patch;
    uint16_t pieces;
    uint16_t end[3]; /* vertices: piece i lies between those of end[i] and end[i + 1] */
};

/* The patches across an edge of a patch: its neighbour there, and at a hinge the others that have this edge. */
struct across {
    uint16_t from;  /* the patch */
    uint16_t patch; /* the one across; HAPTABLE_NONE: no more */
    int corner;     /* of `from`, opposite to the edge */
};

HAPTABLE_INLINE void across_next(const struct haptable_model* model, struct across* across) {
    across->patch =
        model->hinges ? model->hinges->next_across(model, across->from, across->corner, across->patch) : HAPTABLE_NONE;
}

HAPTABLE_INLINE struct across across_begin(const struct haptable_model* model, uint16_t patch, int corner) {
    struct across across;
    across.from = patch;
    across.patch = model->neighbour[patch][corner];
    across.corner = corner;
    if (across.patch == HAPTABLE_NONE) across_next(model, &across);
    return across;
}

/* An edge at the vertex v that the god-object is on. */
struct edge {
    float along[3]; /* e, to the edge's other vertex */
    float rise;     /* (x - v) . e: positive where the edge leads nearer to the finger x */
    float length2;  /* e . e */
};

HAPTABLE_INLINE void edge_to(const struct haptable_model* model, uint16_t vertex, const float at_m[3],
                             const float to_x[3], struct edge* edge) {
    vec_sub(model->vertex_m[vertex], at_m, edge->along);
    edge->rise = vec_dot(to_x, edge->along);
    edge->length2 = vec_length2(edge->along);
}

/* 1 when the nearest point to x of the plane of two edges lies between them: normal equations, solved by Cramer. */
HAPTABLE_INLINE int leads_between(const struct edge* one, const struct edge* two) {
    const float both = vec_dot(one->along, two->along);
    return one->rise * two->length2 > two->rise * both && two->rise * one->length2 > one->rise * both;
}

/* Where a point of a patch lies: inside, on the edge opposite to `corner`, or on the vertex at `corner`. */
enum place_on_patch { INSIDE, ON_EDGE, ON_VERTEX };

HAPTABLE_INLINE enum place_on_patch feature_of(const float alpha[3], int* corner) {
    int zeros = 0;
    int zero = 0;
    int other = 2;
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i) {
        if (alpha[i] == 0.0f) {
            zero = i;
            ++zeros;
        } else {
            other = i;
        }
    }
    if (zeros == 0) return INSIDE;
    *corner = zeros == 1 ? zero : other;
    return zeros == 1 ? ON_EDGE : ON_VERTEX;
}

#endif
