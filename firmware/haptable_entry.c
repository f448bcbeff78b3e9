/* SPDX-License-Identifier: MIT
 *
 * The first patch that a finger's segment crosses from outside to inside, by a tree of boxes
 */
#include "haptable_entry.h"

#include "haptable_bounds.h"
#include "haptable_patch.h"
#include "haptable_side.h"
#include "haptable_surface.h"

/* The surface as it is seen along a segment, which comes from the origin of a plane: coordinates less their part along
 * the segment, with its longest axis as the depth (Woop, Benthin and Wald 2013). A vertex has one place in this plane,
 * whatever patch has it, and the side of an edge there is a sign of the difference of two products, which rounding
 * cannot turn: patches that meet at an edge or a vertex leave no gap, and no segment slips between. */
struct view {
    int right; /* axes: the one along the segment is the depth */
    int up;
    int depth;
    float shift[2]; /* by the depth */
    float turn;     /* 1, or -1 where right and up, seen from the segment's begin, are left-handed */
};

/* The view is of no use where the segment has no length: that enters nothing. */
static void view_along(const float along[3], struct view* view) {
    float most = vec_magnitude(along[0]);
    int depth = 0;
    if (vec_magnitude(along[1]) > most) {
        most = vec_magnitude(along[1]);
        depth = 1;
    }
    if (vec_magnitude(along[2]) > most) depth = 2;
    view->depth = depth;
    view->right = next_corner(depth);
    view->up = previous_corner(depth);
    view->turn = along[depth] < 0.0f ? -1.0f : 1.0f;
    view->shift[0] = along[view->right] / along[depth];
    view->shift[1] = along[view->up] / along[depth];
}

static inline void see_vertex(const struct view* view, const float vertex_m[3], const float from_m[3], float seen[2]) {
    const float depth = vertex_m[view->depth] - from_m[view->depth];
    seen[0] = vertex_m[view->right] - from_m[view->right] - view->shift[0] * depth;
    seen[1] = vertex_m[view->up] - from_m[view->up] - view->shift[1] * depth;
}

/* 1 where the segment, as a line, goes through the patch: past no edge on the side where that is not. */
static int goes_through(const struct haptable_model* model, uint16_t patch, const struct view* view,
                        const float from_m[3]) {
    float seen[3][2];
    for (int i = 0; i < 3; ++i) see_vertex(view, vertex_of(model, patch, i), from_m, seen[i]);
    for (int i = 0; i < 3; ++i) {
        const float* a = seen[i];
        const float* b = seen[next_corner(i)];
        if (view->turn * (a[0] * b[1] - a[1] * b[0]) > 0.0f) return 0;
    }
    return 1;
}

/* 1 where the patch is one of those that the segment leaves. */
HAPTABLE_CALLED int is_left(const struct haptable_model* model, const struct haptable_segment* segment,
                            uint16_t patch) {
    const uint16_t* v = model->patch[patch];
    if (segment->left[0] == HAPTABLE_NONE) return 0;
    for (int i = 0; i < 3; ++i) {
        const uint16_t left = segment->left[i];
        if (left != v[0] && left != v[1] && left != v[2]) return 0;
    }
    return 1;
}

/* A patch as a segment sees it. */
struct over_patch {
    float edge1[3];
    float edge2[3];
    float normal[3];
    float end_m[3]; /* the segment's end, from corner 0 */
    float start;    /* the segment's height there, and at its end: times the normal's length */
    float end;
};

static void measure_heights(const struct haptable_model* model, uint16_t patch, const struct haptable_segment* segment,
                            struct over_patch* over) {
    const float* corner_m = vertex_of(model, patch, 0);
    patch_frame(model, patch, over->edge1, over->edge2, over->normal);
    vec_sub(segment->from_m, corner_m, over->end_m);
    over->start = vec_dot(over->normal, over->end_m);
    vec_sub(segment->to_m, corner_m, over->end_m);
    over->end = vec_dot(over->normal, over->end_m);
}

/* A height squared, in tolerance_m: in metres a body of micrometres would leave no float. */
static float in_tolerance2(const struct haptable_model* model, float height) {
    const float heights = height / model->tolerance_m;
    return heights * heights;
}

/* How far behind a patch that it leaves a segment may begin to enter it, in tolerance_m: the rounding of a coordinate.
 * Farther behind it came through the patch. */
#define BEHIND 0.0625f

