/* SPDX-License-Identifier: MIT
 *
 * n . u > 0: the line from the god-object along u begins outside, with n the outward direction of what is nearest to u
 *
 * Around a point of the surface the patches are a cone, and u lies outside of it where it lies on the outer side of the
 * cone's part that is nearest to it: a patch by its normal, an edge by the mean of its patches' normals, the vertex
 * itself by their mean weighted by angles (Baerentzen and Aanaes 2005; means with other weights do not tell).
 */
#include "haptable_side.h"

#include "haptable_patch.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* ---- a plane ----------------------------------------------------------------------------------------------------- */

/* The side of a height of u over a unit normal, m, or over several. */
static enum haptable_side side_of_height(const struct haptable_model* model, float over) {
    const float rounding = HAPTABLE_ROUNDING * model->tolerance_m;
    if (over > rounding) return HAPTABLE_SIDE_OUTSIDE;
    return over < -rounding ? HAPTABLE_SIDE_INSIDE : HAPTABLE_SIDE_ALONG;
}

/* ---- outwards ---------------------------------------------------------------------------------------------------- */

/* arccos x for -1 <= x <= 1, beyond as at the end, to 7e-5 rad (Abramowitz and Stegun 4.4.45). It weighs normals: no
 * digit of a force. */
static float angle_of_cosine(float x) {
    const float c = vec_magnitude(x);
    const float polynomial = 1.5707288f + c * (-0.2121144f + c * (0.0742610f - c * 0.0187293f));
    const float rest = 1.0f - c;
    const float angle = rest > HAPTABLE_ROOT_LEAST ? rest * vec_inverse_root(rest) * polynomial : 0.0f;
    return x < 0.0f ? 3.1415927f - angle : angle;
}

/* A vector that is shorter, squared, is nothing: next to the least float there is. */
#define NO_LENGTH2 1e-37f

float haptable_side_inverse_length(const float v[3]) {
    const float length2 = vec_length2(v);
    return length2 < NO_LENGTH2 ? 0.0f : vec_inverse_root(length2);
}

/* Adds the unit normal of the patch between two edges of a vertex, weighted by the angle between them. */
static inline void add_weighted_normal(const float one[3], const float two[3], float sum[3]) {
    const float lengths2 = vec_length2(one) * vec_length2(two);
    const float cosine = lengths2 > HAPTABLE_ROOT_LEAST ? vec_dot(one, two) * vec_inverse_root(lengths2) : 1.0f;
    float normal[3];
    vec_cross(one, two, normal);
    vec_add_scaled(haptable_side_inverse_length(normal) * angle_of_cosine(cosine), normal, sum);
}

/* What the fan's vertex, which is at at_m, sees of its patch. */
static void see(const struct haptable_model* model, const struct fan* fan, const float at_m[3], float thin_m,
                struct haptable_seen* seen) {
    seen->patch = fan->patch;
    seen->pieces = 1;
    seen->end[0] = vertex_after(model, fan->patch, fan->corner);
    seen->end[1] = vertex_before(model, fan->patch, fan->corner);
    if (model->slivers) model->slivers->see(model, fan, at_m, thin_m, seen);
}

/* Adds those of the fan's patches. */
static void add_vertex_normals(const struct haptable_model* model, uint16_t patch, int corner, float thin_m,
                               float sum[3]) {
    struct fan fan = fan_begin(model, patch, corner);
    const float* at_m = model->vertex_m[fan.vertex];
    int patches = 0;
    do {
        struct haptable_seen seen;
        see(model, &fan, at_m, thin_m, &seen);
        for (int i = 0; i < seen.pieces; ++i) {
            float one[3], two[3];
            vec_sub(model->vertex_m[seen.end[i]], at_m, one);
            vec_sub(model->vertex_m[seen.end[i + 1]], at_m, two);
            add_weighted_normal(one, two, sum);
        }
    } while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
}

