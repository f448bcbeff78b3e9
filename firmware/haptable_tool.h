/* SPDX-License-Identifier: MIT
 *
 * x_i = p + R r_i,   F = -sum f_i,   M = -sum (R r_i) x f_i
 *
 * A rigid tool of many points that one hand holds (Barbic and James 2008 have its six degrees of freedom): the points'
 * loads are solved as haptable_points.h says.
 */
#ifndef HAPTABLE_TOOL_H
#define HAPTABLE_TOOL_H

#include "haptable_points.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tables and firmware trust each other only through this number, beside HAPTABLE_TABLE_VERSION. */
#define HAPTABLE_TOOL_VERSION 2

/* What tables hold. */
#define HAPTABLE_TOOL_FIELDS(VALUE, TABLE)                                                                    \
    TABLE(haptable_float3, point_m, point_count) /* r_i about the handle, in the tool's axes */               \
    VALUE(float, max_torque_n_m)                 /* limit of the torque on the hand, > 0 */                   \
    VALUE(float, reach_m)                        /* the largest |r_i|, > 0 */                                 \
    VALUE(float, stiffness_n_per_m)              /* of a virtual coupling; 0: the tool has the hand's pose */ \
    VALUE(float, turn_stiffness_n_m_per_rad)     /* the same about the handle */                              \
    VALUE(uint32_t, crc)                         /* for check: of all other values and tables */

#define HAPTABLE_TOOL_VALUE(type, name) type name;
#define HAPTABLE_TOOL_TABLE(type, name, count) const type* name;

/* A tool, const, so that it stays in flash. */
struct haptable_tool_model {
    struct haptable_points_model points; /* first: a scene with points names it */
    haptable_span_fn* span;
    HAPTABLE_TOOL_FIELDS(HAPTABLE_TOOL_VALUE, HAPTABLE_TOOL_TABLE)
};
#undef HAPTABLE_TOOL_VALUE
#undef HAPTABLE_TOOL_TABLE

/* The state of a tool, before its points' servos, its points and its system. The hand's servo comes first, as a
 * finger's does. */
struct haptable_tool_state {
    struct haptable_servo hand;
    struct haptable_servo tip;   /* with plausible: how far the farthest point has turned, as a finger along x */
    struct haptable_model model; /* the scene's, with the force of the tool and the nearest god-object */
    const struct haptable_tool_model* tool;
    float hand_turn[4];  /* of the last tick, believed or not */
    float position_m[3]; /* of the tool's handle: the hand's, or with a virtual coupling its own */
    float turn[4];
    float force_n[3];    /* on the hand, not limited */
    float moment_n_m[3]; /* the same about the handle */
    float given_n_m[3];  /* the torque of the last tick as it was given */
    float mean_n2;       /* with mean: of the squared torque as a force, filtered */
    float given_j;       /* with passivity: energy given to the hand, less what was taken */
    float brake_n_per_m; /* with passivity: what takes it back */
    uint16_t most;       /* the point that presses most; HAPTABLE_NONE */
    struct haptable_points points;
};

haptable_init_fn haptable_init_tool;
haptable_step_fn haptable_step_tool; /* in[0], out[0]: the first members of a tool's */
haptable_part_fn haptable_part_of_tool;
haptable_span_fn haptable_span_of_tool;
haptable_force_fn haptable_tool_force;
haptable_finish_fn haptable_tool_brake;

/* The contact of one of a tool's points in the last tick, as a finger's. before: the scene has a tool. */
void haptable_tool_point_of(const struct haptable_scene* scene, const void* state, int point,
                            struct haptable_output* out);

/* The same of a contact and its load, wherever they were solved; x_m: the point. */
void haptable_tool_put_point(const struct haptable_scene* scene, const struct haptable_contact* at,
                             const float load_n[3], const float x_m[3], struct haptable_output* out);

/* Where a point is, by the tool's pose: x_i = p + R r_i. */
void haptable_tool_place(const struct haptable_tool_model* tool, const float position_m[3], const float turn[4],
                         uint32_t point, float x_m[3]);

/* State layout of a tool that is known at run time. */
struct haptable_tool_room {
    struct haptable_tool_state hand;
    struct haptable_servo servo[HAPTABLE_POINTS];
    struct haptable_point point[HAPTABLE_POINTS];
    float system[HAPTABLE_POINTS_SETTLING_SYSTEM(HAPTABLE_POINTS)];
};

/* Writes the offsets of that layout. */
static inline void haptable_tool_lay_out(struct haptable_points_model* points) {
    points->state_at = (uint32_t)offsetof(struct haptable_tool_room, hand.points);
    points->servos_at = (uint32_t)offsetof(struct haptable_tool_room, servo);
    points->points_at = (uint32_t)offsetof(struct haptable_tool_room, point);
    points->system_at = (uint32_t)offsetof(struct haptable_tool_room, system);
}

/* Makes a scene of tables that are known at run time. before: haptable_tool_lay_out of the tool's points. */
void haptable_tool_scene_make(const struct haptable_model* model, const struct haptable_tool_model* tool,
                              struct haptable_points_scene* scene);

static inline const struct haptable_tool_model* haptable_tool_of(const struct haptable_scene* scene) {
    return (const struct haptable_tool_model*)((const struct haptable_points_scene*)scene)->points;
}

#ifdef __cplusplus
}
#endif

#endif