/* 1 where the segment may begin at its height over the patch and end under it to enter it. start2: the height squared,
 * in tolerance_m; near2: the normal's length squared. A segment that stays within rounding of a patch runs along it,
 * and one from the surface that stays within the tolerance: where it would cross it is anywhere. */
static int may_enter(const struct haptable_model* model, const struct haptable_segment* segment, uint16_t patch,
                     const struct over_patch* over, float start2, float near2) {
    const float behind2 = BEHIND * BEHIND * near2;
    const float along2 = segment->left[0] == HAPTABLE_NONE ? behind2 : near2;
    if (start2 <= along2 && in_tolerance2(model, over->end) <= along2) return 0;
    if (!is_left(model, segment, patch)) return over->start >= 0.0f || start2 <= near2;
    return segment->is_beside && (over->start >= 0.0f || start2 <= behind2);
}

/* 1 where a finger's path begins within tolerance_m of the patch: it begins on it then. Rounding may have put the begin
 * of such a path past the patch's edge, or the line through its plane anywhere. */
static int begins_on(const struct haptable_model* model, const struct haptable_segment* segment, uint16_t patch,
                     float start2, float near2) {
    struct haptable_contact on;
    if (segment->left[0] != HAPTABLE_NONE || start2 > near2) return 0;
    haptable_patch_nearest(model, patch, segment->from_m, &on);
    return gap2(on.god_object_m, segment->from_m) <= model->tolerance_m * model->tolerance_m;
}

/* 1 when the segment crosses the patch from outside to inside. */
static int enters(const struct haptable_model* model, uint16_t patch, const struct haptable_segment* segment,
                  const struct view* view, const struct over_patch* over) {
    if (over->end >= 0.0f || over->end >= over->start) return 0;
    const float near2 = vec_length2(over->normal);
    const float start2 = in_tolerance2(model, over->start);
    return may_enter(model, segment, patch, over, start2, near2) &&
           (goes_through(model, patch, view, segment->from_m) || begins_on(model, segment, patch, start2, near2));
}

/* A segment along an axis of the grid, in its steps: the middle, half the extent, and that half's magnitude. */
struct grid_axis {
    float middle;
    float half;
    float size;
};

static void to_grid(const struct haptable_model* model, const struct haptable_segment* segment,
                    struct grid_axis grid[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        const float a = (segment->from_m[axis] - model->grid_origin_m[axis]) * model->grid_per_m;
        const float b = (segment->to_m[axis] - model->grid_origin_m[axis]) * model->grid_per_m;
        grid[axis].middle = 0.5f * (a + b);
        grid[axis].half = 0.5f * (b - a);
        grid[axis].size = vec_magnitude(grid[axis].half);
    }
}

/* Separating axes of a segment and a box: the box's three, then the three that are square to both. Codegen made the
 * boxes at least two steps too large on every side, which covers the rounding here. */
static int meets_box(const struct grid_axis grid[3], const struct haptable_box* box) {
    float offset[3], half[3];
    int j = 1;
    int k = 2;
    for (int i = 0; i < 3; ++i) {
        half[i] = 0.5f * ((float)box->high[i] - (float)box->low[i]);
        offset[i] = grid[i].middle - (float)box->low[i] - half[i];
        if (vec_magnitude(offset[i]) > half[i] + grid[i].size) return 0;
    }
    for (int i = 0; i < 3; ++i) {
        const float distance = vec_magnitude(offset[j] * grid[k].half - offset[k] * grid[j].half);
        if (distance > half[j] * grid[k].size + half[k] * grid[j].size + grid[j].size + grid[k].size) return 0;
        j = k;
        k = i;
    }
    return 1;
}

/* ---- clearance ------------------------------------------------------------------------------------------------ */

/* A ball around the segment's end in which no surface lies, as far as it was searched; in tolerance_m. */
struct clearance {
    float radius; /* 0: none */
    float least;  /* below which it is none: the segment's length, as far as the finger comes in a tick */
    float steps;  /* of the grid in tolerance_m */
};

/* It is sought as far as a finger comes in so many ticks that goes on as it goes, or, where it rests, in tolerance_m:
 * then most boxes are soon known to be farther. */
#define CLEAR_TICKS 32.0f
#define CLEAR_REST 4096.0f