void haptable_side_outward(const struct haptable_model* model, const struct haptable_contact* contact,
                           float normal[3]) {
    int corner = 0;
    const enum place_on_patch feature = haptable_patch_feature(contact->alpha, &corner);
    struct across across = {contact->patch, HAPTABLE_NONE, corner};
    uint16_t patch = contact->patch;
    vec_zero(normal);
    if (feature == ON_VERTEX) {
        add_vertex_normals(model, patch, corner, HAPTABLE_VERTEX_REACH * model->tolerance_m, normal);
        return;
    }
    if (feature == ON_EDGE) across = across_begin(model, patch, corner);
    while (patch != HAPTABLE_NONE) {
        float edge1[3], edge2[3], area[3];
        patch_frame(model, patch, edge1, edge2, area);
        vec_add_scaled(
            feature == INSIDE ? 1.0f / (model->tolerance_m * model->tolerance_m) : haptable_side_inverse_length(area),
            area, normal);
        patch = across.patch;
        if (patch != HAPTABLE_NONE) across_next(model, &across);
    }
}

/* ---- on which side a line begins ------------------------------------------------------------------------------ */

/* What an edge's patches say about u. */
struct around_edge {
    float sum;     /* of u over their planes */
    float nearest; /* u along the patch that is nearest to it, square to the edge; 0: the edge itself is nearest */
    float over;    /* u over the plane of that patch */
};

/* One patch of the edge from vertex_m[a] to vertex_m[b]. across: (b - a) x u. */
static void add_patch(const struct haptable_model* model, uint16_t patch, uint16_t a, uint16_t b, const float u[3],
                      const float across[3], struct around_edge* edge) {
    const int runs_along = corner_of(model, patch, b) == next_corner(corner_of(model, patch, a));
    float edge1[3], edge2[3], normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    const float scale = haptable_side_inverse_length(normal);
    const float over = scale * vec_dot(normal, u);
    float inwards = scale * vec_dot(normal, across); /* (n x (b - a)) . u: n x (b - a) leads into the patch */
    if (!runs_along) inwards = -inwards;
    edge->sum += over;
    if (inwards <= edge->nearest) return;
    edge->nearest = inwards;
    edge->over = over;
}

/* The same; where the patch is so thin at the point at_m that its normal says nothing, what lies beyond its other edge
 * there. */
static void add_beyond(const struct haptable_model* model, uint16_t patch, uint16_t a, uint16_t b, const float at_m[3],
                       float thin_m, const float u[3], const float across[3], struct around_edge* edge) {
    uint16_t end[2];
    end[0] = a;
    end[1] = b;
    if (model->slivers) model->slivers->beyond(model, &patch, end, at_m, thin_m);
    add_patch(model, patch, end[0], end[1], u, across, edge);
}

/* See haptable_side_of; on the edge opposite to `corner`, at at_m of it. */
static enum haptable_side side_of_edge(const struct haptable_model* model, uint16_t patch, int corner,
                                       const float at_m[3], const float u[3], float thin_m) {
    struct across other = across_begin(model, patch, corner);
    const uint16_t a = vertex_after(model, patch, corner);
    const uint16_t b = vertex_before(model, patch, corner);
    struct around_edge edge = {0.0f, 0.0f, 0.0f};
    float along[3], across[3];
    vec_sub(model->vertex_m[b], model->vertex_m[a], along);
    vec_cross(along, u, across);
    while (patch != HAPTABLE_NONE) {
        add_beyond(model, patch, a, b, at_m, thin_m, u, across, &edge);
        patch = other.patch;
        if (patch != HAPTABLE_NONE) across_next(model, &other);
    }
    return side_of_height(model, edge.nearest > 0.0f ? edge.over : edge.sum);
}

/* What the patches of a vertex say about u, and the part of their cone that is nearest to it: by how far u, squared,
 * reaches along it. */
struct around_vertex {
    int is_over_one;  /* of their planes */
    int is_under_one; /* of their planes */
    float reach2;     /* 0: the vertex itself is nearest */
    uint16_t patch;   /* HAPTABLE_NONE: as above */
    int corner;       /* of it, opposite to the edge; -1: the patch's inside */
};

