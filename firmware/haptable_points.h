/* SPDX-License-Identifier: MIT
 *
 * C_TT f_T = u_T,   C_ij = sum_kl w_k(g_i) w_l(g_j) C_kl
 *
 * Many points that touch one body at once (the paper's n nodes; James and Pai 2001): each has a god-object of its own,
 * and all loads are solved together with the tables that couple two places. T are the points that press; a point out of
 * T lies outside of the surface as the others dent it. They are the points of a tool, or fingers that are hands of
 * their own (haptable_hands.c).
 */
#ifndef HAPTABLE_POINTS_H
#define HAPTABLE_POINTS_H

#include "haptable_pair.h"
#include "haptable_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Maximum number of factorisations in the active set's search of a tick, and of a step toward least energy that it
 * tries. The second half only takes points out of T. */
#define HAPTABLE_POINTS_SETS 8
#define HAPTABLE_POINTS_TRIAL_SETS 4

/* Maximum number of such steps, each half of the one before. */
#define HAPTABLE_POINTS_TRIALS 2

/* Steps of the walk of a point in one of them. */
#define HAPTABLE_POINTS_WALK_STEPS 32

/* Ticks that a point may be inside of the dented surface without a load, before its contact begins anew. */
#define HAPTABLE_POINTS_UNFELT 4

struct haptable_points_model;

/* Moves the points that touch to where less energy is stored. before: their loads are solved. after: the same. */
typedef void haptable_points_settle_fn(const struct haptable_points_model* of, void* state);

/* What couples them, and where they stand in a scene's state; const, so that it stays in flash. */
struct haptable_points_model {
    const struct haptable_pair_model* pair; /* tables that couple two places; its law is a compliance's */
    haptable_pair_couple_fn* couple;        /* by pair->place_count */
    haptable_pair_pull_fn* pull;            /* the same; with settle */
    haptable_points_settle_fn* settle;      /* with least energy, with friction: haptable_points_settle; else NULL */
    uint32_t state_at;                      /* byte of struct haptable_points in the state */
    uint32_t servos_at;                     /* of the first point's servo */
    uint32_t points_at;                     /* of the first struct haptable_point */
    uint32_t system_at;                     /* of HAPTABLE_POINTS_SYSTEM(count) floats; with settle _SETTLING_SYSTEM */
    uint16_t count;                         /* 2 to HAPTABLE_POINTS */
};

/* Floats of the system of n points: C above its diagonal and on it, its factor below; then the factor's inverse
 * diagonal. */
#define HAPTABLE_POINTS_SYSTEM(points) (9 * (points) * (points) + 3 * (points))

/* The same, and C once more, as it was before a step toward least energy. */
#define HAPTABLE_POINTS_SETTLING_SYSTEM(points) \
    (HAPTABLE_POINTS_SYSTEM(points) + (9 * (points) * (points) + 3 * (points)) / 2)

/* A scene with points: its functions get the scene, which is its first member. */
struct haptable_points_scene {
    struct haptable_scene scene;
    const struct haptable_points_model* points;
};

/* A point, beside its servo, which tells whether it is inside: that one's contact is the nearest god-object. */
struct haptable_point {
    struct haptable_contact at; /* god-object of the load: the nearest, or with settle another */
    struct haptable_pair_own own;
    struct haptable_pair_place place;
    float load_n[3];   /* f_i on the body; 0 out of T */
    float normal[3];   /* outward at the nearest god-object, length 1 */
    float raised_m;    /* by so much the others had raised the surface where its contact began */
    float sunk_m[3];   /* with settle: from where its contact began anew, without a load, to the surface */
    uint32_t met;      /* contacts of its servo, as raised_m is of the last */
    uint8_t is_inside; /* 1: it has a contact */
    uint8_t presses;   /* 1: it is in T */
    uint8_t is_known;  /* 1: C has its own block */
    uint8_t unfelt;    /* ticks that it has been inside of the dented surface without a load */
    uint32_t coupled;  /* bit j: C has its block with point j */
};

/* All points of a state. */
struct haptable_points {
    float energy_j;                  /* stored by all */
    float paid_j;                    /* with settle: the same, of T as the tick began */
    uint16_t order[HAPTABLE_POINTS]; /* of the factor's rows: points of T */
    uint16_t count;                  /* of them; 0: C has changed since */
    uint16_t sets;                   /* factorisations of the last tick */
    uint16_t most_sets;              /* the most of any tick */
};