/* Begins with the clearance of the segment's end. There is none where the search goes on, or looks from the surface. */
static void begin_clearance(const struct haptable_model* model, const struct haptable_segment* segment,
                            const float along[3], struct clearance* clear) {
    if (segment->box != 0 || segment->left[0] != HAPTABLE_NONE) return;
    clear->least = vec_length2(along) * haptable_side_inverse_length(along) / model->tolerance_m;
    clear->radius = CLEAR_TICKS * clear->least + CLEAR_REST;
    clear->steps = model->grid_per_m * model->tolerance_m;
}

/* Limits it to what the segment is far from a box along one of the box's axes. */
static void limit_by_box(const struct grid_axis grid[3], const struct haptable_box* box, struct clearance* clear) {
    const float enough = clear->radius * clear->steps;
    float gap = 0.0f;
    for (int i = 0; i < 3; ++i) {
        const float under = (float)box->low[i] - grid[i].middle - grid[i].size;
        const float over = grid[i].middle - grid[i].size - (float)box->high[i];
        if (under > gap) gap = under;
        if (over > gap) gap = over;
        if (gap >= enough) return;
    }
    gap /= clear->steps;
    clear->radius = gap > clear->least ? gap : 0.0f;
}

/* How far x is from the box of a patch along the axis where that is farthest; from corner 0, with these edges there. */
static float gap_to_patch(const float edge1[3], const float edge2[3], const float x[3]) {
    float gap = 0.0f;
    for (int i = 0; i < 3; ++i) {
        const float least = edge1[i] < edge2[i] ? edge1[i] : edge2[i];
        const float most = edge1[i] < edge2[i] ? edge2[i] : edge1[i];
        const float under = (least < 0.0f ? least : 0.0f) - x[i];
        const float over = x[i] - (most > 0.0f ? most : 0.0f);
        if (under > gap) gap = under;
        if (over > gap) gap = over;
    }
    return gap;
}

/* The sine of the angle between a patch's edges from which on its plane is where its points are: rounding turns the
 * normal by less than 5e-6 then. */
#define SINE_OF_PLANE 0.0625f

/* Limits it to what the segment's end is far from a patch: no less than its height over the patch's plane, nor than
 * its distance from the patch's box. */
static void limit_by_patch(const struct haptable_model* model, const struct over_patch* over, struct clearance* clear) {
    const float area2 = vec_length2(over->normal);
    float height = vec_magnitude(over->end) / model->tolerance_m;
    if (area2 <= SINE_OF_PLANE * SINE_OF_PLANE * vec_length2(over->edge1) * vec_length2(over->edge2)) height = 0.0f;
    if (height * height > clear->radius * clear->radius * area2) return;
    float far_away = gap_to_patch(over->edge1, over->edge2, over->end_m) / model->tolerance_m;
    if (far_away >= clear->radius) return;
    height *= haptable_side_inverse_length(over->normal);
    if (far_away < height) far_away = height;
    clear->radius = far_away > clear->least ? far_away : 0.0f;
}

/* What is taken off a clearance covers the rounding of heights (see SINE_OF_PLANE) and grid steps, and leaves more than
 * the tolerance around the patches. */
#define CLEAR_SHARE 0.99f
#define CLEAR_STEPS 2.0f

/* Keeps the clearance of a search that met nothing: one that found a patch has none. */
static void keep_clearance(const struct haptable_model* model, const struct clearance* clear,
                           struct haptable_segment* segment) {
    if (clear->radius <= 0.0f || segment->unfinished) return;
    const float radius_m = CLEAR_SHARE * clear->radius * model->tolerance_m - CLEAR_STEPS / model->grid_per_m;
    if (radius_m <= 0.0f) return;
    vec_copy(segment->to_m, segment->from_m);
    segment->fraction = -radius_m;
}

static int is_within_clearance(const struct haptable_segment* segment, const float x_m[3]) {
    return gap2(x_m, segment->from_m) < segment->fraction * segment->fraction;
}

/* 1 where the path from its last position to x meets nothing, for both are within the clearance: a search of it would
 * say so. */
static int is_clear(const struct haptable_segment* segment, const float x_m[3]) {
    return !segment->unfinished && segment->fraction < 0.0f && is_within_clearance(segment, x_m) &&
           is_within_clearance(segment, segment->to_m);
}

/* ---- the search ----------------------------------------------------------------------------------------------- */

/* Takes the leaf's patch that the segment enters first, if it comes before the one that was found; as long as there is
 * none, its patches limit the clearance. */
