/* SPDX-License-Identifier: MIT
 *
 * The laws of a compliance at one of two places, whose blocks HAPTABLE_GATHER gathers: haptable_pair_compliance.c has
 * them in float32, haptable_pair_compliance_packed.c in 16 bits. before: HAPTABLE_STORED(name) names a function of this
 * storage; HAPTABLE_IS_PACKED is 1 where blocks stand on the stack, which the point outlives.
 */

/* The net of degree 2 of the point: that of the patch, or at alpha of its net of degree 4. */
static inline void open_net(const struct net* net, int degree, const float alpha[3], struct reduced* quadratic) {
    if (degree == 4) {
        int corner = 0;
        const enum place_on_patch feature = feature_of(alpha, &corner);
        quadratic_net(net, alpha, feature, corner, quadratic);
    } else {
        for (int n = 0; n < 6; ++n) quadratic->block[n] = net->block[n];
    }
}

/* The rest of a place by its net of degree 1, lifted where fixed vertices ask for it. A is not linear's sum for the
 * lift alone. before: point->net. */
static inline void open_place(const struct haptable_model* model, int degree, const struct haptable_contact* contact,
                              const float finger_m[3], struct haptable_pair_point* point) {
    const float fraction = fixed_fraction(model, contact);
    linear_of(point->net.block, contact->alpha, point->linear);
    mix_three(contact->alpha, point->linear[0], point->linear[1], point->linear[2], point->own.a);
    point->lifted = point->steps = 0;
    if (fraction > 0.0f) {
        point->steps = (uint8_t)is_at_lift(model, contact->patch, fraction, degree, point->linear, point->own.a);
        point->lifted = (uint8_t)lift(model, fraction, point->own.a);
    }
    edges_of(model, contact->patch, point->e);
    vec_sub(finger_m, contact->god_object_m, point->u);
    vec_copy(point->u, point->own.s);
}

/* C at once: half the work of the net. */
static inline void own_place(const struct haptable_model* model, const struct net* net, int degree,
                             const struct haptable_contact* contact, const float finger_m[3],
                             struct haptable_pair_own* own) {
    if (degree == 4)
        quartic_c(net, contact->alpha, own->a);
    else
        quadratic_c(net, contact->alpha, own->a);
    lift(model, fixed_fraction(model, contact), own->a);
    vec_sub(finger_m, contact->god_object_m, own->s);
}

static inline void open_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                           const struct haptable_contact* contact, const float finger_m[3],
                           struct haptable_pair_point* point) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    const int kept = HAPTABLE_IS_PACKED ? 6 : 0; /* blocks in `room`, which ends here */
    HAPTABLE_GATHER(model, form, contact->patch, room, &net);
    open_net(&net, form->degree, contact->alpha, &point->net);
    for (int n = 0; n < kept; ++n) {
        const float* block = point->net.block[n];
        if (block == point->net.room[n]) continue;
        for (int i = 0; i < 6; ++i) point->net.room[n][i] = block[i];
        point->net.block[n] = point->net.room[n];
    }
    open_place(model, form->degree, contact, finger_m, point);
}

static inline void own_of(const struct haptable_model* model, const struct haptable_compliance_form* form,
                          const struct haptable_contact* contact, const float finger_m[3],
                          struct haptable_pair_own* own) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    HAPTABLE_GATHER(model, form, contact->patch, room, &net);
    own_place(model, &net, form->degree, contact, finger_m, own);
}

void HAPTABLE_STORED(haptable_pair_open_consistent)(const struct haptable_model* model,
                                                    const struct haptable_contact* contact, const float finger_m[3],
                                                    struct haptable_pair_point* point) {
    open_of(model, &consistent_form, contact, finger_m, point);
}

void HAPTABLE_STORED(haptable_pair_open_pressure_mask)(const struct haptable_model* model,
                                                       const struct haptable_contact* contact, const float finger_m[3],
                                                       struct haptable_pair_point* point) {
    open_of(model, &mask_form, contact, finger_m, point);
}

void HAPTABLE_STORED(haptable_pair_own_consistent)(const struct haptable_model* model,
                                                   const struct haptable_contact* contact, const float finger_m[3],
                                                   struct haptable_pair_own* own) {
    own_of(model, &consistent_form, contact, finger_m, own);
}

void HAPTABLE_STORED(haptable_pair_own_pressure_mask)(const struct haptable_model* model,
                                                      const struct haptable_contact* contact, const float finger_m[3],
                                                      struct haptable_pair_own* own) {
    own_of(model, &mask_form, contact, finger_m, own);
}

const struct haptable_pair_bend HAPTABLE_STORED(haptable_pair_bend_consistent) = {
    HAPTABLE_STORED(haptable_pair_open_consistent), haptable_pair_slope_consistent};
const struct haptable_pair_bend HAPTABLE_STORED(haptable_pair_bend_pressure_mask) = {
    HAPTABLE_STORED(haptable_pair_open_pressure_mask), haptable_pair_slope_mask};
const struct haptable_pair_law HAPTABLE_STORED(haptable_pair_consistent) = {
    3, 0, HAPTABLE_STORED(haptable_pair_own_consistent), haptable_pair_load_of_compliance, 0};
const struct haptable_pair_law HAPTABLE_STORED(haptable_pair_pressure_mask) = {
    HAPTABLE_PAIR_CONTROLS, 0, HAPTABLE_STORED(haptable_pair_own_pressure_mask), haptable_pair_load_of_compliance, 0};

#undef HAPTABLE_STORED
#undef HAPTABLE_GATHER
#undef HAPTABLE_IS_PACKED
