/* SPDX-License-Identifier: MIT
 *
 * The first patch that a finger's way crosses from outside to inside, by a tree of boxes
 */
#include "contact.h"
#include "surface.h"

/* Six times the signed volume of the way and one edge: on which side of the edge the way passes. Taken with the lower
 * vertex first, it is the same number, with the opposite sign, for both patches of an edge: no way slips between. */
static float side_of_edge(const struct haptable_model* model, uint16_t i, uint16_t j, const float from_m[3],
                          const float way[3]) {
    float a[3];
    float b[3];
    float normal[3];
    vec_sub(model->vertex_m[i < j ? i : j], from_m, a);
    vec_sub(model->vertex_m[i < j ? j : i], from_m, b);
    vec_cross(a, b, normal);
    return i < j ? vec_dot(way, normal) : -vec_dot(way, normal);
}

/* 1 when one can go from a patch to the other around a vertex that both have. */
static int are_around(const struct haptable_model* model, uint16_t patch, uint16_t other) {
    int corner;
    for (corner = 0; corner < 3; ++corner) {
        struct fan fan = fan_begin(model, patch, corner);
        int patches = 0;
        do
            if (fan.patch == other) return 1;
        while (++patches < HAPTABLE_FAN_PATCHES && fan_next(model, &fan));
    }
    return 0;
}

/* 1 where the way may begin at its height over the patch (start) to enter it; heights are times normal's length. */
static int may_begin(const struct haptable_model* model, const struct way* way, uint16_t patch, float start, float end,
                     const float normal[3]) {
    const float near2 = model->tolerance_m * model->tolerance_m * vec_dot(normal, normal);
    const int is_near = start * start <= near2;
    if (way->left == HAPTABLE_NONE || !is_near) return start >= 0.0f || is_near;
    return end * end > near2 && !are_around(model, way->left, patch);
}

/* 1 when the way crosses the patch from outside to inside; *share is where, 0 to 1 of the way. */
static int enters(const struct haptable_model* model, uint16_t patch, const struct way* way, float* share) {
    const uint16_t* v = model->patch[patch];
    float edge1[3];
    float edge2[3];
    float normal[3];
    float offset[3];
    float step[3];
    float start;
    float end;
    patch_frame(model, patch, edge1, edge2, normal);
    vec_sub(way->from_m, model->vertex_m[v[0]], offset);
    start = vec_dot(normal, offset);
    vec_sub(way->to_m, model->vertex_m[v[0]], offset);
    end = vec_dot(normal, offset);
    if (end >= 0.0f || end >= start) return 0;
    vec_sub(way->to_m, way->from_m, step);
    if (side_of_edge(model, v[0], v[1], way->from_m, step) > 0.0f) return 0;
    if (side_of_edge(model, v[1], v[2], way->from_m, step) > 0.0f) return 0;
    if (side_of_edge(model, v[2], v[0], way->from_m, step) > 0.0f) return 0;
    if (!may_begin(model, way, patch, start, end, normal)) return 0;
    *share = start > 0.0f ? start / (start - end) : 0.0f;
    return 1;
}

static float magnitude(float x) { return x < 0.0f ? -x : x; }

/* A way in grid steps: its middle and half its extent, and the magnitudes of that half. */
struct grid_way {
    float middle[3];
    float half[3];
    float reach[3];
};

static struct grid_way to_grid(const struct haptable_model* model, const struct way* way) {
    struct grid_way grid;
    int axis;
    for (axis = 0; axis < 3; ++axis) {
        const float a = (way->from_m[axis] - model->grid_origin_m[axis]) * model->grid_per_m;
        const float b = (way->to_m[axis] - model->grid_origin_m[axis]) * model->grid_per_m;
        grid.middle[axis] = 0.5f * (a + b);
        grid.half[axis] = 0.5f * (b - a);
        grid.reach[axis] = magnitude(grid.half[axis]);
    }
    return grid;
}

/* Separating axes of a segment and a box: the box's three, then the three that are square to both. Codegen made the
 * boxes at least two steps too large on every side, which covers the rounding here. */
static int meets_box(const struct grid_way* grid, const struct haptable_box* box) {
    float offset[3];
    float half[3];
    int i;
    for (i = 0; i < 3; ++i) {
        half[i] = 0.5f * ((float)box->high[i] - (float)box->low[i]);
        offset[i] = grid->middle[i] - (float)box->low[i] - half[i];
        if (magnitude(offset[i]) > half[i] + grid->reach[i]) return 0;
    }
    for (i = 0; i < 3; ++i) {
        const int j = i == 2 ? 0 : i + 1;
        const int k = i == 0 ? 2 : i - 1;
        const float distance = magnitude(offset[j] * grid->half[k] - offset[k] * grid->half[j]);
        if (distance > half[j] * grid->reach[k] + half[k] * grid->reach[j] + grid->reach[j] + grid->reach[k]) return 0;
    }
    return 1;
}

/* Takes the leaf's patch that the way enters first, if it comes before *share. */
static void enter_leaf(const struct haptable_model* model, uint16_t first, const struct way* way, float* share,
                       uint16_t* patch) {
    const int left = (int)model->patch_count - (int)first;
    const int count = left < HAPTABLE_LEAF ? left : HAPTABLE_LEAF;
    int i;
    for (i = 0; i < count; ++i) {
        const uint16_t candidate = (uint16_t)(first + i);
        float here;
        if (!enters(model, candidate, way, &here) || here >= *share) continue;
        *share = here;
        *patch = candidate;
    }
}

/* The first patch that the way enters, at *share of the way, by the spatial index; HAPTABLE_NONE if there is none. */
static uint16_t first_entry(const struct haptable_model* model, const struct way* way, float* share,
                            struct haptable_counters* counters) {
    const struct grid_way grid = to_grid(model, way);
    uint16_t patch = HAPTABLE_NONE;
    uint32_t visited = 0;
    uint16_t box = 0;
    *share = 2.0f; /* beyond the way's end */
    while (box < model->box_count) {
        const struct haptable_box* here = &model->box[box];
        ++visited;
        if (!meets_box(&grid, here)) {
            box = here->skip;
            continue;
        }
        if (here->patch != HAPTABLE_NONE) enter_leaf(model, here->patch, way, share, &patch);
        ++box;
    }
    if (visited > counters->most_boxes) counters->most_boxes = visited;
    return patch;
}

int surface_enter(const struct haptable_model* model, const struct way* way, struct haptable_contact* contact,
                  struct haptable_counters* counters) {
    float entry[3];
    float step[3];
    float share;
    const uint16_t patch = first_entry(model, way, &share, counters);
    if (patch == HAPTABLE_NONE) return 0;
    vec_copy(way->from_m, entry);
    vec_sub(way->to_m, way->from_m, step);
    vec_add_scaled(share, step, entry);
    contact_nearest(model, patch, entry, contact);
    ++counters->contacts;
    return 1;
}
