/* SPDX-License-Identifier: MIT
 *
 * g = argmin |x - g| over the surface, by descent from patch to neighbouring patch
 *
 * Why the walk ends: with g on a patch and q the point of that patch nearest to the finger x, |x - q|^2 <=
 * |x - g|^2 - |q - g|^2, because a triangle is convex. Every move to a neighbour therefore brings the god-object
 * nearer by more than tolerance_m squared, and no patch is visited twice.
 */
#include "contact.h"

#include "vector.h"

static int next_corner(int corner) { return corner == 2 ? 0 : corner + 1; }

static int previous_corner(int corner) { return corner == 0 ? 2 : corner - 1; }

static const float* vertex_of(const struct haptable_model* model, uint16_t patch, int corner) {
    return model->vertex_m[model->patch[patch][corner]];
}

/* The two edges from corner 0, and their cross product: along the outward normal, twice the patch's area long. */
static inline void patch_frame(const struct haptable_model* model, uint16_t patch, float edge1[3], float edge2[3],
                               float normal[3]) {
    const float* origin = vertex_of(model, patch, 0);
    vec_sub(vertex_of(model, patch, 1), origin, edge1);
    vec_sub(vertex_of(model, patch, 2), origin, edge2);
    vec_cross(edge1, edge2, normal);
}

static float gap2(const float a[3], const float b[3]) {
    float d[3];
    vec_sub(a, b, d);
    return vec_dot(d, d);
}

/* ---- nearest point of one patch ------------------------------------------------------------------------------- */

static void place(const struct haptable_model* model, struct haptable_contact* contact) {
    const float* a = vertex_of(model, contact->patch, 0);
    const float* b = vertex_of(model, contact->patch, 1);
    const float* c = vertex_of(model, contact->patch, 2);
    const float* alpha = contact->alpha;
    contact->god_object_m[0] = alpha[0] * a[0] + alpha[1] * b[0] + alpha[2] * c[0];
    contact->god_object_m[1] = alpha[0] * a[1] + alpha[1] * b[1] + alpha[2] * c[1];
    contact->god_object_m[2] = alpha[0] * a[2] + alpha[1] * b[2] + alpha[2] * c[2];
}

/* The best point so far of a patch's border. */
struct on_border {
    int corner;  /* opposite to the edge */
    float share; /* of the edge, from the corner after it to the corner before it */
    float gap2;  /* to the finger, squared; negative: none yet */
};

/* Takes the nearest point of the edge opposite to `corner`, if it is nearer. */
static inline void nearest_on_edge(const struct haptable_model* model, uint16_t patch, int corner, const float x_m[3],
                                   struct on_border* best) {
    const float* from = vertex_of(model, patch, next_corner(corner));
    float along[3];
    float to_x[3];
    float length2;
    float share;
    float gap2_here;
    vec_sub(vertex_of(model, patch, previous_corner(corner)), from, along);
    vec_sub(x_m, from, to_x);
    length2 = vec_dot(along, along);
    share = length2 > 0.0f ? vec_clamp01(vec_dot(to_x, along) / length2) : 0.0f;
    vec_add_scaled(-share, along, to_x);
    gap2_here = vec_dot(to_x, to_x);
    if (best->gap2 >= 0.0f && gap2_here >= best->gap2) return;
    best->corner = corner;
    best->share = share;
    best->gap2 = gap2_here;
}

/* Area coordinates of x's foot on the patch's plane (eq. 11), by triple products with the normal: these keep their
 * digits on thin patches, where the determinant of the edges' dot products loses them.
 * A patch without area gives three negative numbers. */
static void area_coordinates(const struct haptable_model* model, uint16_t patch, const float x_m[3], float alpha[3]) {
    float edge1[3];
    float edge2[3];
    float normal[3];
    float to_x[3];
    float across[3];
    float area2;
    patch_frame(model, patch, edge1, edge2, normal);
    vec_sub(x_m, vertex_of(model, patch, 0), to_x);
    vec_cross(normal, to_x, across);
    area2 = vec_dot(normal, normal);
    alpha[0] = alpha[1] = alpha[2] = -1.0f;
    if (!(area2 > 0.0f)) return;
    alpha[1] = vec_dot(across, edge2) / area2;
    alpha[2] = -vec_dot(across, edge1) / area2;
    alpha[0] = 1.0f - alpha[1] - alpha[2];
}

