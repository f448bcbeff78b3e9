/* SPDX-License-Identifier: MIT
 *
 * |f_t| <= mu f_n: Coulomb's friction by holding back the god-object
 */
#include "haptable_bounds.h"
#include "haptable_contact.h"
#include "haptable_surface.h"

/* 1 where the load at the contact lies within the cone of mu around the inward normal. *energy_j is what it stores. */
static int in_cone(const struct haptable_model* model, const struct haptable_contact* contact, const float x_m[3],
                   float mu, float* energy_j) {
    float nodal_n[3][3];
    float force_n[3];
    float normal[3];
    float u[3];
    float pressed;
    float along2;
    haptable_surface_outward(model, contact, normal);
    model->force(model, contact, x_m, nodal_n, force_n);
    vec_sub(x_m, contact->god_object_m, u);
    *energy_j = -0.5f * vec_dot(u, force_n);
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

/* Lets go where the held god-object sees the finger, though the frictionless one behind a thin part does not. */
static void look(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    if (servo->undecided_ticks != 0) return;
    (void)haptable_contact_decide(
        model, servo,
        haptable_surface_sight(model, &servo->contact, x_m, HAPTABLE_TICK_BOXES, &servo->segment, &servo->counters));
}

/* Moves servo->contact, the frictionless one, back to the least fraction of the line from the held one that brings the
 * load into the cone and, with least energy, stores no more than the held one does. */
static void slip(const struct haptable_model* model, struct haptable_servo* servo, const struct haptable_contact* held,
                 float held_j, const float x_m[3]) {
    const struct haptable_contact freed = servo->contact;
    float near = 0.0f;
    float far = 1.0f;
    int steps = 0;
    int i;
    for (i = 0; i < HALVINGS && steps < HELD_STEPS; ++i) {
        const float middle = 0.5f * (near + far);
        struct haptable_contact tried;
        float tried_j;
        steps += between(model, held, &freed, middle, &tried);
        if (in_cone(model, &tried, x_m, model->kinetic_friction, &tried_j) && !(model->energy && tried_j > held_j)) {
            far = middle;
            servo->contact = tried;
        } else {
            near = middle;
        }
    }
    servo->contact.slips = 1;
    if (steps >= HELD_STEPS) ++servo->counters.walk_limits;
    if ((uint32_t)steps > servo->counters.most_held_steps) servo->counters.most_held_steps = (uint32_t)steps;
}

/* before: model->frictionless is another god-object. after: as that one, but held back within the cone of friction.
 * cost: the frictionless one, MOST_FRICTION_FORCES forces, a look at the finger, and slides of at most MOST_HELD_STEPS
 *       steps; where they end at that limit, which is counted, the god-object slips farther than it would. */
void haptable_god_object_friction(const struct haptable_model* model, struct haptable_servo* servo,
                                  const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    const struct haptable_contact held = *contact;
    const uint32_t contacts = servo->counters.contacts;
    float held_j;
    model->frictionless(model, servo, x_m);
    contact->slips = 0;
    if (held.patch == HAPTABLE_NONE || contact->patch == HAPTABLE_NONE || servo->counters.contacts != contacts) return;
    vec_zero(servo->sensitivity_per_m[0]); /* is that of a god-object at rest */
    vec_zero(servo->sensitivity_per_m[1]);
    if (in_cone(model, &held, x_m, held.slips ? model->kinetic_friction : model->static_friction, &held_j)) {
        *contact = held;
        contact->slips = 0;
    } else {
        slip(model, servo, &held, held_j, x_m);
    }
    look(model, servo, x_m);
}
