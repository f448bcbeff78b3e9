/* SPDX-License-Identifier: MIT
 *
 * |f_t| <= mu f_n: Coulomb's friction by holding back the god-object
 */
#include "haptable_bounds.h"
#include "haptable_contact.h"
#include "haptable_matrix.h"
#include "haptable_patch.h"
#include "haptable_side.h"
#include "haptable_surface.h"

/* What the load at a contact is to the inward normal there. */
struct load {
    float
        pressed2; /* its part along the normal, squared, times a square of the normal's length; 0: it does not press */
    float along2; /* the part along the surface, squared, times the same */
    float energy_j; /* what it stores */
    float normal[3];
    float at_m[3]; /* where that is the normal */
};

/* The normal at a contact, see haptable_side_outward; most contacts are within a patch, and many of a slip's that
 * are not are where the held one is. */
static void outward_at(const struct haptable_model* model, const struct haptable_contact* contact,
                       const struct load* held, float normal[3]) {
    const float* alpha = contact->alpha;
    float edge1[3], edge2[3];
    if (alpha[0] == 0.0f || alpha[1] == 0.0f || alpha[2] == 0.0f) {
        if (held && gap2(held->at_m, contact->god_object_m) == 0.0f)
            vec_copy(held->normal, normal);
        else
            haptable_side_outward(model, contact, normal);
        return;
    }
    patch_frame(model, contact->patch, edge1, edge2, normal);
    vec_scale(1.0f / (model->tolerance_m * model->tolerance_m), normal);
}

/* before: contact->load_n is its load. held: where the contact is held, NULL for that one. */
static void split(const struct haptable_model* model, const struct haptable_contact* contact, const float x_m[3],
                  const struct load* held, struct load* load) {
    const float* load_n = contact->load_n;
    float u[3];
    outward_at(model, contact, held, load->normal);
    vec_copy(contact->god_object_m, load->at_m);
    vec_sub(x_m, contact->god_object_m, u);
    const float pressed = -vec_dot(load->normal, load_n);
    load->energy_j = 0.5f * vec_dot(u, load_n);
    load->along2 = vec_length2(load_n) * vec_length2(load->normal) - pressed * pressed;
    load->pressed2 = pressed > 0.0f ? pressed * pressed : 0.0f;
}

/* after: contact->load_n is its load. */
static void take_load_of_force(const struct haptable_model* model, struct haptable_contact* contact,
                               const float x_m[3]) {
    float nodal_n[3][3], force_n[3];
    model->force(model, contact, x_m, nodal_n, force_n);
    vec_zero(contact->load_n);
    vec_add_scaled(-1.0f, force_n, contact->load_n);
}

/* Where the force of a tick is made of the load, that is taken with the energy, and C is known. */
static int has_compliance(const struct haptable_model* model) { return model->force == haptable_force_of_least_energy; }

/* The same. after: c is C there, where it has one. */
static void take_load(const struct haptable_model* model, struct haptable_contact* contact, const float x_m[3],
                      float c[6]) {
    if (has_compliance(model)) {
        struct haptable_energy energy;
        model->energy(model, contact, x_m, HAPTABLE_ENERGY_LOAD, &energy);
        vec_copy(energy.load_n, contact->load_n);
        sym_copy(energy.compliance_m_per_n, c);
    } else {
        take_load_of_force(model, contact, x_m);
    }
}

/* The same for the contact as the last tick left it. */
static void take_held_load(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3],
                           struct haptable_freed* freed) {
    struct haptable_contact* contact = &servo->contact;
    if (has_compliance(model) && freed->has_compliance && haptable_freed_contact(model, servo)) {
        float u[3];
        vec_sub(x_m, contact->god_object_m, u);
        sym_solve_once(freed->compliance_m_per_n, u, contact->load_n);
    } else {
        take_load(model, contact, x_m, freed->compliance_m_per_n);
    }
}

/* 1 where the load is within the cone of mu. */
static int in_cone(const struct load* load, float mu) {
    return load->pressed2 > 0.0f && load->along2 <= mu * mu * load->pressed2;
}

/* |f_t|^2 / f_n^2; 0 where that is no number. */
static float tangent2_of(const struct load* load) {
    const float tangent2 = load->pressed2 > 0.0f ? load->along2 / load->pressed2 : 0.0f;
    return tangent2 > 0.0f && tangent2 < HAPTABLE_ROOT_MOST ? tangent2 : 0.0f;
}

/* From where the god-object is held to where it would be without friction. */
struct slip_path {
    const struct haptable_contact* held;
    const struct haptable_contact* freed;
    uint16_t patch; /* one that has both, and so all between them; HAPTABLE_NONE: there is none, or it is not known */
    float from[3];  /* area coordinates on it of the one, and of the other */
    float to[3];
};

