/* SPDX-License-Identifier: MIT
 *
 * How patches go on where a ring of them ends: at the border of the touch region, and at hinges, vertices with more
 * than one ring and edges with more than two patches. Closed bodies without a hinge do not link this.
 */
#include "haptable_surface.h"

/* The first of the table's patches at the vertex; where it has none, that of the next vertex, or hinge_count. */
static uint16_t first_at(const struct haptable_model* model, uint16_t vertex) {
    uint16_t low = 0;
    uint16_t high = model->hinge_count;
    while (low < high) {
        const uint16_t middle = (uint16_t)((low + high) / 2);
        if (model->hinge[middle].vertex < vertex)
            low = (uint16_t)(middle + 1);
        else
            high = middle;
    }
    return low;
}

static int is_at(const struct haptable_model* model, uint16_t hinge, uint16_t vertex) {
    return hinge < model->hinge_count && model->hinge[hinge].vertex == vertex;
}

/* The patch's ring at the vertex whose entries begin at `first`. */
static uint16_t ring_of(const struct haptable_model* model, uint16_t first, uint16_t patch) {
    const uint16_t vertex = model->hinge[first].vertex;
    for (uint16_t i = first; is_at(model, i, vertex); ++i)
        if (model->hinge[i].patch == patch) return model->hinge[i].ring;
    return HAPTABLE_NONE;
}

/* A patch of the ring after that of `patch` at the vertex, in a circle of the rings; HAPTABLE_NONE where that is the
 * ring of `begin`. before: both patches have the vertex. */
static uint16_t next_ring(const struct haptable_model* model, uint16_t vertex, uint16_t patch, uint16_t begin) {
    const uint16_t first = first_at(model, vertex);
    uint16_t i;
    if (!is_at(model, first, vertex)) return HAPTABLE_NONE;
    const uint16_t ring = ring_of(model, first, patch);
    for (i = first; is_at(model, i, vertex) && model->hinge[i].ring <= ring; ++i) {
    }
    if (!is_at(model, i, vertex)) i = first; /* the circle closes */
    return model->hinge[i].ring == ring_of(model, first, begin) ? HAPTABLE_NONE : model->hinge[i].patch;
}

static int has_vertex(const struct haptable_model* model, uint16_t patch, uint16_t vertex) {
    const uint16_t* v = model->patch[patch];
    return v[0] == vertex || v[1] == vertex || v[2] == vertex;
}

static uint16_t next_across(const struct haptable_model* model, uint16_t patch, int corner, uint16_t last) {
    const uint16_t vertex = vertex_after(model, patch, corner);
    const uint16_t other = vertex_before(model, patch, corner);
    const uint16_t neighbour = model->neighbour[patch][corner];
    int is_after = last == neighbour;
    for (uint16_t i = first_at(model, vertex); is_at(model, i, vertex); ++i) {
        const uint16_t next = model->hinge[i].patch;
        if (next == patch || next == neighbour || !has_vertex(model, next, other)) continue;
        if (is_after) return next;
        is_after = next == last;
    }
    return HAPTABLE_NONE;
}

static struct fan fan_at(const struct haptable_model* model, struct fan fan, uint16_t patch) {
    fan.patch = patch;
    if (patch != HAPTABLE_NONE) fan.corner = corner_of(model, patch, fan.vertex);
    return fan;
}

static struct fan turned(const struct haptable_model* model, struct fan fan) {
    if (!fan.clockwise && fan_turn(model, &fan) == HAPTABLE_NONE) {
        fan = fan_at(model, fan, fan.first);
        fan.clockwise = 1;
        const uint16_t next = fan_turn(model, &fan);
        if (next != HAPTABLE_NONE) return fan_at(model, fan, next);
    }
    fan.first = next_ring(model, fan.vertex, fan.first, fan.begin);
    fan.clockwise = 0;
    return fan_at(model, fan, fan.first);
}

const struct haptable_hinges haptable_hinges_of_table = {turned, next_across};
