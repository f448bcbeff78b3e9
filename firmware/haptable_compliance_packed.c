/* SPDX-License-Identifier: MIT
 *
 * C(alpha) and E(alpha) with blocks in 16 bits, expanded on the stack.
 */
#include "haptable_net.h"

void haptable_compliance_load_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    gather_packed(model, form, contact->patch, room, &net);
    load_of(model, &net, form->degree, contact, finger_m, load_n);
}

void haptable_compliance_energy_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                       const struct haptable_contact* contact, const float finger_m[3],
                                       enum haptable_energy_terms terms, struct haptable_energy* energy) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    gather_packed(model, form, contact->patch, room, &net);
    energy_of(model, &net, form->degree, contact, finger_m, terms, energy);
}
