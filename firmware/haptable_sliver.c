/* SPDX-License-Identifier: MIT
 *
 * Patches so thin that their normals say nothing: what lies beyond is asked. Bodies without one do not link this.
 */
#include "haptable_patch.h"
#include "haptable_side.h"
#include "haptable_surface.h"

static int is_thin(const struct haptable_model* model, uint16_t patch) {
    float edge1[3], edge2[3], normal[3];
    patch_frame(model, patch, edge1, edge2, normal);
    return haptable_patch_has_thin_frame(model, edge1, edge2, normal);
}

static void see_beyond(const struct haptable_model* model, const struct fan* fan, const float at_m[3], float thin_m,
                       struct haptable_seen* seen) {
    const uint16_t across = model->neighbour[fan->patch][fan->corner];
    float one[3], two[3], normal[3];
    vec_sub(model->vertex_m[seen->end[0]], at_m, one);
    vec_sub(model->vertex_m[seen->end[1]], at_m, two);
    if (vec_dot(one, two) >= 0.0f) return; /* most patches: the vertex's foot is not between */
    vec_cross(one, two, normal);
    if (vec_length2(normal) > thin_m * thin_m * gap2(one, two) || across == HAPTABLE_NONE) return;
    seen->patch = across;
    seen->pieces = 2;
    seen->end[2] = seen->end[1];
    seen->end[1] =
        model->patch[across][3 - corner_of(model, across, seen->end[0]) - corner_of(model, across, seen->end[2])];
}

/* In thin_m. */
#define ALONG_EDGE 64.0f

static void along_edge(const struct haptable_model* model, uint16_t patch, int corner, uint16_t vertex, float thin_m,
                       float at_m[3]) {
    const float* a = model->vertex_m[vertex];
    const int at = corner_of(model, patch, vertex);
    float along[3];
    vec_sub(vertex_of(model, patch, 3 - at - corner), a, along);
    const float far_away = ALONG_EDGE * thin_m * haptable_side_inverse_length(along);
    vec_copy(a, at_m);
    vec_add_scaled(far_away < 0.5f ? far_away : 0.5f, along, at_m);
}

/* Slivers that may lie side by side along an edge. */
#define SLIVERS 4

static void beyond(const struct haptable_model* model, uint16_t* patch, uint16_t end[2], const float at_m[3],
                   float thin_m) {
    for (int slivers = 0; slivers < SLIVERS; ++slivers) {
        const int first = corner_of(model, *patch, end[0]);
        const int opposite = 3 - first - corner_of(model, *patch, end[1]);
        const int other = haptable_patch_ends_beyond(model, *patch, opposite, at_m, thin_m);
        const uint16_t next = other < 0 ? HAPTABLE_NONE : across_begin(model, *patch, other).patch;
        if (next == HAPTABLE_NONE) break;
        end[other == first ? 0 : 1] = model->patch[*patch][opposite];
        *patch = next;
    }
}

const struct haptable_slivers haptable_slivers_of_patches = {is_thin, see_beyond, along_edge, beyond};
const struct haptable_slivers haptable_slivers_of_corners = {0, see_beyond, along_edge, beyond};
