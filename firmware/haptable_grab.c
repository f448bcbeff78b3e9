/* SPDX-License-Identifier: MIT
 *
 * g stays: F = -S(g) (x - g), wherever the finger goes
 */
#include "haptable_model.h"
#include "haptable_vector.h"

/* What a god-object knows of the last tick's finger is not true of one that was held. */
static void forget(struct haptable_servo* servo) {
    servo->undecided_ticks = 0;
    servo->slide_patch = HAPTABLE_NONE;
    servo->segment.unfinished = 0;
    servo->contact.slips = 0;
}

/* before: model->ungrabbed is another god-object. cost: that one's, or an energy. */
void haptable_god_object_grab(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3]) {
    struct haptable_contact* contact = &servo->contact;
    if ((servo->buttons & HAPTABLE_BUTTON_GRAB) == 0 || contact->patch == HAPTABLE_NONE) {
        model->ungrabbed(model, servo, x_m);
        return;
    }
    ++servo->counters.grabbed_ticks;
    forget(servo);
    if (model->energy) { /* whose load may be the force */
        struct haptable_energy energy;
        model->energy(model, contact, x_m, HAPTABLE_ENERGY_ALL, &energy);
        vec_copy(energy.load_n, contact->load_n);
        vec_zero(servo->sensitivity_per_m[0]);
        vec_zero(servo->sensitivity_per_m[1]);
    }
}