/* The area coordinates of a point on a patch; 0 where the patch does not have it. */
static int seen_from(const struct haptable_model* model, const struct haptable_contact* point, uint16_t patch,
                     float alpha[3]) {
    const uint16_t* v = model->patch[point->patch];
    if (patch == point->patch) {
        vec_copy(point->alpha, alpha);
        return 1;
    }
    vec_zero(alpha);
    for (int corner = 0; corner < 3; ++corner) {
        const int there = corner_of(model, patch, v[corner]);
        if (point->alpha[corner] == 0.0f) continue;
        if (model->patch[patch][there] != v[corner]) return 0;
        alpha[there] = point->alpha[corner];
    }
    return 1;
}

static void find_path(const struct haptable_model* model, const struct haptable_contact* held,
                      const struct haptable_contact* freed, struct slip_path* path) {
    path->held = held;
    path->freed = freed;
    path->patch = HAPTABLE_NONE;
    if (seen_from(model, held, freed->patch, path->from))
        path->patch = freed->patch;
    else if (seen_from(model, freed, held->patch, path->from))
        path->patch = held->patch;
    if (path->patch == HAPTABLE_NONE) return;
    (void)seen_from(model, held, path->patch, path->from);
    (void)seen_from(model, freed, path->patch, path->to);
}

/* The surface's point nearest to a point of the straight line, at a fraction of it. Returns the steps that it took:
 * none on a patch that has the line. */
static int between(const struct haptable_model* model, const struct slip_path* path, float fraction,
                   struct haptable_contact* contact) {
    int steps = 0;
    *contact = *path->held;
    if (path->patch != HAPTABLE_NONE) {
        contact->patch = path->patch;
        for (int corner = 0; corner < 3; ++corner)
            contact->alpha[corner] =
                vec_clamp01(path->from[corner] + fraction * (path->to[corner] - path->from[corner]));
        haptable_patch_complete(contact->alpha);
        place(model, contact);
    } else {
        const float* held_m = path->held->god_object_m;
        float along[3], aim[3];
        vec_sub(path->freed->god_object_m, held_m, along);
        vec_copy(held_m, aim);
        vec_add_scaled(fraction, along, aim);
        haptable_contact_slide(model, aim, contact, &steps);
    }
    return steps;
}

/* Lets go where the held god-object sees the finger, though the frictionless one behind a thin part does not. */
static void look(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    if (servo->undecided_ticks != 0) return;
    (void)haptable_contact_decide(model, servo, haptable_surface_sight(model, servo, &servo->contact, x_m));
}

/* What is known of the line from where the god-object is held to where it would be without friction. */
struct line {
    float near; /* fraction, where it would not slip any more */
    float far;  /* fraction, where it may come to rest */
    float near_tangent2;
    float far_tangent2;
};

/* So near to the cone, as a part of mu, the load is to be once the god-object slips. */
#define CONE_REACHED 0x1p-8f

static float goal2_of(float mu) { return (1.0f - CONE_REACHED) * mu * mu; }

/* The fraction where the load is foreseen to be barely within the cone: near to it its tangent is nearly linear in
 * that, and so is the tangent's square, which takes no root. Midway where the near end is within the cone, and stores
 * too much, or the far end is out of it too. */
static float foreseen(const struct line* line, float mu) {
    const float goal2 = goal2_of(mu);
    const int is_between = line->near_tangent2 > goal2 && line->far_tangent2 < goal2;
    const float part = is_between ? (line->near_tangent2 - goal2) / (line->near_tangent2 - line->far_tangent2) : 0.5f;
    return line->near + part * (line->far - line->near);
}

/* A far end that has stood before counts for half as much next time, so that the try is nearer to it (the Illinois
 * method). */
static void note_near(float fraction, float tangent2, float mu, int has_stood, struct line* line) {
    line->near = fraction;
    line->near_tangent2 = tangent2;
    if (has_stood) line->far_tangent2 = 0.5f * (line->far_tangent2 + goal2_of(mu));
}

/* 1 where the god-object may come to rest: in the cone and, with least energy, where it stores no more than held. */
static int may_rest(const struct haptable_model* model, const struct load* load, const struct load* held) {
    return in_cone(load, model->kinetic_friction) && !(model->energy && load->energy_j > held->energy_j);
}

/* 1 where the god-object may come to rest where it would be without friction; the tangent there is known then. */
static int may_rest_freed(const struct haptable_model* model, struct haptable_contact* freed,
                          const struct load* held_load, const float x_m[3], struct line* line) {
    struct load load;
    if (!model->energy) take_load_of_force(model, freed, x_m);
    split(model, freed, x_m, held_load, &load);
    line->far_tangent2 = tangent2_of(&load);
    return may_rest(model, &load, held_load);
}

/* Ends of a slip that are nearer to one another, as a part of the line, foresee nothing. */
#define LEAST_GONE 0x1p-10f

/* What the next tick may foresee of the far end's tangent: that of a line through the last slip's ends. Where they are
 * so near to one another that rounding says more, what was foreseen already. */
static void foresee(const struct line* line, float mu, float* freed_tangent2) {
    const float fallen = line->near_tangent2 - line->far_tangent2;
    const float gone = line->far - line->near;
    if (fallen > 0.5f * CONE_REACHED * mu * mu && gone > LEAST_GONE)
        *freed_tangent2 = line->far_tangent2 - fallen * (1.0f - line->far) / gone;
}