static void enter_leaf(const struct haptable_model* model, uint16_t first, const struct view* view,
                       struct haptable_segment* segment, struct clearance* clear) {
    for (uint16_t patch = first; patch < model->patch_count && patch < first + HAPTABLE_LEAF; ++patch) {
        struct over_patch over;
        measure_heights(model, patch, segment, &over);
        if (enters(model, patch, segment, view, &over)) {
            const float here = over.start > 0.0f ? over.start / (over.start - over.end) : 0.0f;
            if (here >= segment->fraction) continue;
            segment->fraction = here;
            segment->patch = patch;
            clear->radius = 0.0f;
        } else if (clear->radius > 0.0f) {
            limit_by_patch(model, &over, clear);
        }
    }
}

/* Searches the segment with what is left of the boxes that the tick has: depth first, so that one index is all that a
 * search which goes on later has to keep. */
HAPTABLE_CALLED void search(const struct haptable_model* model, struct haptable_segment* segment) {
    uint16_t box = segment->box;
    struct grid_axis grid[3];
    struct clearance clear = {0.0f, 0.0f, 0.0f};
    struct view view;
    float along[3];
    vec_sub(segment->to_m, segment->from_m, along);
    to_grid(model, segment, grid);
    view_along(along, &view);
    begin_clearance(model, segment, along, &clear);
    while (box < model->box_count && segment->boxes < HAPTABLE_TICK_BOXES) {
        const struct haptable_box* here = &model->box[box];
        ++segment->boxes;
        if (!meets_box(grid, here)) {
            if (clear.radius > 0.0f) limit_by_box(grid, here, &clear);
            box = here->skip;
            continue;
        }
        if (here->patch != HAPTABLE_NONE) enter_leaf(model, here->patch, &view, segment, &clear);
        ++box;
    }
    segment->box = box;
    segment->unfinished = box < model->box_count;
    keep_clearance(model, &clear, segment);
}

HAPTABLE_CALLED void begin(const float from_m[3], const float to_m[3], struct haptable_segment* segment) {
    vec_copy(from_m, segment->from_m);
    vec_copy(to_m, segment->to_m);
    segment->left[0] = HAPTABLE_NONE;
    segment->is_beside = 0;
    segment->fraction = 2.0f; /* beyond the segment's end */
    segment->patch = HAPTABLE_NONE;
    segment->box = 0;
    segment->unfinished = 1;
}

/* The patches that the point lies on are left. */
static void leave(const struct haptable_model* model, const struct haptable_contact* from,
                  struct haptable_segment* segment) {
    const uint16_t* v = model->patch[from->patch];
    const int on = from->alpha[0] > 0.0f ? 0 : (from->alpha[1] > 0.0f ? 1 : 2);
    for (int corner = 0; corner < 3; ++corner) segment->left[corner] = v[from->alpha[corner] > 0.0f ? corner : on];
}

void haptable_segment_step_back(const struct haptable_model* model, struct haptable_segment* segment) {
    float along[3];
    vec_sub(segment->to_m, segment->from_m, along);
    const float back = model->tolerance_m * haptable_side_inverse_length(along);
    vec_add_scaled(back < 0.5f ? -back : -0.5f, along, segment->to_m);
}

void haptable_segment_entry(const struct haptable_model* model, const struct haptable_segment* segment,
                            struct haptable_contact* contact) {
    float entry[3], along[3];
    vec_copy(segment->from_m, entry);
    vec_sub(segment->to_m, segment->from_m, along);
    vec_add_scaled(segment->fraction, along, entry);
    haptable_patch_nearest(model, segment->patch, entry, contact);
}

enum haptable_sight haptable_segment_search(const struct haptable_model* model, struct haptable_servo* servo) {
    struct haptable_segment* segment = &servo->segment;
    struct haptable_counters* counters = &servo->counters;
    search(model, segment);
    if (segment->boxes > counters->most_boxes) counters->most_boxes = segment->boxes;
    if (segment->unfinished) {
        ++counters->box_limits;
        return HAPTABLE_SIGHT_UNFINISHED;
    }
    return segment->patch == HAPTABLE_NONE ? HAPTABLE_SIGHT_CLEAR : HAPTABLE_SIGHT_BLOCKED;
}

