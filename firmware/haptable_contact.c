/* SPDX-License-Identifier: MIT
 *
 * g = argmin |x - g| over the surface, by descent from patch to neighbouring patch
 *
 * Why the walk ends: with g on a patch and q the point of that patch nearest to the finger x, |x - q|^2 <=
 * |x - g|^2 - |q - g|^2, because a triangle is convex. Every move to a neighbour therefore brings the god-object
 * nearer by more than tolerance_m squared, and no patch is visited twice.
 */
#include "haptable_contact.h"

#include "haptable_bounds.h"
#include "haptable_entry.h"
#include "haptable_patch.h"
#include "haptable_surface.h"

/* ---- sliding -------------------------------------------------------------------------------------------------- */

/* 1 when the neighbour's point lies elsewhere, and so nearer (see the head of this file). */
static int is_move(const struct haptable_model* model, const float from_m[3], const struct haptable_contact* to) {
    return gap2(from_m, to->god_object_m) > model->tolerance_m * model->tolerance_m;
}

/* Tries the patches across the edge. Returns 1 when the god-object moved on to one. */
static int cross_edge(const struct haptable_model* model, int corner, const float x_m[3],
                      struct haptable_contact* contact, int* steps) {
    struct across across = across_begin(model, contact->patch, corner);
    for (; across.patch != HAPTABLE_NONE && *steps < HAPTABLE_WALK_STEPS; across_next(model, &across)) {
        struct haptable_contact next;
        *steps += STEPS_OF_PATCH;
        haptable_patch_nearest(model, across.patch, x_m, &next);
        if (!is_move(model, contact->god_object_m, &next)) continue;
        *contact = next;
        return 1;
    }
    return 0;
}

/* Long slides go from vertex to neighbouring vertex, at a tenth of the cost of a patch. Goes to the one that is nearest
 * to x, if that is by more than a quarter of the edge nearer, squared: rounding cannot send it back. On the straight
 * line there the distance to x is never more than at its begin, so this is a slide, if a coarse one. Returns 1 when the
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
        const uint16_t other = vertex_after(model, fan.patch, fan.corner);
        struct edge edge;
        edge_to(model, other, at_m, to_x, &edge);
        const float nearer2 = 2.0f * edge.rise - edge.length2;
        ++*steps;
        if (nearer2 <= most || edge.rise <= 2.0f * edge.length2) continue;
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

/* Where one can go from a vertex. */
struct leaving {
    const float* at_m; /* the vertex */
    float gap2;        /* of the best patch's point to x, squared: there the god-object is, once it has moved */
    int moved;
    float most;        /* what the steepest edge brings nearer to x, squared */
    uint16_t steepest; /* a patch with that edge; HAPTABLE_NONE: no edge leads nearer */
};

/* Takes the patch's nearest point when it is a move, and nearer to x than that of the patches before. */
static void try_patch(const struct haptable_model* model, uint16_t patch, const float x_m[3], struct leaving* leaving,
                      struct haptable_contact* contact) {
    struct haptable_contact next;
    haptable_patch_nearest(model, patch, x_m, &next);
    const float gap = gap2(next.god_object_m, x_m);
    if (!is_move(model, leaving->at_m, &next) || (leaving->moved && gap >= leaving->gap2)) return;
    leaving->gap2 = gap;
    leaving->moved = 1;
    *contact = next;
}

HAPTABLE_CALLED void note_edge(const struct edge* edge, uint16_t patch, struct leaving* leaving) {
    if (edge->rise <= 0.0f || edge->rise * edge->rise <= leaving->most * edge->length2) return;
    leaving->most = edge->rise * edge->rise / edge->length2;
    leaving->steepest = patch;
}

/* Leaves the vertex for the patch around it that comes nearest to x, as far as the budget goes; returns 0 when none
 * comes nearer. A patch's nearest point lies on one of the two edges at the vertex, of which the steepest is enough, or
 * between them; only then is its nearest point to be found. */
static int cross_vertex(const struct haptable_model* model, int corner, const float x_m[3],
                        struct haptable_contact* contact, int* steps) {
    struct fan fan = fan_begin(model, contact->patch, corner);
    const float* at_m = model->vertex_m[fan.vertex];
    struct leaving leaving = {at_m, 0.0f, 0, 0.0f, HAPTABLE_NONE};
    float to_x[3];
    vec_sub(x_m, at_m, to_x);
    do {
        struct edge one, two;
        edge_to(model, vertex_after(model, fan.patch, fan.corner), at_m, to_x, &one);
        edge_to(model, vertex_before(model, fan.patch, fan.corner), at_m, to_x, &two);
        *steps += STEPS_OF_TWO_EDGES;
        note_edge(&one, fan.patch, &leaving);
        note_edge(&two, fan.patch, &leaving);
        if (!leads_between(&one, &two)) continue;
        *steps += STEPS_OF_PATCH;
        try_patch(model, fan.patch, x_m, &leaving, contact);
    } while (*steps < HAPTABLE_WALK_STEPS && fan_next(model, &fan));
    if (leaving.steepest == HAPTABLE_NONE || (leaving.moved && leaving.gap2 < vec_length2(to_x) - leaving.most))
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

/* See haptable_contact_slide. */
static int slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact, int* steps) {
    int moving = 1;
    *steps += STEPS_OF_PATCH;
    haptable_patch_nearest(model, contact->patch, x_m, contact);
    while (moving && *steps < HAPTABLE_WALK_STEPS) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(contact->alpha, &corner);
        moving = 0;
        if (feature == ON_EDGE) moving = cross_edge(model, corner, x_m, contact, steps);
        if (feature == ON_VERTEX) moving = leave_vertex(model, corner, x_m, contact, steps);
    }
    return *steps < HAPTABLE_WALK_STEPS;
}