/* The nearest point lies inside, or on an edge whose opposite area coordinate is negative. */
void contact_nearest(const struct haptable_model* model, uint16_t patch, const float x_m[3],
                     struct haptable_contact* nearest) {
    struct on_border best = {0, 0.0f, -1.0f};
    float alpha[3];
    area_coordinates(model, patch, x_m, alpha);
    nearest->patch = patch;
    if (!(alpha[0] >= 0.0f)) nearest_on_edge(model, patch, 0, x_m, &best);
    if (!(alpha[1] >= 0.0f)) nearest_on_edge(model, patch, 1, x_m, &best);
    if (!(alpha[2] >= 0.0f)) nearest_on_edge(model, patch, 2, x_m, &best);
    if (best.gap2 >= 0.0f) {
        alpha[best.corner] = 0.0f;
        alpha[next_corner(best.corner)] = 1.0f - best.share;
        alpha[previous_corner(best.corner)] = best.share;
    }
    vec_copy(alpha, nearest->alpha);
    place(model, nearest);
}

/* ---- walking around a vertex ---------------------------------------------------------------------------------- */

static int corner_of(const struct haptable_model* model, uint16_t patch, uint16_t vertex) {
    const uint16_t* v = model->patch[patch];
    if (v[0] == vertex) return 0;
    return v[1] == vertex ? 1 : 2;
}

/* The patches around one vertex, one after the other: counter-clockwise until the round closes or meets the border of
 * the touch region, then, from the first patch, clockwise. */
struct fan {
    uint16_t vertex;
    uint16_t first;
    uint16_t patch;
    int corner; /* of the patch, where the vertex is */
    int clockwise;
};

