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

/* What a look around the three vertices of a patch costs, in boxes. */
#define BOXES_OF_FANS 5

/* 1 where the way may begin at its height over the patch (start) to enter it; heights are times normal's length. */
static int may_begin(const struct haptable_model* model, struct haptable_way* way, uint16_t patch, float start,
                     float end, const float normal[3]) {
    const float near2 = model->tolerance_m * model->tolerance_m * vec_dot(normal, normal);
    const int is_near = start * start <= near2;
    if (way->left == HAPTABLE_NONE || !is_near) return start >= 0.0f || is_near;
    if (end * end <= near2) return 0;
    way->boxes += BOXES_OF_FANS;
    return !are_around(model, way->left, patch);
}

/* 1 when the way crosses the patch from outside to inside; *share is where, 0 to 1 of the way. */
static int enters(const struct haptable_model* model, uint16_t patch, struct haptable_way* way, float* share) {
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

static struct grid_way to_grid(const struct haptable_model* model, const struct haptable_way* way) {
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

/* Takes the leaf's patch that the way enters first, if it comes before the one that was found. */
static void enter_leaf(const struct haptable_model* model, uint16_t first, struct haptable_way* way) {
    const int left = (int)model->patch_count - (int)first;
    const int count = left < HAPTABLE_LEAF ? left : HAPTABLE_LEAF;
    int i;
    for (i = 0; i < count; ++i) {
        const uint16_t candidate = (uint16_t)(first + i);
        float here;
        if (!enters(model, candidate, way, &here) || here >= way->share) continue;
        way->share = here;
        way->patch = candidate;
    }
}

/* Searches the way with what is left of the tick's boxes: depth first, so that one index is all that a search which
 * goes on later has to keep. */
static void search(const struct haptable_model* model, struct haptable_way* way) {
    const struct grid_way grid = to_grid(model, way);
    uint16_t box = way->box;
    while (box < model->box_count && way->boxes < HAPTABLE_TICK_BOXES) {
        const struct haptable_box* here = &model->box[box];
        ++way->boxes;
        if (!meets_box(&grid, here)) {
            box = here->skip;
            continue;
        }
        if (here->patch != HAPTABLE_NONE) enter_leaf(model, here->patch, way);
        ++box;
    }
    way->box = box;
    way->unfinished = box < model->box_count;
}

void surface_way(const float from_m[3], const float to_m[3], uint16_t left, struct haptable_way* way) {
    vec_copy(from_m, way->from_m);
    vec_copy(to_m, way->to_m);
    way->left = left;
    way->share = 2.0f; /* beyond the way's end */
    way->patch = HAPTABLE_NONE;
    way->box = 0;
    way->unfinished = 1;
}

static void enter(const struct haptable_model* model, const struct haptable_way* way, struct haptable_contact* contact,
                  struct haptable_counters* counters) {
    float entry[3];
    float step[3];
    vec_copy(way->from_m, entry);
    vec_sub(way->to_m, way->from_m, step);
    vec_add_scaled(way->share, step, entry);
    contact_nearest(model, way->patch, entry, contact);
    ++counters->contacts;
}

int surface_enter(const struct haptable_model* model, const float x_m[3], struct haptable_way* way,
                  struct haptable_contact* contact, struct haptable_counters* counters) {
    do {
        if (!way->unfinished) surface_way(way->to_m, x_m, HAPTABLE_NONE, way);
        search(model, way);
        if (way->boxes > counters->most_boxes) counters->most_boxes = way->boxes;
        if (way->unfinished) {
            ++counters->box_limits;
            return 0;
        }
    } while (way->patch == HAPTABLE_NONE && gap2(way->to_m, x_m) > 0.0f); /* that was an earlier tick's */
    if (way->patch == HAPTABLE_NONE) return 0;
    enter(model, way, contact, counters);
    return 1;
}

void surface_leave(const float x_m[3], struct haptable_way* way, struct haptable_contact* contact) {
    surface_way(contact->god_object_m, x_m, contact->patch, way);
    contact->patch = HAPTABLE_NONE;
}
