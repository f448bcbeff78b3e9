/* SPDX-License-Identifier: MIT
 *
 *   m v' = F,   L' = T,   w = J^-1 R^T L,   q' = q (0, w) / 2,   p' = v
 *
 * The rigid motion of a body that is not held: fingers feel its elastic part in its own frame (haptable_moving.h). Its
 * blocks are those of inertia relief (docs/design/moving.md), so that nothing artificial holds it.
 *
 * World and body coordinates are the same where the body begins. Tables are const (struct haptable_body, written by
 * codegen), state is one struct that the caller owns. cost: docs/MOVING.md.
 */
#ifndef HAPTABLE_BODY_H
#define HAPTABLE_BODY_H

#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The most points of the body that rest on the floor. */
#define HAPTABLE_BODY_POINTS 8

/* How often a tick's implicit step is solved: each time what is left falls by half the angle that the body turns in a
 * tick, or by (tick x turning frequency)^2. */
#define HAPTABLE_BODY_ROUNDS 5

/* A tick, s. */
#define HAPTABLE_BODY_TICK_S 0.001f

/* One list makes the struct, its C text and the file that codegen reads (docs/SPEC.md): VALUE(name), VECTOR(name,
 * size), all float; then points. */
#define HAPTABLE_BODY_FIELDS(VALUE, VECTOR)                                             \
    VALUE(mass_kg)               /* > 0 */                                              \
    VECTOR(centre_m, 3)          /* of mass, body coordinates */                        \
    VECTOR(inertia_kg_m2, 6)     /* about it, body axes: xx yy zz xy yz zx */           \
    VECTOR(gravity_m_per_s2, 3)  /* world axes */                                       \
    VECTOR(stiffness_n_per_m, 3) /* suspension of the centre, world axes; 0: none */    \
    VECTOR(damping_n_s_per_m, 3)                                                        \
    VECTOR(turn_stiffness_n_m, 3) /* of turning: N m/rad for small angles, body axes */ \
    VECTOR(turn_damping_n_m_s, 3)                                                       \
    VECTOR(floor_normal, 3)        /* up, length 1, world axes */                       \
    VECTOR(floor_along, 3)         /* a direction in it, length 1 */                    \
    VALUE(floor_m)                 /* the floor is where floor_normal . x = floor_m */  \
    VALUE(floor_stiffness_n_per_m) /* of each point on it */                            \
    VALUE(floor_damping_n_s_per_m)                                                      \
    VALUE(floor_friction) /* Coulomb's coefficient */

#define HAPTABLE_BODY_VALUE(name) float name;
#define HAPTABLE_BODY_VECTOR(name, size) float name[size];
struct haptable_body {
    HAPTABLE_BODY_FIELDS(HAPTABLE_BODY_VALUE, HAPTABLE_BODY_VECTOR)
    uint32_t point_count;                   /* <= HAPTABLE_BODY_POINTS; 0: no floor */
    float point_m[HAPTABLE_BODY_POINTS][3]; /* what may rest on the floor, body coordinates */
    uint32_t motion;                        /* enum haptable_rigid_motion, for haptable_scene_make */
    uint32_t crc;                           /* for a model's check: of all before it, haptable_crc_of */
};
#undef HAPTABLE_BODY_VALUE
#undef HAPTABLE_BODY_VECTOR

/* Where the body is and how it moves. The caller owns it; haptable_body_init makes it valid. Its momentum is state, its
 * spin follows: so what nothing touches keeps velocity and momentum to the last bit. */