/* Moves servo->contact, the frictionless one, back to the least fraction of the line from the held one where it may
 * rest, with a load as near to the cone as CONE_REACHED. Where it may neither rest there nor midway, it stays. The
 * frictionless one's own load is taken where the tangent that was foreseen for it does not do. */
static void slip(const struct haptable_model* model, struct haptable_servo* servo, const struct haptable_contact* held,
                 const struct load* held_load, const float x_m[3]) {
    const float mu = model->kinetic_friction;
    struct haptable_freed* freed = haptable_freed_of(model, servo);
    struct line line = {0.0f, 1.0f, tangent2_of(held_load), freed->tangent};
    struct slip_path path;
    int is_asked = 0;
    int rests = 1;
    int steps = 0;
    if (!(line.far_tangent2 < goal2_of(mu))) {
        rests = may_rest_freed(model, &freed->at, held_load, x_m, &line);
        is_asked = 1;
    }
    find_path(model, held, &freed->at, &path);
    for (int tries = 0; tries < SLIP_TRIES && steps < HELD_STEPS; ++tries) {
        const float fraction = foreseen(&line, mu);
        struct haptable_contact tried;
        struct load load;
        float c[6] = {0.0f};
        steps += between(model, &path, fraction, &tried);
        take_load(model, &tried, x_m, c);
        split(model, &tried, x_m, held_load, &load);
        if (may_rest(model, &load, held_load)) {
            is_asked = 1;
            servo->contact = tried;
            freed->has_compliance = (uint8_t)has_compliance(model);
            if (freed->has_compliance) sym_copy(c, freed->compliance_m_per_n);
            line.far = fraction;
            line.far_tangent2 = tangent2_of(&load);
            if (line.far_tangent2 >= (1.0f - 2.0f * CONE_REACHED) * mu * mu) break;
        } else {
            if (!is_asked) rests = may_rest_freed(model, &freed->at, held_load, x_m, &line);
            if (!rests) break;
            note_near(fraction, in_cone(&load, mu) ? 0.0f : tangent2_of(&load), mu, is_asked, &line);
            is_asked = 1;
        }
    }
    servo->contact.slips = 1;
    foresee(&line, mu, &freed->tangent);
    if (steps >= HELD_STEPS) ++servo->counters.walk_limits;
    if ((uint32_t)steps > servo->counters.most_held_steps) servo->counters.most_held_steps = (uint32_t)steps;
}

/* Where the frictionless god-object is, for the next tick. */
static void remember(const struct haptable_servo* servo, struct haptable_freed* freed) {
    freed->tick = servo->counters.ticks;
    freed->contacts = servo->counters.contacts;
    freed->at = servo->contact;
}

/* The frictionless god-object goes on from where it was. One of least energy may have to begin at the held one again,
 * so that friction never stores more: it finds that in servo->contact, with its load. */
static void free_contact(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    const struct haptable_contact* freed = haptable_freed_contact(model, servo);
    const int is_known = freed != 0;
    if (is_known && !model->energy) servo->contact = *freed;
    if (!is_known && model->energy) {
        vec_zero(servo->sensitivity_per_m[0]);
        vec_zero(servo->sensitivity_per_m[1]);
    }
    model->frictionless(model, servo, x_m);
    remember(servo, haptable_freed_of(model, servo));
}

/* before: model->frictionless is another god-object, and the state has room at model->freed_at. after: as that one, but
 * held back within the cone of friction. cost: the frictionless one, MOST_FRICTION_FORCES forces, a look at the finger,
 * and slides of at most MOST_HELD_STEPS steps; where they end at that limit, which is counted, the god-object slips
 * farther than it would. */
void haptable_god_object_friction(const struct haptable_model* model, struct haptable_servo* servo,
                                  const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    struct haptable_freed* freed = haptable_freed_of(model, servo);
    const uint32_t contacts = servo->counters.contacts;
    struct load held_load;
    if (contact->patch == HAPTABLE_NONE) {
        free_contact(model, servo, x_m);
        contact->slips = 0;
        freed->tangent = 0.0f;
        freed->has_compliance = 0;
        return;
    }
    take_held_load(model, servo, x_m, freed);
    const struct haptable_contact held = *contact;
    free_contact(model, servo, x_m);
    contact->slips = 0;
    freed->has_compliance = 0;
    if (contact->patch == HAPTABLE_NONE || servo->counters.contacts != contacts) return;
    if (gap2(contact->god_object_m, held.god_object_m) == 0.0f) return; /* often at a vertex: nothing is held back */
    split(model, &held, x_m, 0, &held_load);
    if (in_cone(&held_load, held.slips ? model->kinetic_friction : model->static_friction)) {
        *contact = held;
        contact->slips = 0;
        freed->has_compliance = (uint8_t)has_compliance(model);
    } else {
        slip(model, servo, &held, &held_load, x_m);
    }
    look(model, servo, x_m);
}