/* For the other god-objects; where the nearest one is alone, it is not linked. */
int haptable_contact_slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact,
                           int* steps) {
    return slide(model, x_m, contact, steps);
}

/* ---- one tick ------------------------------------------------------------------------------------------------- */

static int slide_on(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3],
                    struct haptable_contact* contact, int* steps) {
    if (servo->slide_patch != HAPTABLE_NONE) contact->patch = servo->slide_patch;
    const int rests = slide(model, x_m, contact, steps);
    servo->slide_patch = rests ? HAPTABLE_NONE : contact->patch;
    if (!rests) ++servo->counters.walk_limits;
    if ((uint32_t)*steps > servo->counters.most_steps) servo->counters.most_steps = (uint32_t)*steps;
    return rests;
}

int haptable_contact_slide_on(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3],
                              struct haptable_contact* contact, int* steps) {
    return slide_on(model, servo, x_m, contact, steps);
}

void haptable_contact_end(struct haptable_servo* servo) {
    servo->contact.patch = HAPTABLE_NONE;
    servo->slide_patch = HAPTABLE_NONE;
    servo->undecided_ticks = 0;
    servo->fade_ticks = 0;
}

/* The finger is seen: its path goes on from there. */
static void let_go(const struct haptable_model* model, struct haptable_servo* servo) {
    haptable_segment_step_back(model, &servo->segment);
    haptable_contact_end(servo);
}

enum haptable_sight haptable_contact_look_on(const struct haptable_model* model, struct haptable_servo* servo) {
    if (servo->contact.patch == HAPTABLE_NONE || !servo->segment.unfinished) return HAPTABLE_SIGHT_INSIDE;
    const enum haptable_sight sight = haptable_segment_search(model, servo);
    if (sight == HAPTABLE_SIGHT_CLEAR) let_go(model, servo);
    if (sight == HAPTABLE_SIGHT_BLOCKED) servo->undecided_ticks = 0;
    return sight;
}

int haptable_contact_decide(const struct haptable_model* model, struct haptable_servo* servo,
                            enum haptable_sight sight) {
    if (sight == HAPTABLE_SIGHT_UNFINISHED) {
        if (servo->undecided_ticks < HAPTABLE_UNDECIDED_TICKS) ++servo->undecided_ticks;
        return 1;
    }
    servo->undecided_ticks = 0;
    if (sight == HAPTABLE_SIGHT_CLEAR) let_go(model, servo);
    return sight != HAPTABLE_SIGHT_BLOCKED;
}

/* Moves the god-object of one tick.
 *
 * In contact it slides on the surface towards the finger at x_m and lets go when the finger is outside; from there, or
 * from where the finger was when there was no contact, its segment is searched for the first patch that it crosses
 * inwards, where contact begins.
 *
 * before: contact->patch is HAPTABLE_NONE, or contact holds a point of the surface; positions are finite and within
 *         the workspace limit.
 * after:  contact->patch is HAPTABLE_NONE and the finger is outside as far as its segment was searched, or
 *         0 <= alpha <= 1, sum 1, god_object = sum alpha V, and no neighbouring patch is nearer to the finger (unless a
 *         limit was met: counted).
 * cost:   slides: at most MOST_STEPS steps, and after each slide the normals of the patches around a vertex; searches:
 *         at most MOST_BOXES boxes. host/target/modes.cpp has the instructions of each, in every mode, and tests hold
 *         every tick to them. */
void haptable_god_object_nearest(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    const enum haptable_sight earlier = haptable_contact_look_on(model, servo);
    int steps = 0;
    for (int slides = 0; slides < HAPTABLE_SLIDES; ++slides) {
        enum haptable_sight sight = HAPTABLE_SIGHT_UNFINISHED;
        if (contact->patch == HAPTABLE_NONE && !haptable_surface_enter(model, servo, x_m)) return;
        const int rests = slide_on(model, servo, x_m, contact, &steps);
        if (earlier != HAPTABLE_SIGHT_UNFINISHED) sight = haptable_surface_sight(model, servo, contact, x_m);
        if (!rests && sight != HAPTABLE_SIGHT_CLEAR) sight = HAPTABLE_SIGHT_UNFINISHED;
        if (haptable_contact_decide(model, servo, sight)) return;
        haptable_segment_entry(model, &servo->segment, contact);
        ++servo->counters.contacts;
    }
    ++servo->counters.slide_limits;
}

const struct haptable_contact* haptable_freed_contact(const struct haptable_model* model,
                                                      struct haptable_servo* servo) {
    if (!model->frictionless || servo->contact.patch == HAPTABLE_NONE) return 0;
    const struct haptable_freed* freed = haptable_freed_of(model, servo);
    return servo->counters.ticks - freed->tick == 1u && servo->counters.contacts == freed->contacts ? &freed->at : 0;
}
