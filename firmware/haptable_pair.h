/* SPDX-License-Identifier: MIT
 *
 * [C_11 C_12; C_21 C_22] f = u,   F = -f,   C_cd = sum_ab w_a(g_c) w_b(g_d) L_ab
 *
 * Two fingers on one body: each feels the dent that the other makes. Two servos on one model, and a table of what
 * couples two places of its surface. An entry of its own: where no program calls it, nothing of it is linked.
 *
 * Positions, forces and outputs are in the body's frame, as those of haptable_step.
 */
#ifndef HAPTABLE_PAIR_H
#define HAPTABLE_PAIR_H

#include "haptable.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_FINGERS 2

/* Tables and firmware trust each other only through this number, beside HAPTABLE_TABLE_VERSION. */
#define HAPTABLE_PAIR_VERSION 1

/* The most of the far field's rank: state holds as many vectors for each finger. */
#define HAPTABLE_PAIR_RANK 48

/* The most controls of a patch: its vertices and, under a mask, its edges. */
#define HAPTABLE_PAIR_CONTROLS 6

/* By so much the coupling of two fingers is less where they meet; it fades in from meeting_m apart. What is left keeps
 * C positive definite by an eighth of C_11 and C_22. */
#define HAPTABLE_PAIR_MEETING 0.125f

/* The controls that a place loads, and how much. */
struct haptable_pair_place {
    uint16_t control[HAPTABLE_PAIR_CONTROLS]; /* HAPTABLE_NONE: adds nothing, as a fixed vertex */
    float weight[HAPTABLE_PAIR_CONTROLS];     /* sum 1 */
};

/* A place of its own, without the other: A v = s, load f of v. Of the consistent and the mask's force A = C, s = u,
 * f = v; of the interpolated one A = S, s = S u, f = S v, so that what couples is S_a L_ab S_b. */
struct haptable_pair_own {
    float a[6];
    float s[3];
};

struct haptable_pair_view;

/* What couples the controls of a patch, row by row, to the other finger's place: x[k] = sum_l w_l C_kl. */
typedef void haptable_pair_cross_fn(const struct haptable_pair_view* view, const uint16_t* control, int count,
                                    float (*x)[9]);

/* The far field at the other finger's place, which a tick's coupling is made of: view->far; or NULL. */
typedef void haptable_pair_far_fn(struct haptable_pair_view* view);

typedef void haptable_pair_own_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                  const float finger_m[3], struct haptable_pair_own* own);

/* The nodal forces of v, and the reaction that the user feels. */
typedef void haptable_pair_load_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                   const float v[3], float nodal_force_n[3][3], float force_n[3]);

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

/* The coupling of one object, beside its model; const, so that it stays in flash. */
struct haptable_pair_model {
    const struct haptable_model* model;
    const struct haptable_pair_law* law;
    haptable_energy_fn* energy;     /* for god_object_least_energy; else NULL */
    haptable_pair_cross_fn* cross;  /* one of those below: it says which of the next are used */
    haptable_pair_far_fn* far;      /* as cross asks */
    float meeting_m;                /* fingers nearer than this meet, > 0 */
    uint16_t control_count;         /* n: free vertices; or vertices, then edges */
    uint16_t rank;                  /* r <= HAPTABLE_PAIR_RANK */
    const float (*block)[9];        /* exact: C_kl of all pairs k >= l in a row by k, [n (n + 1) / 2] */
    const uint32_t* near_begin;     /* low rank: [n + 1] where control k's near pairs begin */
    const uint16_t* near;           /* l <= k of each, ascending in a row */
    const int16_t (*near_block)[9]; /* E_kl of each, in steps */
    const int16_t (*column)[3];     /* Phi, [n r], in steps: C_kl = Phi_k Phi_l^T, and of near pairs E_kl besides */
    float near_step;
    float column_step;
};

/* cross: every pair is a block. cost: controls squared blocks. */
haptable_pair_cross_fn haptable_pair_cross_exact;

/* cross: near pairs are blocks, the others sum_r Phi_kr Phi_lr^T. cost: besides, controls r products of vectors. */
haptable_pair_cross_fn haptable_pair_cross_low_rank;
haptable_pair_far_fn haptable_pair_far_low_rank;

haptable_energy_fn haptable_pair_energy_interpolated;
haptable_energy_fn haptable_pair_energy_consistent;
haptable_energy_fn haptable_pair_energy_pressure_mask;

/* What a finger is told of the other in a tick. The model comes first: functions that a model names get it. */
struct haptable_pair_view {
    struct haptable_model model; /* of the tables, with the force and the energy that the other changes */
    const struct haptable_pair_model* tables;
    uint8_t is_coupled; /* 0: alone */
    uint8_t is_solved;  /* 1: v is the pair's */
    struct haptable_pair_place place;
    float at_m[3];                    /* the other's god-object */
    float m[6];                       /* its A^-1 */
    float s[3];                       /* its s */
    float v[3];                       /* this finger's, where is_solved */
    float brake_n_per_m;              /* with passivity: what takes back what was given, of the tick's motion */
    float far[HAPTABLE_PAIR_RANK][3]; /* sum_l w_l Phi_l */
};

/* The state of two fingers on one body. The caller owns it; haptable_pair_init makes it valid. */
struct haptable_pair {
    struct haptable_servo servo[HAPTABLE_FINGERS];
    struct haptable_pair_view view[HAPTABLE_FINGERS];
    uint8_t touches[HAPTABLE_FINGERS]; /* 0: no contact, or the other's dent leaves it behind: it gives no force */
    float energy_j;                    /* stored by both, of the last tick */
    float given_j;                     /* with passivity: energy given to both hands, less what was taken */
};

/* Two servos without a contact. before: tables' model does not name `relax`. */
void haptable_pair_init(const struct haptable_pair_model* tables, struct haptable_pair* pair);

/* One tick of both fingers at once: positions in, forces out. cost: each finger's own tick and twice the coupling of
 * two patches; with least energy, friction: the coupling of two patches beside every energy, every force. */
void haptable_pair_step(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                        const float finger_m[HAPTABLE_FINGERS][3], uint32_t now_us,
                        struct haptable_output out[HAPTABLE_FINGERS]);

/* One tick of one finger, the other staying where it was: for devices that do not share a clock. */
void haptable_pair_step_finger(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                               const float finger_m[3], uint32_t now_us, struct haptable_output* out);

/* As haptable_watch, of one finger. */
int haptable_pair_watch(struct haptable_pair* pair, int finger, uint32_t now_us, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
