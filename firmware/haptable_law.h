/* SPDX-License-Identifier: MIT
 *
 * A v = s, load f of v: a force law at one of two places, without the other
 */
#ifndef HAPTABLE_LAW_H
#define HAPTABLE_LAW_H

#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The most controls of a patch: its vertices and, under a mask, its edges. */
#define HAPTABLE_PAIR_CONTROLS 6

/* A place of its own, without the other: A v = s, load f of v. Of the consistent and the mask's force A = C, s = u,
 * f = v; of the interpolated one A = S, s = S u, f = S v, so that what couples is S_a L_ab S_b. */
struct haptable_pair_own {
    float a[6];
    float s[3];
};

/* Where a net of less degree has its blocks: in another net, or in `room`. */
struct reduced {
    const float* block[6];
    float room[6][6];
};

/* A finger's place with what its slope is made of. */
struct haptable_pair_point {
    struct haptable_pair_own own;
    float u[3];
    float e[2][3];      /* the patch's edges from corner 0 */
    struct reduced net; /* of a compliance, that of degree 2; the three S_a of a stiffness */
    float linear[3][6]; /* of a compliance, the net of degree 1 */
    uint8_t lifted;     /* 1: A's diagonal is lifted, as fixed vertices ask for it */
    uint8_t steps;      /* 1: the lift may begin or end here, and with it the load's slope steps */
};

/* How a place of its own changes with alpha_1, alpha_2, v being given. */
struct haptable_pair_slope {
    float y[2][3];     /* s_b - A_b v */
    float first_j[2];  /* s_b . v - 1/2 v . A_b v */
    float second_j[3]; /* s_bc . v - 1/2 v . A_bc v: 11 12 22 */
    float a_v[2][3];   /* A_b v */
};

typedef void haptable_pair_own_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], struct haptable_pair_own* own);
typedef void haptable_pair_load_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float v[3], float nodal_force_n[3][3], float force_n[3]);
typedef void haptable_pair_open_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float finger_m[3], struct haptable_pair_point* point);
typedef void haptable_pair_slope_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                    struct haptable_pair_point* point, const float v[3],
                                    struct haptable_pair_slope* slope);

/* A force law for two. */
struct haptable_pair_law {
    uint8_t controls;     /* of a patch: 3, or 6 */
    uint8_t is_stiffness; /* 1: A is a stiffness */
    haptable_pair_own_fn* own;
    haptable_pair_load_fn* load;
};

extern const struct haptable_pair_law haptable_pair_interpolated;
extern const struct haptable_pair_law haptable_pair_consistent;
extern const struct haptable_pair_law haptable_pair_pressure_mask;
extern const struct haptable_pair_law haptable_pair_consistent_packed;
extern const struct haptable_pair_law haptable_pair_pressure_mask_packed;

/* What the least energy needs besides. */
struct haptable_pair_bend {
    haptable_pair_open_fn* open;
    haptable_pair_slope_fn* slope;
};

extern const struct haptable_pair_bend haptable_pair_bend_interpolated;
extern const struct haptable_pair_bend haptable_pair_bend_consistent;
extern const struct haptable_pair_bend haptable_pair_bend_pressure_mask;
extern const struct haptable_pair_bend haptable_pair_bend_consistent_packed;
extern const struct haptable_pair_bend haptable_pair_bend_pressure_mask_packed;

/* What the laws of a compliance share, however its blocks are stored. */
haptable_pair_slope_fn haptable_pair_slope_consistent;
haptable_pair_slope_fn haptable_pair_slope_mask;
haptable_pair_load_fn haptable_pair_load_of_compliance;

/* All force laws for two, by what they are called behind haptable_pair_. */
#define HAPTABLE_PAIR_LAWS(X) \
    X(interpolated)           \
    X(consistent)             \
    X(pressure_mask)          \
    X(consistent_packed)      \
    X(pressure_mask_packed)

#ifdef __cplusplus
}
#endif

#endif
