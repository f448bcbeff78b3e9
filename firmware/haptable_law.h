/* SPDX-License-Identifier: MIT
 *
 * A v = s, load f of v: a force law at one of two contacts, uncoupled from the other
 */
#ifndef HAPTABLE_LAW_H
#define HAPTABLE_LAW_H

#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Maximum number of controls of a patch: its 3 vertices and, under a mask, its 3 edges. */
#define HAPTABLE_PAIR_CONTROLS 6

/* Terms of one contact, uncoupled: A v = s with the load f. Consistent force and mask: A = C, s = u, f = v.
 * Interpolated force: A = S, s = S u, f = S v, and two contacts are coupled by S_a L_ab S_b. */
struct haptable_pair_own {
    float a[6];
    float s[3];
};

/* Control blocks of a polynomial of lower degree: in another net, or in `room`. */
struct reduced {
    const float* block[6];
    float room[6][6];
};

/* A contact with what its derivatives are computed from. */
struct haptable_pair_point {
    struct haptable_pair_own own;
    float u[3];
    float e[2][3];      /* the patch's edges from corner 0 */
    struct reduced net; /* of a compliance, that of degree 2; the three S_a of a stiffness */
    float linear[3][6]; /* of a compliance, the net of degree 1 */
    uint8_t lifted;     /* 1: A's diagonal is lifted, as fixed vertices ask for it */
    uint8_t steps;      /* 1: the lift may begin or end here, where the load's derivative is discontinuous */
};

/* Derivatives of one contact's terms by alpha_1 and alpha_2 at fixed v. */
struct haptable_pair_slope {
    float y[2][3];     /* s_b - A_b v */
    float first_j[2];  /* s_b . v - 1/2 v . A_b v */
    float second_j[3]; /* s_bc . v - 1/2 v . A_bc v: 11 12 22; where is_whole */
    float a_v[2][3];   /* A_b v */
};

typedef void haptable_pair_own_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], struct haptable_pair_own* own);
typedef void haptable_pair_load_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float v[3], float nodal_force_n[3][3], float force_n[3]);
typedef void haptable_pair_open_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float finger_m[3], struct haptable_pair_point* point);
/* What a finger's model names instead where dents stiffen. */
typedef void haptable_pair_see_fn(struct haptable_model* view);

/* v to the u that stores as much, by the contact's own A; in place. */
typedef void haptable_pair_straighten_fn(const struct haptable_model* model, const float a[6], float v[3]);

/* Of two fingers on a body whose dents stiffen. */
struct haptable_pair_stiffening {
    haptable_pair_see_fn* see;
    haptable_pair_straighten_fn* straighten;
};

typedef void haptable_pair_slope_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                    struct haptable_pair_point* point, const float v[3], int is_whole,
                                    struct haptable_pair_slope* slope);

/* A force law of two fingers. */
struct haptable_pair_law {
    uint8_t controls;     /* of a patch: 3, or 6 */
    uint8_t is_stiffness; /* 1: A is a stiffness */
    haptable_pair_own_fn* own;
    haptable_pair_load_fn* load;
    const struct haptable_pair_stiffening* stiffening; /* NULL: dents are linear */
};

/* What god_object_least_energy needs besides: a contact's terms, then their derivatives. */
struct haptable_pair_bend {
    haptable_pair_open_fn* open;
    haptable_pair_slope_fn* slope;
};

#define HAPTABLE_PAIR_LAW(name)                                            \
    extern const struct haptable_pair_law haptable_pair_##name;            \
    extern const struct haptable_pair_bend haptable_pair_bend_##name;      \
    extern const struct haptable_pair_law haptable_pair_stiffening_##name; \
    extern const struct haptable_pair_bend haptable_pair_bend_stiffening_##name;
HAPTABLE_PAIR_LAWS(HAPTABLE_PAIR_LAW)
#undef HAPTABLE_PAIR_LAW

/* Functions of all compliance laws, with float32 and with packed blocks. */
haptable_pair_slope_fn haptable_pair_slope_consistent;
haptable_pair_slope_fn haptable_pair_slope_mask;
haptable_pair_load_fn haptable_pair_load_of_compliance;

#ifdef __cplusplus
}
#endif

#endif
