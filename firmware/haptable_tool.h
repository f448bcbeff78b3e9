/* SPDX-License-Identifier: MIT
 *
 * x_i = p + R r_i,   C_TT f_T = u_T,   F = -sum f_i,   M = -sum (R r_i) x f_i
 *
 * A rigid tool of many points that one hand holds (Barbic and James 2008 have its six degrees of freedom, James and Pai
 * 2001 the coupled contacts). Each point has a god-object of its own; all loads are solved at once with the tables that
 * couple two fingers, C_ij = sum_kl w_k(g_i) w_l(g_j) C_kl. T are the points that press: a point out of T lies outside
 * of the surface as the others dent it.
 */
#ifndef HAPTABLE_TOOL_H
#define HAPTABLE_TOOL_H

#include "haptable_pair.h"
#include "haptable_scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tables and firmware trust each other only through this number, beside HAPTABLE_TABLE_VERSION. */
#define HAPTABLE_TOOL_VERSION 1

/* Maximum number of factorisations in the active set's search of a tick, and of a step toward least energy that it
 * tries. The second half only takes points out of T. */
#define HAPTABLE_TOOL_SETS 8
#define HAPTABLE_TOOL_TRIAL_SETS 4

/* Maximum number of such steps, each half of the one before. */
#define HAPTABLE_TOOL_TRIALS 2

/* Steps of the walk of a point in one of them. */
#define HAPTABLE_TOOL_WALK_STEPS 32

/* Factorisations of a tick: with the way back where no step is taken. */
#define HAPTABLE_TOOL_MOST_SETS (HAPTABLE_TOOL_SETS + (HAPTABLE_TOOL_TRIALS + 1) * HAPTABLE_TOOL_TRIAL_SETS)

/* What tables hold. */
#define HAPTABLE_TOOL_FIELDS(VALUE, TABLE)                                                                    \
    TABLE(haptable_float3, point_m, point_count) /* r_i about the handle, in the tool's axes */               \
    VALUE(float, max_torque_n_m)                 /* limit of the torque on the hand, > 0 */                   \
    VALUE(float, reach_m)                        /* the largest |r_i|, > 0 */                                 \
    VALUE(float, stiffness_n_per_m)              /* of a virtual coupling; 0: the tool has the hand's pose */ \
    VALUE(float, turn_stiffness_n_m_per_rad)     /* the same about the handle */                              \
    VALUE(uint16_t, point_count)                 /* 2 to HAPTABLE_POINTS */                                   \
    VALUE(uint32_t, crc)                         /* for check: of all other values and tables */

#define HAPTABLE_TOOL_VALUE(type, name) type name;
#define HAPTABLE_TOOL_TABLE(type, name, count) const type* name;

struct haptable_tool_model;
struct haptable_tool_state;

/* Moves the points that touch to where less energy is stored. before: their loads are solved. after: the same. */
typedef void haptable_tool_settle_fn(const struct haptable_tool_model* tool, struct haptable_tool_state* state);

/* A tool, const, so that it stays in flash. */
struct haptable_tool_model {
    const struct haptable_pair_model* pair; /* tables that couple two places; its law is a compliance's */
    haptable_pair_couple_fn* couple;        /* by pair->place_count */
    haptable_pair_pull_fn* pull;            /* the same; with settle */
    haptable_tool_settle_fn* settle;        /* with least energy, with friction: haptable_tool_settle; else NULL */
    haptable_span_fn* span;
    uint32_t points_at; /* byte of the first struct haptable_tool_point in the state */
    uint32_t system_at; /* byte of the system: HAPTABLE_TOOL_SYSTEM(point_count) floats */
    HAPTABLE_TOOL_FIELDS(HAPTABLE_TOOL_VALUE, HAPTABLE_TOOL_TABLE)
};
#undef HAPTABLE_TOOL_VALUE
#undef HAPTABLE_TOOL_TABLE

/* Floats of the system of n points: C above its diagonal and on it, its factor below; then the factor's inverse
 * diagonal. */
#define HAPTABLE_TOOL_SYSTEM(points) (9 * (points) * (points) + 3 * (points))

/* A scene with a tool: its functions get the scene, which is its first member. */
struct haptable_tool_scene {
    struct haptable_scene scene;
    const struct haptable_tool_model* tool;
};