static struct fan fan_begin(const struct haptable_model* model, uint16_t patch, int corner) {
    struct fan fan;
    fan.vertex = model->patch[patch][corner];
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
static inline int fan_next(const struct haptable_model* model, struct fan* fan) {
    uint16_t next = fan_turn(model, fan);
    if (next == HAPTABLE_NONE && !fan->clockwise) {
        fan->clockwise = 1;
        fan->patch = fan->first;
        fan->corner = corner_of(model, fan->first, fan->vertex);
        next = fan_turn(model, fan);
    }
    if (next == HAPTABLE_NONE || next == fan->first) return 0;
    fan->patch = next;
    fan->corner = corner_of(model, next, fan->vertex);
    return 1;
}

/* ---- sliding -------------------------------------------------------------------------------------------------- */

/* Where a point of a patch lies: inside, on the edge opposite to `corner`, or on the vertex at `corner`. */
enum place_on_patch { INSIDE, ON_EDGE, ON_VERTEX };

static enum place_on_patch feature_of(const float alpha[3], int* corner) {
    const int zero0 = alpha[0] == 0.0f;
    const int zero1 = alpha[1] == 0.0f;
    const int zeros = zero0 + zero1 + (alpha[2] == 0.0f);
    if (zeros == 0) return INSIDE;
    if (zeros == 1) {
        *corner = zero0 ? 0 : (zero1 ? 1 : 2);
        return ON_EDGE;
    }
    *corner = !zero0 ? 0 : (!zero1 ? 1 : 2);
    return ON_VERTEX;
}

/* Steps of the walk: an edge's length along the finger's way is one, a patch's nearest point costs as much as six. */
enum { STEPS_OF_TWO_EDGES = 2, STEPS_OF_PATCH = 6 };

/* 1 when the neighbour's point lies elsewhere, and so nearer (see the head of this file). */
static int is_move(const struct haptable_model* model, const struct haptable_contact* from,
                   const struct haptable_contact* to) {
    return gap2(from->god_object_m, to->god_object_m) > model->tolerance_m * model->tolerance_m;
}

/* Tries the patch across the edge. Returns 1 when the god-object moved on to it. */
static int cross_edge(const struct haptable_model* model, int corner, const float x_m[3],
                      struct haptable_contact* contact, int* steps) {
    const uint16_t across = model->neighbour[contact->patch][corner];
    struct haptable_contact next;
    if (across == HAPTABLE_NONE) return 0;
    *steps += STEPS_OF_PATCH;
    contact_nearest(model, across, x_m, &next);
    if (!is_move(model, contact, &next)) return 0;
    *contact = next;
    return 1;
}

/* One edge away from the vertex v that the god-object is on. */
struct spoke {
    float along[3]; /* e, to the edge's other vertex */
    float rise;     /* (x - v) . e: positive where the edge leads nearer to the finger x */
    float length2;  /* e . e */
};

static inline struct spoke spoke_to(const struct haptable_model* model, uint16_t vertex, const float at_m[3],
                                    const float to_x[3]) {
    struct spoke spoke;
    vec_sub(model->vertex_m[vertex], at_m, spoke.along);
    spoke.rise = vec_dot(to_x, spoke.along);
    spoke.length2 = vec_dot(spoke.along, spoke.along);
    return spoke;
}

/* Long slides go from vertex to neighbouring vertex, at a tenth of the cost of a patch. Goes to the one that is nearest
 * to x, if that is by more than a quarter of the edge nearer, squared: rounding cannot send it back. On the straight
 * way there the distance to x is never more than at its begin, so this is a slide, if a coarse one. Returns 1 when the
 * god-object moved. */
static int step_along_edge(const struct haptable_model* model, int* corner, const float x_m[3],
                           struct haptable_contact* contact, int* steps) {
    struct fan fan = fan_begin(model, contact->patch, *corner);
    const float* at_m = model->vertex_m[fan.vertex];
    float to_x[3];
    float most = 0.0f;
    uint16_t best = HAPTABLE_NONE;
    vec_sub(x_m, at_m, to_x);
    do {
        const uint16_t* v = model->patch[fan.patch];
        const uint16_t other = v[next_corner(fan.corner)];
        const struct spoke spoke = spoke_to(model, other, at_m, to_x);
        const float nearer2 = 2.0f * spoke.rise - spoke.length2;
        ++*steps;
        if (nearer2 <= most || spoke.rise <= 2.0f * spoke.length2) continue;
        most = nearer2;
        best = other;
        contact->patch = fan.patch;
    } while (*steps < HAPTABLE_WALK_STEPS && fan_next(model, &fan));
    if (best == HAPTABLE_NONE) return 0;
    vec_zero(contact->alpha);
    *corner = corner_of(model, contact->patch, best);
    contact->alpha[*corner] = 1.0f;
    vec_copy(model->vertex_m[best], contact->god_object_m);
    return 1;
}

/* 1 when the nearest point to x of the plane of two spokes lies between them: normal equations, solved by Cramer. */
static inline int leads_between(const struct spoke* one, const struct spoke* two) {
    const float both = vec_dot(one->along, two->along);
    return one->rise * two->length2 > two->rise * both && two->rise * one->length2 > one->rise * both;
}

/* Where the patches around a vertex lead. */
struct leaving {
    struct haptable_contact at_vertex;
    float gap2; /* of the best patch's point to x, squared: there the god-object is, once it has moved */
    int moved;
    float most;        /* what the steepest edge brings nearer to x, squared */
    uint16_t steepest; /* a patch with that edge; HAPTABLE_NONE: no edge leads nearer */
};

/* Takes the patch's nearest point when it is a move, and nearer to x than that of the patches before. */
static void try_patch(const struct haptable_model* model, uint16_t patch, const float x_m[3], struct leaving* leaving,
                      struct haptable_contact* contact) {
    struct haptable_contact next;
    float gap;
    contact_nearest(model, patch, x_m, &next);
    gap = gap2(next.god_object_m, x_m);
    if (!is_move(model, &leaving->at_vertex, &next) || (leaving->moved && gap >= leaving->gap2)) return;
    leaving->gap2 = gap;
    leaving->moved = 1;
    *contact = next;
}

static inline void note_edge(const struct spoke* spoke, uint16_t patch, struct leaving* leaving) {
    if (spoke->rise <= 0.0f || spoke->rise * spoke->rise <= leaving->most * spoke->length2) return;
    leaving->most = spoke->rise * spoke->rise / spoke->length2;
    leaving->steepest = patch;
}

/* Leaves the vertex for the patch around it that comes nearest to x, as far as the budget goes; returns 0 when none
 * comes nearer. A patch's nearest point lies on one of the two edges at the vertex, of which the steepest is enough, or
 * between them; only then does the patch need a look of its own. */
static int cross_vertex(const struct haptable_model* model, int corner, const float x_m[3],
                        struct haptable_contact* contact, int* steps) {
    struct fan fan = fan_begin(model, contact->patch, corner);
    const float* at_m = model->vertex_m[fan.vertex];
    struct leaving leaving = {*contact, 0.0f, 0, 0.0f, HAPTABLE_NONE};
    float to_x[3];
    vec_sub(x_m, at_m, to_x);
    do {
        const uint16_t* v = model->patch[fan.patch];
        const struct spoke one = spoke_to(model, v[next_corner(fan.corner)], at_m, to_x);
        const struct spoke two = spoke_to(model, v[previous_corner(fan.corner)], at_m, to_x);
        *steps += STEPS_OF_TWO_EDGES;
        note_edge(&one, fan.patch, &leaving);
        note_edge(&two, fan.patch, &leaving);
        if (!leads_between(&one, &two)) continue;
        *steps += STEPS_OF_PATCH;
        try_patch(model, fan.patch, x_m, &leaving, contact);
    } while (*steps < HAPTABLE_WALK_STEPS && fan_next(model, &fan));
    if (leaving.steepest == HAPTABLE_NONE || (leaving.moved && leaving.gap2 < vec_dot(to_x, to_x) - leaving.most))
        return leaving.moved;
    *steps += STEPS_OF_PATCH;
    try_patch(model, leaving.steepest, x_m, &leaving, contact);
    return leaving.moved;
}

/* From a vertex along edges as far as that goes, then into a patch. */
static int leave_vertex(const struct haptable_model* model, int corner, const float x_m[3],
                        struct haptable_contact* contact, int* steps) {
    while (*steps < HAPTABLE_WALK_STEPS)
        if (!step_along_edge(model, &corner, x_m, contact, steps))
            return *steps < HAPTABLE_WALK_STEPS && cross_vertex(model, corner, x_m, contact, steps);
    return 0;
}

/* Slides the god-object down to the nearest point of the surface around it. Returns 0 when it is not there yet. */
static int slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact, int* steps) {
    int moving = 1;
    *steps += STEPS_OF_PATCH;
    contact_nearest(model, contact->patch, x_m, contact);
    while (moving && *steps < HAPTABLE_WALK_STEPS) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(contact->alpha, &corner);
        moving = 0;
        if (feature == ON_EDGE) moving = cross_edge(model, corner, x_m, contact, steps);
        if (feature == ON_VERTEX) moving = leave_vertex(model, corner, x_m, contact, steps);
    }
    return *steps < HAPTABLE_WALK_STEPS;
}