int haptable_surface_enter(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    struct haptable_segment* segment = &servo->segment;
    enum haptable_sight sight;
    if (is_clear(segment, x_m)) {
        vec_copy(x_m, segment->to_m);
        return 0;
    }
    do {
        if (!segment->unfinished) begin(segment->to_m, x_m, segment);
        sight = haptable_segment_search(model, servo);
    } while (sight == HAPTABLE_SIGHT_CLEAR && gap2(segment->to_m, x_m) > 0.0f); /* that was an earlier tick's */
    if (sight != HAPTABLE_SIGHT_BLOCKED) return 0;
    haptable_segment_entry(model, segment, &servo->contact);
    ++servo->counters.contacts;
    return 1;
}

/* So much of the line from a point of the surface, in tolerance_m, is too near to it to be anywhere: twice as far as an
 * edge next to the point may be, and a vertex. */
#define LEFT_OUT (2.0f * HAPTABLE_EDGE_REACH)
#define LEFT_OUT_AT_VERTEX (2.0f * HAPTABLE_VERTEX_REACH)

/* Begins the line to x at a point of it that is on that side, on or next to what `at` is on. A line along the surface
 * runs tolerance_m outwards of it, where nothing is rounding. Returns 0 for one that begins inside. */
static int begin_on(const struct haptable_model* model, const struct haptable_contact* at, enum haptable_side side,
                    const float from_m[3], const float x_m[3], struct haptable_segment* segment) {
    if (side == HAPTABLE_SIDE_INSIDE) return 0;
    begin(from_m, x_m, segment);
    if (side == HAPTABLE_SIDE_ALONG) {
        float outward[3];
        haptable_side_outward(model, at, outward);
        const float scale = model->tolerance_m * haptable_side_inverse_length(outward);
        vec_add_scaled(scale, outward, segment->from_m);
        vec_add_scaled(scale, outward, segment->to_m);
    }
    leave(model, at, segment);
    segment->is_beside = side == HAPTABLE_SIDE_ALONG;
    return 1;
}

/* The line from a point beside the edge or the vertex `at`, past which it may leave the body: it begins where it is out
 * of their reach. Returns 1 where it is not inside there. before: |u| > tolerance_m. */
static int begin_beside(const struct haptable_model* model, const struct haptable_contact* from,
                        const struct haptable_contact* at, const float x_m[3], const float u[3],
                        struct haptable_segment* segment) {
    int corner;
    const float left_out = haptable_patch_feature(at->alpha, &corner) == ON_VERTEX ? LEFT_OUT_AT_VERTEX : LEFT_OUT;
    const float out = left_out * model->tolerance_m * haptable_side_inverse_length(u);
    float begin_m[3], from_border[3];
    vec_copy(from->god_object_m, begin_m);
    vec_add_scaled(out < 0.5f ? out : 0.5f, u, begin_m);
    vec_sub(begin_m, at->god_object_m, from_border);
    const enum haptable_side side = haptable_side_of(model, at, from_border);
    if (!begin_on(model, at, side, begin_m, x_m, segment)) return 0;
    segment->is_beside = 1;
    return 1;
}

/* The line from a point on an edge or a vertex, or next to one. Returns 1 where it does not begin inside. */
static int begin_near_border(const struct haptable_model* model, const struct haptable_contact* from,
                             const float x_m[3], const float u[3], struct haptable_segment* segment) {
    const float rounding_m = HAPTABLE_ROUNDING * model->tolerance_m;
    struct haptable_contact at = *from;
    float u_at[3];
    haptable_patch_onto_border(model, &at);
    if (gap2(at.god_object_m, from->god_object_m) > rounding_m * rounding_m)
        return begin_beside(model, from, &at, x_m, u, segment);
    vec_sub(x_m, at.god_object_m, u_at);
    return begin_on(model, &at, haptable_side_of(model, &at, u_at), at.god_object_m, x_m, segment);
}

enum haptable_sight haptable_surface_sight(const struct haptable_model* model, struct haptable_servo* servo,
                                           const struct haptable_contact* from, const float x_m[3]) {
    struct haptable_segment* segment = &servo->segment;
    float u[3];
    int begins;
    vec_sub(x_m, from->god_object_m, u);
    if (vec_length2(u) <= model->tolerance_m * model->tolerance_m) return HAPTABLE_SIGHT_INSIDE;
    if (haptable_patch_is_near_border(model, from))
        begins = begin_near_border(model, from, x_m, u, segment);
    else
        begins = begin_on(model, from, side_of_patch(model, from->patch, u), from->god_object_m, x_m, segment);
    return begins ? haptable_segment_search(model, servo) : HAPTABLE_SIGHT_INSIDE;
}