HAPTABLE_CALLED void note_part(float reach2, uint16_t patch, int corner, struct around_vertex* around) {
    if (reach2 <= around->reach2) return;
    around->reach2 = reach2;
    around->patch = patch;
    around->corner = corner;
}

HAPTABLE_CALLED void note_edge(const struct edge* edge, uint16_t patch, int corner, struct around_vertex* around) {
    if (edge->rise > 0.0f) note_part(edge->rise * edge->rise / edge->length2, patch, corner, around);
}

/* Takes what is seen of the fan's patch: on which side of its plane u is; the patch or one of its two edges, where u
 * reaches farther along it. */
static void note_patch(const struct haptable_model* model, const struct fan* fan, const float u[3], float thin_m,
                       struct around_vertex* around) {
    const float* at_m = model->vertex_m[fan->vertex];
    struct haptable_seen seen;
    struct edge edge[3];
    see(model, fan, at_m, thin_m, &seen);
    edge_to(model, seen.end[0], at_m, u, &edge[0]);
    for (int i = 0; i < seen.pieces; ++i) {
        const struct edge* one = &edge[i];
        const struct edge* two = &edge[i + 1];
        float normal[3];
        edge_to(model, seen.end[i + 1], at_m, u, &edge[i + 1]);
        vec_cross(one->along, two->along, normal);
        if (side_of_plane(model, normal, u) == HAPTABLE_SIDE_OUTSIDE)
            around->is_over_one = 1;
        else
            around->is_under_one = 1;
        if ((one->rise > 0.0f || two->rise > 0.0f) && leads_between(one, two)) {
            const float over = vec_dot(normal, u);
            note_part(vec_length2(u) - over * (over / vec_length2(normal)), seen.patch, -1, around);
        } else {
            if (i == 0) note_edge(one, fan->patch, previous_corner(fan->corner), around);
            if (i + 1 == seen.pieces) note_edge(two, fan->patch, next_corner(fan->corner), around);
        }
    }
}

static void note_fan(const struct haptable_model* model, uint16_t patch, int corner, const float u[3], float thin_m,
                     struct around_vertex* around) {
    struct fan fan = fan_begin(model, patch, corner);
    int patches = 0;
    do note_patch(model, &fan, u, thin_m, around);
    while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
}

/* At a vertex: over all planes there, or under all, is over or under whatever part is the nearest. */
enum haptable_side haptable_side_of(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float u[3]) {
    float thin_m = HAPTABLE_EDGE_REACH * model->tolerance_m;
    uint16_t patch = contact->patch;
    int corner = 0;
    enum place_on_patch feature = haptable_patch_feature(contact->alpha, &corner);
    float at_m[3];
    vec_copy(contact->god_object_m, at_m);
    if (feature == ON_VERTEX) {
        struct around_vertex around;
        around.is_over_one = 0;
        around.is_under_one = 0;
        around.reach2 = 0.0f;
        around.patch = HAPTABLE_NONE;
        thin_m = HAPTABLE_VERTEX_REACH * model->tolerance_m;
        note_fan(model, patch, corner, u, thin_m, &around);
        if (!around.is_over_one) return HAPTABLE_SIDE_INSIDE;
        if (!around.is_under_one) return HAPTABLE_SIDE_OUTSIDE;
        if (around.patch == HAPTABLE_NONE) { /* the mean of the vertex's normals has the sign */
            float normal[3];
            haptable_side_outward(model, contact, normal);
            return side_of_plane(model, normal, u);
        }
        if (around.corner >= 0 && model->slivers)
            model->slivers->along_edge(model, around.patch, around.corner, model->patch[patch][corner], thin_m, at_m);
        patch = around.patch;
        corner = around.corner;
        feature = corner < 0 ? INSIDE : ON_EDGE;
    }
    return feature == ON_EDGE ? side_of_edge(model, patch, corner, at_m, u, thin_m) : side_of_patch(model, patch, u);
}
