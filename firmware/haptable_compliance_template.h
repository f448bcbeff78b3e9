/* SPDX-License-Identifier: MIT
 *
 * The laws of a compliance, whose blocks HAPTABLE_GATHER gathers: haptable_compliance.c has them in float32,
 * haptable_compliance_packed.c in 16 bits. before: HAPTABLE_STORED(name) names a function of this storage.
 */

static void HAPTABLE_STORED(force_of)(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                      const struct haptable_contact* contact, const float finger_m[3],
                                      float nodal_force_n[3][3], float force_n[3]) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    float load_n[3], c[6];
    HAPTABLE_GATHER(model, form, contact->patch, room, &net);
    load_of(model, &net, form->degree, contact, finger_m, c, load_n);
    haptable_compliance_distribute(load_n, contact, nodal_force_n, force_n);
}

/* E = 1/2 u^T C^-1 u and its derivatives; or its gradient alone, with the load that is in `energy`. Where the lift may
 * begin or end within HAPTABLE_CORRECTION, the load's derivative, which steps there, is no number.
 * cost: the blocks three times each and three solves with C; the blocks twice each. Packed, every block is expanded
 * once besides. */
static void HAPTABLE_STORED(put_energy)(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                        const struct haptable_contact* contact, const float finger_m[3],
                                        enum haptable_energy_terms terms, struct haptable_energy* energy) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    HAPTABLE_GATHER(model, form, contact->patch, room, &net);
    energy_of(model, &net, form->degree, contact, finger_m, terms, energy);
}

void HAPTABLE_STORED(haptable_force_pressure_mask)(const struct haptable_model* model,
                                                   const struct haptable_contact* contact, const float finger_m[3],
                                                   float nodal_force_n[3][3], float force_n[3]) {
    HAPTABLE_STORED(force_of)(model, &mask_form, contact, finger_m, nodal_force_n, force_n);
}

void HAPTABLE_STORED(haptable_energy_pressure_mask)(const struct haptable_model* model,
                                                    const struct haptable_contact* contact, const float finger_m[3],
                                                    enum haptable_energy_terms terms, struct haptable_energy* energy) {
    HAPTABLE_STORED(put_energy)(model, &mask_form, contact, finger_m, terms, energy);
}

void HAPTABLE_STORED(haptable_energy_consistent)(const struct haptable_model* model,
                                                 const struct haptable_contact* contact, const float finger_m[3],
                                                 enum haptable_energy_terms terms, struct haptable_energy* energy) {
    HAPTABLE_STORED(put_energy)(model, &consistent_form, contact, finger_m, terms, energy);
}

#undef HAPTABLE_STORED
#undef HAPTABLE_GATHER