/* ---- inside or outside ---------------------------------------------------------------------------------------- */

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

/* The outward direction at the god-object: the patch's normal, the mean of two at an edge, the mean weighted by
 * angles at a vertex. At a nearest point its sign against the finger tells inside from outside (Baerentzen and
 * Aanaes 2005); means with other weights do not. */
static void outward(const struct haptable_model* model, const struct haptable_contact* contact, float normal[3]) {
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

static int is_outside(const struct haptable_model* model, const struct haptable_contact* contact, const float x_m[3]) {
    float normal[3];
    float u[3];
    outward(model, contact, normal);
    vec_sub(x_m, contact->god_object_m, u);
    return vec_dot(normal, u) >= 0.0f;
}

/* ---- the first patch on a way --------------------------------------------------------------------------------- */

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

/* Where a way may begin: a finger's way within tolerance_m behind a patch (it let go there a tick ago), the way from
 * a god-object that has let go only farther than that in front of it (the patches around it are behind it). */
enum way_begins { AT_FINGER, AT_GOD_OBJECT };

/* `height` is the way's begin over the patch, times the length of `normal`. */
static int may_begin(const struct haptable_model* model, enum way_begins begins, float height, const float normal[3]) {
    const int is_near = height * height <= model->tolerance_m * model->tolerance_m * vec_dot(normal, normal);
    if (begins == AT_GOD_OBJECT) return height > 0.0f && !is_near;
    return height >= 0.0f || is_near;
}

/* One finger's way of one tick. */
struct way {
    float from_m[3];
    float to_m[3];
    enum way_begins begins;
};

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
    if (end >= 0.0f || end >= start || !may_begin(model, way->begins, start, normal)) return 0;
    vec_sub(way->to_m, way->from_m, step);
    if (side_of_edge(model, v[0], v[1], way->from_m, step) > 0.0f) return 0;
    if (side_of_edge(model, v[1], v[2], way->from_m, step) > 0.0f) return 0;
    if (side_of_edge(model, v[2], v[0], way->from_m, step) > 0.0f) return 0;
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

/* Begins contact where the way first crosses the surface inwards. Returns 0 when it does not. */
static int begin_contact(const struct haptable_model* model, const struct way* way, struct haptable_contact* contact,
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

/* ---- one tick ------------------------------------------------------------------------------------------------- */

/* One slide of a tick. Returns 1 when the god-object rests and the finger is on the outer side of it. A slide that met
 * the limit does not tell the sides apart: the contact holds until it is finished. */
static int has_left(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact,
                    int* steps, struct haptable_counters* counters) {
    const int rests = slide(model, x_m, contact, steps);
    if (!rests) ++counters->walk_limits;
    if ((uint32_t)*steps > counters->most_steps) counters->most_steps = (uint32_t)*steps;
    return rests && is_outside(model, contact, x_m);
}

void contact_move(const struct haptable_model* model, struct haptable_contact* contact, const float from_m[3],
                  const float to_m[3], struct haptable_counters* counters) {
    struct way way;
    int steps = 0;
    int slides;
    vec_copy(from_m, way.from_m);
    vec_copy(to_m, way.to_m);
    way.begins = AT_FINGER;
    for (slides = 0; slides < HAPTABLE_SLIDES; ++slides) {
        if (contact->patch == HAPTABLE_NONE && !begin_contact(model, &way, contact, counters)) return;
        if (!has_left(model, to_m, contact, &steps, counters)) return;
        /* The finger has left this part of the surface. Its way from there may enter another part. */
        vec_copy(contact->god_object_m, way.from_m);
        way.begins = AT_GOD_OBJECT;
        contact->patch = HAPTABLE_NONE;
    }
    ++counters->slide_limits;
}
