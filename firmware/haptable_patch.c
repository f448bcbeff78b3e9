/* SPDX-License-Identifier: MIT
 *
 * q = argmin |x - q| over one patch
 */
#include "haptable_patch.h"

#include "haptable_surface.h"

/* A point this near to an edge or a vertex, in area coordinates, is on it: eight times their rounding, and nearer than
 * half of tolerance_m on any patch. Only there are the patches across tried. */
#define ON_BORDER 0x1p-21f

enum place_on_patch haptable_patch_feature(const float alpha[3], int* corner) { return feature_of(alpha, corner); }

/* The best point so far of a patch's border. */
struct on_border {
    int corner;     /* opposite to the edge */
    float fraction; /* of the edge, from the corner after it to the corner before it */
    float length2;  /* of the edge, squared */
    float gap2;     /* to the finger, squared; HAPTABLE_MOST: none yet */
};

/* Takes the nearest point of the edge opposite to `corner`, if it is nearer. */
static void nearest_on_edge(const struct haptable_model* model, uint16_t patch, int corner, const float x_m[3],
                            struct on_border* best) {
    const float* from = model->vertex_m[vertex_after(model, patch, corner)];
    float along[3], to_x[3];
    vec_sub(model->vertex_m[vertex_before(model, patch, corner)], from, along);
    vec_sub(x_m, from, to_x);
    const float length2 = vec_length2(along);
    float fraction = length2 > 0.0f ? vec_dot(to_x, along) / length2 : 0.0f;
    if (fraction < ON_BORDER) fraction = 0.0f;
    if (fraction > 1.0f - ON_BORDER) fraction = 1.0f;
    vec_add_scaled(-fraction, along, to_x);
    const float gap2_here = vec_length2(to_x);
    if (gap2_here >= best->gap2) return;
    best->corner = corner;
    best->fraction = fraction;
    best->length2 = length2;
    best->gap2 = gap2_here;
}

static void put_on_border(const struct on_border* best, float alpha[3]) {
    alpha[best->corner] = 0.0f;
    alpha[next_corner(best->corner)] = 1.0f - best->fraction;
    alpha[previous_corner(best->corner)] = best->fraction;
}

/* Area coordinates of x's foot on the patch's plane (eq. 11), by triple products with the normal: these keep their
 * digits on thin patches, where the determinant of the edges' dot products loses them.
 * A patch without area gives three negative numbers. */
static void area_coordinates(const struct haptable_model* model, uint16_t patch, const float x_m[3], float alpha[3]) {
    float edge1[3], edge2[3], normal[3], to_x[3], across[3];
    patch_frame(model, patch, edge1, edge2, normal);
    vec_sub(x_m, vertex_of(model, patch, 0), to_x);
    vec_cross(normal, to_x, across);
    const float area2 = vec_length2(normal);
    alpha[0] = alpha[1] = alpha[2] = -1.0f;
    if (!(area2 > 0.0f)) return;
    alpha[1] = vec_dot(across, edge2) / area2;
    alpha[2] = -vec_dot(across, edge1) / area2;
    alpha[0] = 1.0f - alpha[1] - alpha[2];
}

/* The nearest point lies inside, or on an edge whose opposite area coordinate is negative or next to nothing. */
void haptable_patch_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                            struct haptable_contact* nearest) {
    struct on_border best = {0, 0.0f, 0.0f, HAPTABLE_MOST};
    float* alpha = nearest->alpha;
    area_coordinates(model, patch, x_m, alpha);
    nearest->patch = patch;
    HAPTABLE_UNROLLED
    for (int corner = 0; corner < 3; ++corner)
        if (!(alpha[corner] >= ON_BORDER)) nearest_on_edge(model, patch, corner, x_m, &best);
    if (best.gap2 < HAPTABLE_MOST) put_on_border(&best, alpha);
    place(model, nearest);
}

void haptable_patch_onto_border(const struct haptable_model* model, struct haptable_contact* point) {
    const float edge_m = HAPTABLE_EDGE_REACH * model->tolerance_m;
    const float vertex_m = HAPTABLE_VERTEX_REACH * model->tolerance_m;
    struct on_border best = {0, 0.0f, 0.0f, HAPTABLE_MOST};
    const int is_thin = haptable_patch_is_thin(model, point->patch);
    for (int corner = 0; corner < 3; ++corner)
        if (is_thin || point->alpha[corner] < HAPTABLE_NEAR_BORDER)
            nearest_on_edge(model, point->patch, corner, point->god_object_m, &best);
    if (best.gap2 > edge_m * edge_m) return;
    const float rest = 1.0f - best.fraction;
    if (best.fraction * best.fraction * best.length2 <= vertex_m * vertex_m) best.fraction = 0.0f;
    if (rest * rest * best.length2 <= vertex_m * vertex_m) best.fraction = 1.0f;
    put_on_border(&best, point->alpha);
    place(model, point);
}

int haptable_patch_ends_beyond(const struct haptable_model* model, uint16_t patch, int corner, const float at_m[3],
                               float thin_m) {
    struct on_border best = {-1, 0.0f, 0.0f, HAPTABLE_MOST};
    nearest_on_edge(model, patch, next_corner(corner), at_m, &best);
    nearest_on_edge(model, patch, previous_corner(corner), at_m, &best);
    return best.gap2 <= thin_m * thin_m ? best.corner : -1;
}
