/* SPDX-License-Identifier: MIT
 *
 * n . (x - g) < 0: the finger x is inside, with n the outward direction at the god-object g
 */
#include "haptable_surface.h"

/* arccos x for -1 <= x <= 1, to 7e-5 rad (Abramowitz and Stegun 4.4.45). It weighs normals: no digit of a force. */
static float angle_of_cosine(float x) {
    const float c = x < 0.0f ? -x : x;
    const float polynomial = 1.5707288f + c * (-0.2121144f + c * (0.0742610f - c * 0.0187293f));
    const float rest = 1.0f - c;
    const float angle = rest > 1e-30f ? rest * vec_inverse_root(rest) * polynomial : 0.0f;
    return x < 0.0f ? 3.1415927f - angle : angle;
}

/* Adds the unit normal of a patch, weighted by its angle at `corner`; by 1 where corner is negative. */
static void add_normal(const struct haptable_model* model, uint16_t patch, int corner, float sum[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    float weight;
    float length2;
    patch_frame(model, patch, edge1, edge2, normal);
    length2 = vec_dot(normal, normal);
    if (length2 < 1e-30f) return;
    weight = vec_inverse_root(length2);
    if (corner >= 0) {
        const float* here = vertex_of(model, patch, corner);
        float lengths2;
        float cosine;
        vec_sub(vertex_of(model, patch, next_corner(corner)), here, edge1);
        vec_sub(vertex_of(model, patch, previous_corner(corner)), here, edge2);
        lengths2 = vec_dot(edge1, edge1) * vec_dot(edge2, edge2);
        cosine = lengths2 > 1e-30f ? vec_dot(edge1, edge2) * vec_inverse_root(lengths2) : 1.0f;
        weight *= angle_of_cosine(cosine > 1.0f ? 1.0f : (cosine < -1.0f ? -1.0f : cosine));
    }
    vec_add_scaled(weight, normal, sum);
}

void haptable_surface_outward(const struct haptable_model* model, const struct haptable_contact* contact,
                              float normal[3]) {
    int corner = 0;
    const enum place_on_patch feature = feature_of(contact->alpha, &corner);
    vec_zero(normal);
    if (feature == ON_VERTEX) {
        struct fan fan = fan_begin(model, contact->patch, corner);
        int patches = 0;
        do add_normal(model, fan.patch, fan.corner, normal);
        while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
        return;
    }
    add_normal(model, contact->patch, -1, normal);
    if (feature == ON_EDGE && model->neighbour[contact->patch][corner] != HAPTABLE_NONE)
        add_normal(model, model->neighbour[contact->patch][corner], -1, normal);
}

int haptable_surface_is_outside(const struct haptable_model* model, const struct haptable_contact* contact,
                                const float x_m[3]) {
    float normal[3];
    float u[3];
    haptable_surface_outward(model, contact, normal);
    vec_sub(x_m, contact->god_object_m, u);
    return vec_dot(normal, u) >= 0.0f;
}
