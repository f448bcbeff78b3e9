/* SPDX-License-Identifier: MIT
 *
 * The nearest point of one patch, which entering the surface and sliding on it both need, and of its border.
 */
#ifndef HAPTABLE_PATCH_H
#define HAPTABLE_PATCH_H

#include "haptable_model.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* feature_of, as a function: for what need not be fast. */
enum place_on_patch haptable_patch_feature(const float alpha[3], int* corner);

/* The area coordinates (eq. 11) and the position of the point of a patch that is nearest to x.
 * after: 0 <= alpha <= 1, sum 1 to rounding; alpha is exactly 0 at the corners opposite to the edges it lies on. */
void haptable_patch_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                            struct haptable_contact* nearest);

/* How near an edge and a vertex are, in tolerance_m. Where two patches meet at a knife's edge, the body next to it is
 * thinner than the point is far from the edge. A vertex within reach of what is left out next to an edge has more to
 * say than the edge. */
#define HAPTABLE_EDGE_REACH 8.0f
#define HAPTABLE_VERTEX_REACH 32.0f

/* 1 where a patch may be so thin that every point of it is within reach of an edge, and no area coordinate tells. */
#define HAPTABLE_NEAR_BORDER 0.0625f

/* No patch with twice this area, in tolerance_m squared, is thin: 2 * HAPTABLE_EDGE_REACH / HAPTABLE_NEAR_BORDER times
 * the body's diagonal. */
#define HAPTABLE_THIN_AREA 0x1p28f

/* 1 where a patch may be thin by its edges from corner 0 and their cross product. */
static inline int haptable_patch_has_thin_frame(const struct haptable_model* model, const float edge1[3],
                                                const float edge2[3], const float normal[3]) {
    const float thin_m = HAPTABLE_EDGE_REACH / HAPTABLE_NEAR_BORDER * model->tolerance_m;
    const float area_m2 = HAPTABLE_THIN_AREA * model->tolerance_m * model->tolerance_m;
    const float area2 = vec_length2(normal);
    if (area2 >= area_m2 * area_m2) return 0; /* on a body of not too many patches */
    return area2 < 2.0f * thin_m * thin_m * (vec_length2(edge1) + vec_length2(edge2));
}

static inline int haptable_patch_is_thin(const struct haptable_model* model, uint16_t patch) {
    return model->slivers && model->slivers->is_thin && model->slivers->is_thin(model, patch);
}

/* 1 where area coordinates leave it open whether a point is out of reach of every edge. */
static inline int haptable_patch_is_on_rim(const float alpha[3]) {
    HAPTABLE_UNROLLED
    for (int i = 0; i < 3; ++i)
        if (alpha[i] < HAPTABLE_NEAR_BORDER) return 1;
    return 0;
}

/* 0 where a point of a patch is out of reach of every edge. */
static inline int haptable_patch_is_near_border(const struct haptable_model* model,
                                                const struct haptable_contact* point) {
    return haptable_patch_is_on_rim(point->alpha) || haptable_patch_is_thin(model, point->patch);
}

/* Puts a point of a patch that is next to an edge onto that, or onto a vertex that is near too: what lies there is to
 * be asked what is inside and what is outside. One that is farther from every edge stays.
 * after: alpha as above. */
void haptable_patch_onto_border(const struct haptable_model* model, struct haptable_contact* point);

/* The corner whose opposite edge is within thin_m of a point of the edge opposite to `corner`; -1: both are farther,
 * the patch is not that thin there. */
int haptable_patch_ends_beyond(const struct haptable_model* model, uint16_t patch, int corner, const float at_m[3],
                               float thin_m);

/* Makes the sum of the area coordinates 1, by the largest. */
static inline void haptable_patch_complete(float alpha[3]) {
    if (alpha[0] >= alpha[1] && alpha[0] >= alpha[2])
        alpha[0] = 1.0f - alpha[1] - alpha[2];
    else if (alpha[1] >= alpha[2])
        alpha[1] = 1.0f - alpha[0] - alpha[2];
    else
        alpha[2] = 1.0f - alpha[0] - alpha[1];
}

/* Moves a point by t d of its area coordinates, d[0] + d[1] + d[2] = 0, at most to its patch's border, where the
 * coordinate that ends there is exactly 0. Returns how much of d was gone, 0 to t. */
static inline float haptable_patch_move(const struct haptable_model* model, const struct haptable_contact* from,
                                        const float d[3], float t, struct haptable_contact* to) {
    int ends = -1;
    for (int c = 0; c < 3; ++c)
        if (from->alpha[c] + t * d[c] <= 0.0f && d[c] < 0.0f && from->alpha[c] > 0.0f) {
            t = from->alpha[c] / -d[c];
            ends = c;
        }
    *to = *from;
    for (int c = 0; c < 3; ++c) {
        to->alpha[c] = from->alpha[c] == 0.0f && d[c] <= 0.0f ? 0.0f : vec_clamp01(from->alpha[c] + t * d[c]);
        if (c == ends) to->alpha[c] = 0.0f;
    }
    haptable_patch_complete(to->alpha);
    place(model, to);
    return t;
}

#endif
