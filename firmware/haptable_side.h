/* SPDX-License-Identifier: MIT
 *
 * Inside and outside of the surface, and the outward direction.
 */
#ifndef HAPTABLE_SIDE_H
#define HAPTABLE_SIDE_H

#include "haptable_model.h"
#include "haptable_surface.h"
#include "haptable_vector.h"

/* 1 / |v|; 0 where v is nothing. A function: where it is asked, digits count more than cycles. */
float haptable_side_inverse_length(const float v[3]);

/* The outward direction at the god-object, of any length: the patch's normal, the mean of those at an edge, the mean
 * weighted by angles at a vertex. Within a patch it is twice the area long, in tolerance_m squared: no root is taken,
 * and squares of it are floats on a body of any size. */
void haptable_side_outward(const struct haptable_model* model, const struct haptable_contact* contact, float normal[3]);

/* Heights within this, in tolerance_m, are rounding: of the points, and of a plane beyond its patch. */
#define HAPTABLE_ROUNDING 0.25f

/* Where a line begins: within the body or outside of it, by more than rounding, or along its surface. */
enum haptable_side { HAPTABLE_SIDE_INSIDE, HAPTABLE_SIDE_OUTSIDE, HAPTABLE_SIDE_ALONG };

/* The side of u over the plane of a normal of any length. */
HAPTABLE_INLINE enum haptable_side side_of_plane(const struct haptable_model* model, const float normal[3],
                                                 const float u[3]) {
    const float over = vec_dot(normal, u);
    const float rounding = HAPTABLE_ROUNDING * model->tolerance_m;
    if (over * over <= rounding * rounding * vec_length2(normal)) return HAPTABLE_SIDE_ALONG;
    return over > 0.0f ? HAPTABLE_SIDE_OUTSIDE : HAPTABLE_SIDE_INSIDE;
}

/* The side of u over the plane of a patch: a tick that slides asks it, and as a call it would take 59 instructions of
 * 825. */
HAPTABLE_INLINE enum haptable_side side_of_patch(const struct haptable_model* model, uint16_t patch, const float u[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    return side_of_plane(model, normal, u);
}

/* On which side the line from the god-object along u begins. Exact wherever the god-object is: the patch, edge or
 * vertex there that is nearest to u has the sign (haptable_side.c). Of what is thinner there than an
 * edge or a vertex reaches, what lies beyond is asked.
 * cost: at a vertex each patch around it, and at a nearest point its normal. */
enum haptable_side haptable_side_of(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float u[3]);

#endif
