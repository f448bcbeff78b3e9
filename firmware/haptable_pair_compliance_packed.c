/* SPDX-License-Identifier: MIT
 *
 * haptable_pair_compliance.c with blocks in 16 bits, expanded on the stack
 */
#include "haptable_pair_compliance.h"

static inline void open_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                           const struct haptable_contact* contact, const float finger_m[3],
                           struct haptable_pair_point* point) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    int n;
    int i;
    gather_packed(model, form, contact->patch, room, &net);
    open_net(&net, form->degree, contact->alpha, &point->net);
    for (n = 0; n < 6; ++n) { /* the point outlives the room */
        const float* block = point->net.block[n];
        if (block == point->net.room[n]) continue;
        for (i = 0; i < 6; ++i) point->net.room[n][i] = block[i];
        point->net.block[n] = point->net.room[n];
    }
    open_place(model, form->degree, contact, finger_m, point);
}

static inline void own_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                          const struct haptable_contact* contact, const float finger_m[3],
                          struct haptable_pair_own* own) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    gather_packed(model, form, contact->patch, room, &net);
    own_place(model, &net, form->degree, contact, finger_m, own);
}

static void open_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                            const float finger_m[3], struct haptable_pair_point* point) {
    open_of(model, &consistent_form, contact, finger_m, point);
}

static void open_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                      const float finger_m[3], struct haptable_pair_point* point) {
    open_of(model, &mask_form, contact, finger_m, point);
}

const struct haptable_pair_bend haptable_pair_bend_consistent_packed = {open_consistent,
                                                                        haptable_pair_slope_consistent};
const struct haptable_pair_bend haptable_pair_bend_pressure_mask_packed = {open_mask, haptable_pair_slope_mask};

static void own_consistent(const struct haptable_model* model, const struct haptable_contact* contact,
                           const float finger_m[3], struct haptable_pair_own* own) {
    own_of(model, &consistent_form, contact, finger_m, own);
}

static void own_mask(const struct haptable_model* model, const struct haptable_contact* contact,
                     const float finger_m[3], struct haptable_pair_own* own) {
    own_of(model, &mask_form, contact, finger_m, own);
}

const struct haptable_pair_law haptable_pair_consistent_packed = {3, 0, own_consistent,
                                                                  haptable_pair_load_of_compliance};
const struct haptable_pair_law haptable_pair_pressure_mask_packed = {HAPTABLE_PAIR_CONTROLS, 0, own_mask,
                                                                     haptable_pair_load_of_compliance};