struct haptable_body_state {
    float position_m[3];       /* of its centre of mass, world */
    float turn[4];             /* from body to world axes: a quaternion of length 1, w x y z */
    float velocity_m_per_s[3]; /* of the centre, world axes */
    float momentum_n_m_s[3];   /* angular, about the centre, world axes */
    float spin_rad_per_s[3];   /* body axes: J^-1 R^T momentum_n_m_s */
    float position_low_m[3];   /* of the sums above, what float32 did not hold (Kahan) */
    float turn_low[4];
    float velocity_low_m_per_s[3];
    float momentum_low_n_m_s[3];
    float stretch_m[HAPTABLE_BODY_POINTS][2]; /* of each point's spring along the floor: what friction holds */
    float push_n[HAPTABLE_BODY_POINTS];       /* by which the floor carried it in the last tick */
    float floor_owed_j; /* what the floor gave as points entered or slipped, and has not taken back; >= 0 */
    uint8_t on_floor;   /* bits: the points that the floor carried in the last tick */
    uint8_t slips;      /* bits: those of them that slipped */
};

void haptable_body_init(const struct haptable_body* body, struct haptable_body_state* state);

/* A world position in body coordinates; a vector along body axes in world axes. */
void haptable_body_from_world(const struct haptable_body* body, const struct haptable_body_state* state,
                              const float world_m[3], float body_m[3]);
void haptable_body_to_world(const struct haptable_body_state* state, const float along_body[3], float along_world[3]);

/* The impulse of a force on the body at a place in body coordinates, over a tick: momentum changes by just that.
 * force_n: world axes. */
void haptable_body_kick(const struct haptable_body* body, struct haptable_body_state* state, const float at_m[3],
                        const float force_n[3]);

/* How far that force would move the body at the place beyond its motion, in a tick, both along body axes. */
void haptable_body_give(const struct haptable_body* body, const float at_m[3], const float force_n[3],
                        float moved_m[3]);

/* A tick of motion under weight, suspension and floor. after: state->turn has length 1 within rounding. Bounded work.
 */
void haptable_body_move(const struct haptable_body* body, struct haptable_body_state* state);

/* The same as a part of a scene's tick: linked where a scene names it. */
struct haptable_rigid_part {
    void (*init)(const struct haptable_body* body, struct haptable_body_state* state);
    void (*from_world)(const struct haptable_body* body, const struct haptable_body_state* state,
                       const float world_m[3], float body_m[3]);
    void (*to_world)(const struct haptable_body_state* state, const float along_body[3], float along_world[3]);
    void (*give)(const struct haptable_body* body, const float at_m[3], const float force_n[3], float moved_m[3]);
    void (*kick)(const struct haptable_body* body, struct haptable_body_state* state, const float at_m[3],
                 const float force_n[3]);
    void (*move)(const struct haptable_body* body, struct haptable_body_state* state);
    haptable_span_fn* span;
};

/* How a body moves as a whole, a line each (HAPTABLE_MOVERS of haptable_scene.h):
 *   PART       its struct haptable_rigid_part is haptable_part_PART
 *   KEY, WORD  the scene's key that chooses it, of several the last; in the names of strokes
 *   TITLE      in docs/MOVING.md
 *   ONE, EACH  instructions of a tick beside its contacts, at most: under one finger, and for each point on the floor
 *   TWO, EACH  the same under two fingers
 * Rigid motion has two systems of 6x6 and eight solves; of a finger 4 lines of the system, of a point 3, twice. */
#define HAPTABLE_RIGID_MOVERS(X) X(rigid, "body.free", "free", "rigid motion", 11400, 2800, 13800, 2800)

#define HAPTABLE_RIGID_PART(PART, ...) extern const struct haptable_rigid_part haptable_part_##PART;
#define HAPTABLE_RIGID_MOTION(PART, ...) HAPTABLE_MOTION_##PART,
HAPTABLE_RIGID_MOVERS(HAPTABLE_RIGID_PART)
enum haptable_rigid_motion { HAPTABLE_RIGID_MOVERS(HAPTABLE_RIGID_MOTION) HAPTABLE_RIGID_MOTIONS };
#undef HAPTABLE_RIGID_PART
#undef HAPTABLE_RIGID_MOTION

haptable_span_fn haptable_span_of_body; /* of a struct haptable_body */

#ifdef __cplusplus
}
#endif

#endif