struct haptable_tool_point {
    struct haptable_servo servo; /* whether it is inside: the nearest god-object */
    struct haptable_contact at;  /* god-object of the load: that one, or with settle another */
    struct haptable_pair_own own;
    struct haptable_pair_place place;
    float r_m[3];      /* R r_i */
    float load_n[3];   /* f_i on the body; 0 out of T */
    float normal[3];   /* outward at the nearest god-object, length 1 */
    float raised_m;    /* by so much the others had raised the surface where its contact began */
    uint32_t met;      /* contacts of its servo, as raised_m is of the last */
    uint8_t is_inside; /* 1: it has a contact */
    uint8_t presses;   /* 1: it is in T */
    uint8_t is_known;  /* 1: C has its rows */
};

/* The state of a tool, before its points and its system. The hand's servo comes first, as a finger's does. */
struct haptable_tool_state {
    struct haptable_servo hand;
    struct haptable_servo tip;   /* with plausible: how far the farthest point has turned, as a finger along x */
    struct haptable_model model; /* the scene's, with the force of the tool and the nearest god-object */
    const struct haptable_tool_model* tool;
    float hand_turn[4];  /* of the last tick, believed or not */
    float position_m[3]; /* of the tool's handle: the hand's, or with a virtual coupling its own */
    float turn[4];
    float force_n[3];                /* on the hand, not limited */
    float moment_n_m[3];             /* the same about the handle */
    float given_n_m[3];              /* the torque of the last tick as it was given */
    float mean_n2;                   /* with mean: of the squared torque as a force, filtered */
    float energy_j;                  /* stored by all points */
    float given_j;                   /* with passivity: energy given to the hand, less what was taken */
    float brake_n_per_m;             /* with passivity: what takes it back */
    uint16_t order[HAPTABLE_POINTS]; /* of the factor's rows: points of T */
    uint16_t count;                  /* of them */
    uint16_t most;                   /* the point that presses most; HAPTABLE_NONE */
    uint16_t sets;                   /* factorisations of the last tick */
    uint16_t most_sets;              /* the most of any tick */
};

haptable_init_fn haptable_init_tool;
haptable_step_fn haptable_step_tool; /* in[0], out[0]: the first members of a tool's */
haptable_part_fn haptable_part_of_tool;
haptable_span_fn haptable_span_of_tool;
haptable_force_fn haptable_tool_force;
haptable_finish_fn haptable_tool_brake;
haptable_tool_settle_fn haptable_tool_settle;

/* The contact of one of a tool's points in the last tick, as a finger's. before: the scene has a tool. */
void haptable_tool_point_of(const struct haptable_scene* scene, const void* state, int point,
                            struct haptable_output* out);

/* Writes C of every point that is inside and not known, solves C_TT f_T = u_T, and finds T, by so many factorisations
 * at the most. */
void haptable_tool_solve(const struct haptable_tool_model* tool, struct haptable_tool_state* state, int most_sets);

/* K = J^T C_TT^-1 J: the stiffness of the points that press, against a motion (d, theta) of the tool, its god-objects
 * staying; J_i = (1, -[r_i]). Lower half. */
void haptable_tool_stiffness(const struct haptable_tool_model* tool, struct haptable_tool_state* state, float (*k)[6]);

/* sum_j C_ij f_j: how far the loads move the surface at a point. */
void haptable_tool_lowered(const struct haptable_tool_model* tool, struct haptable_tool_state* state, uint32_t i,
                           float lowered_m[3]);

/* State layout of a tool that is known at run time. */
struct haptable_tool_room {
    struct haptable_tool_state hand;
    struct haptable_tool_point point[HAPTABLE_POINTS];
    float system[HAPTABLE_TOOL_SYSTEM(HAPTABLE_POINTS)];
};

/* Writes the offsets of that layout. */
static inline void haptable_tool_lay_out(struct haptable_tool_model* tool) {
    tool->points_at = (uint32_t)offsetof(struct haptable_tool_room, point);
    tool->system_at = (uint32_t)offsetof(struct haptable_tool_room, system);
}

/* Makes a scene of tables that are known at run time. before: haptable_tool_lay_out of the tool. */
void haptable_tool_scene_make(const struct haptable_model* model, const struct haptable_tool_model* tool,
                              struct haptable_tool_scene* scene);

static inline struct haptable_tool_point* haptable_tool_points(const struct haptable_tool_model* tool,
                                                               struct haptable_tool_state* state) {
    return (struct haptable_tool_point*)((unsigned char*)state + tool->points_at);
}
static inline float* haptable_tool_system(const struct haptable_tool_model* tool, struct haptable_tool_state* state) {
    return (float*)(void*)((unsigned char*)state + tool->system_at);
}

#ifdef __cplusplus
}
#endif

#endif