haptable_points_settle_fn haptable_points_settle;

/* Writes the tables that couple points, and the functions that go by them. */
void haptable_points_model_make(const struct haptable_pair_model* pair, struct haptable_points_model* points);

/* What points move and feel by: the scene's model with the nearest god-object and their force; brake: its passivity,
 * where it has one. */
void haptable_points_take_model(const struct haptable_model* from, haptable_force_fn* force, haptable_finish_fn* brake,
                                struct haptable_model* to);

/* No contact, as nobody knows where it was. */
void haptable_point_forget(const struct haptable_points_model* of, void* state, uint32_t i);

/* Where a point's nearest god-object has gone; with settle its load stays where it is. */
void haptable_point_see(const struct haptable_points_model* of, void* state, uint32_t i);

/* A tick's loads and T, each god-object at rest, once every point is seen. */
void haptable_points_tick(const struct haptable_points_model* of, void* state);

/* Writes C of every point that is inside and not known, solves C_TT f_T = u_T, and finds T, by so many factorisations
 * at the most. Returns 0 where that many do not find it. */
int haptable_points_solve(const struct haptable_points_model* of, void* state, int most_sets);

/* Leaves the deepest point alone in T, with the load of a finger, if it presses: where no T was found, or so many load
 * one place that no float has what C^-1 makes of its error. */
void haptable_points_press_by_one(const struct haptable_points_model* of, void* state);

/* How far a point out of T lies inside of the surface as the others dent it, by its nearest god-object. */
float haptable_point_depth(const struct haptable_points_model* of, void* state, uint32_t i);

/* With settle: a point out of T that has been inside of the dented surface for HAPTABLE_POINTS_UNFELT ticks begins anew
 * where it is, without a load: who presses it farther feels it. */
void haptable_point_sink(const struct haptable_points_model* of, void* state, uint32_t i);

/* With settle: keeps C, and takes it back; the points are the caller's. */
void haptable_points_keep(const struct haptable_points_model* of, void* state);
void haptable_points_take_back(const struct haptable_points_model* of, void* state);

/* C_TT = L L^T of T as it is now, and of C as it was written last: the points that T begins with as before stay. */
void haptable_points_factor(const struct haptable_points_model* of, void* state);

/* x = L^-1 x of C_TT = L L^T: [3 count], in T's order. */
void haptable_points_forward(const struct haptable_points_model* of, void* state, float x[]);

/* sum_j C_ij f_j: how far the loads move the surface at a point. */
void haptable_points_lowered(const struct haptable_points_model* of, void* state, uint32_t i, float lowered_m[3]);

/* Four sums, so that they need not wait for one another. */
static inline float haptable_points_dot(const float* a, const float* b, uint32_t count) {
    float sum[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    uint32_t k = 0;
    for (; k + 4u <= count; k += 4u) {
        sum[0] += a[k] * b[k];
        sum[1] += a[k + 1u] * b[k + 1u];
        sum[2] += a[k + 2u] * b[k + 2u];
        sum[3] += a[k + 3u] * b[k + 3u];
    }
    for (; k < count; ++k) sum[0] += a[k] * b[k];
    return (sum[0] + sum[2]) + (sum[1] + sum[3]);
}

static inline void* haptable_points_byte(void* state, uint32_t at) { return (unsigned char*)state + at; }

static inline struct haptable_points* haptable_points_of(const struct haptable_points_model* of, void* state) {
    return (struct haptable_points*)haptable_points_byte(state, of->state_at);
}
static inline struct haptable_servo* haptable_points_servos(const struct haptable_points_model* of, void* state) {
    return (struct haptable_servo*)haptable_points_byte(state, of->servos_at);
}
static inline struct haptable_point* haptable_points_in(const struct haptable_points_model* of, void* state) {
    return (struct haptable_point*)haptable_points_byte(state, of->points_at);
}
static inline float* haptable_points_system(const struct haptable_points_model* of, void* state) {
    return (float*)haptable_points_byte(state, of->system_at);
}

#ifdef __cplusplus
}
#endif

#endif
