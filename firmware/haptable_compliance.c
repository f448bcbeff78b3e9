/* SPDX-License-Identifier: MIT
 *
 * C(alpha) and E(alpha) with blocks in float32, where they stand in flash.
 */
#include "haptable_net.h"

void haptable_compliance_solve(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float c[6], float load_n[3]) {
    float u[3];
    lift(model, fixed_fraction(model, contact), c);
    vec_sub(finger_m, contact->god_object_m, u);
    solve_once(c, u, load_n);
}

void haptable_compliance_load(const struct haptable_model* model, const struct haptable_compliance_form* form,
                              const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    struct net net;
    gather(model, form, contact->patch, &net);
    load_of(model, &net, form->degree, contact, finger_m, load_n);
}

void haptable_compliance_distribute(const float load_n[3], const struct haptable_contact* contact,
                                    float nodal_force_n[3][3], float force_n[3]) {
    int corner;
    vec_zero(force_n);
    vec_add_scaled(-1.0f, load_n, force_n);
    for (corner = 0; corner < 3; ++corner) {
        vec_zero(nodal_force_n[corner]);
        vec_add_scaled(contact->alpha[corner], load_n, nodal_force_n[corner]);
    }
}

void haptable_force_of_least_energy(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    (void)model;
    (void)finger_m;
    haptable_compliance_distribute(contact->load_n, contact, nodal_force_n, force_n);
}

void haptable_compliance_energy(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                const struct haptable_contact* contact, const float finger_m[3],
                                enum haptable_energy_terms terms, struct haptable_energy* energy) {
    struct net net;
    gather(model, form, contact->patch, &net);
    energy_of(model, &net, form->degree, contact, finger_m, terms, energy);
}
