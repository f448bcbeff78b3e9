/* SPDX-License-Identifier: MIT
 *
 * |f_t| <= mu f_n: Coulomb's friction by holding back the god-object
 */
#include "haptable_contact.h"
#include "haptable_surface.h"

/* How often the line from stick to slip is halved: to a 256th of the tick's slide. */
#define HALVINGS 8

/* The most steps of the walk that they take together, not counting the last one's. Most take a patch or two. */
#define HELD_STEPS (2 * HAPTABLE_WALK_STEPS)

/* 1 where the load at the contact lies within the cone of mu around the inward normal. */
static int in_cone(const struct haptable_model* model, const struct haptable_contact* contact, const float x_m[3],
                   float mu) {
    float nodal_n[3][3];
    float force_n[3];
    float normal[3];
    float pressed;
    float along2;
    haptable_surface_outward(model, contact, normal);
    model->force(model, contact, x_m, nodal_n, force_n);
    pressed = vec_dot(normal, force_n); /* times |normal| */
    along2 = vec_dot(force_n, force_n) * vec_dot(normal, normal) - pressed * pressed;
    return pressed > 0.0f && along2 <= mu * mu * pressed * pressed;
}

/* The surface's point nearest to a point of the straight line, at a fraction of it, from the held contact to the
 * frictionless one. Returns the steps that it took. */
static int between(const struct haptable_model* model, const struct haptable_contact* held,
                   const struct haptable_contact* freed, float fraction, struct haptable_contact* contact) {
    float along[3];
    float aim[3];
    int steps = 0;
    vec_sub(freed->god_object_m, held->god_object_m, along);
    vec_copy(held->god_object_m, aim);
    vec_add_scaled(fraction, along, aim);
    *contact = *held;
    haptable_contact_slide(model, aim, contact, &steps);
    return steps;
}

/* before: model->frictionless is another god-object. after: as that one, but held back within the cone of friction.
 * cost: the frictionless one, HALVINGS + 1 forces, and slides of at most HELD_STEPS + HAPTABLE_WALK_STEPS + 13 steps;
 *       where they end at that limit, which is counted, the god-object slips farther than it would. */
void haptable_god_object_friction(const struct haptable_model* model, struct haptable_servo* servo,
                                  const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    struct haptable_counters* counters = &servo->counters;
    const struct haptable_contact held = *contact;
    const uint32_t contacts = counters->contacts;
    struct haptable_contact freed;
    float near = 0.0f;
    float far = 1.0f;
    int steps = 0;
    int i;
    model->frictionless(model, servo, x_m);
    contact->slips = 0;
    if (held.patch == HAPTABLE_NONE || contact->patch == HAPTABLE_NONE || counters->contacts != contacts) return;
    freed = *contact;
    vec_zero(servo->sensitivity_per_m[0]); /* is that of a god-object at rest */
    vec_zero(servo->sensitivity_per_m[1]);
    if (in_cone(model, &held, x_m, held.slips ? model->kinetic_friction : model->static_friction)) {
        *contact = held;
        contact->slips = 0;
        return;
    }
    for (i = 0; i < HALVINGS && steps < HELD_STEPS;
         ++i) { /* the least fraction of the line that brings the load into the cone */
        const float middle = 0.5f * (near + far);
        struct haptable_contact tried;
        steps += between(model, &held, &freed, middle, &tried);
        if (in_cone(model, &tried, x_m, model->kinetic_friction)) {
            far = middle;
            *contact = tried;
        } else {
            near = middle;
        }
    }
    contact->slips = 1;
    if (steps >= HELD_STEPS) ++counters->walk_limits;
    if ((uint32_t)steps > counters->most_held_steps) counters->most_held_steps = (uint32_t)steps;
}
