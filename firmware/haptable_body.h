/* SPDX-License-Identifier: MIT
 *
 *   m v' = F,   J w' + w x J w = T,   q' = q (0, w) / 2,   p' = v
 *
 * A body that is not held: it moves as a rigid one, and fingers feel its elastic part in its own frame. Its blocks are
 * those of inertia relief (docs/BODY.md), so that nothing artificial holds it.
 *
 * World and body coordinates are the same where the body begins. Tables are const (struct haptable_body, written by
 * codegen), state is one struct that the caller owns. Not trusted: what the fingers do. cost: docs/BODY.md.
 */
#ifndef HAPTABLE_BODY_H
#define HAPTABLE_BODY_H

#include "haptable.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The most points of the body that rest on the floor, and the most fingers that push it. */
#define HAPTABLE_BODY_POINTS 8
#define HAPTABLE_BODY_FINGERS 2

/* How often a tick's implicit step is solved: each time what is left falls by the angle that the body turns in a tick,
 * or by (tick x turning frequency)^2. */
#define HAPTABLE_BODY_ROUNDS 4

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
};
#undef HAPTABLE_BODY_VALUE
#undef HAPTABLE_BODY_VECTOR

/* Where the body is and how it moves: 13 numbers, and what rounding left of them. The caller owns it;
 * haptable_body_init makes it valid. */
struct haptable_body_state {
    float position_m[3];       /* of its centre of mass, world */
    float turn[4];             /* from body to world axes: a quaternion of length 1, w x y z */
    float velocity_m_per_s[3]; /* of the centre, world axes */
    float spin_rad_per_s[3];   /* body axes */
    float position_low_m[3];   /* of the sums above, what float32 did not hold (Kahan) */
    float turn_low[4];
    float stretch_m[HAPTABLE_BODY_POINTS][2]; /* of each point's spring along the floor: what friction holds */
    float push_n[HAPTABLE_BODY_POINTS];       /* by which the floor carried it in the last tick */
    float finger_m[HAPTABLE_BODY_FINGERS][3]; /* last positions, world */
    float given_n[HAPTABLE_BODY_FINGERS][3];  /* last forces on the hands, world axes */
    float stored_j[HAPTABLE_BODY_FINGERS];    /* in their contacts then */
    float worked_j[HAPTABLE_BODY_FINGERS];    /* what they did to the body since */
    uint8_t finger_known[HAPTABLE_BODY_FINGERS];
    uint8_t on_floor; /* bits: the points that the floor carried in the last tick */
    uint8_t slips;    /* bits: those of them that slipped */
};

/* What one finger does to the body in a tick; body coordinates. */
struct haptable_body_push {
    float at_m[3];
    float force_n[3];          /* on the body */
    float velocity_m_per_s[3]; /* of the hand, along body axes */
    float stiffness_n_per_m;   /* of the contact: force / dent; 0 without contact */
    uint8_t sticks;            /* 1: held in all directions; 0: along the force alone */
};

void haptable_body_init(const struct haptable_body* body, struct haptable_body_state* state);

/* A world position in body coordinates, and a vector along body axes in world axes. */
void haptable_body_from_world(const struct haptable_body* body, const struct haptable_body_state* state,
                              const float world_m[3], float body_m[3]);
void haptable_body_to_world(const struct haptable_body_state* state, const float along_body[3], float along_world[3]);

/* Moves the body by a tick under what the fingers do: push[i] is of finger i. before: push_count <=
 * HAPTABLE_BODY_FINGERS, pushes are numbers. after: state->turn has length 1 within rounding. */
void haptable_body_move(const struct haptable_body* body, struct haptable_body_state* state,
                        const struct haptable_body_push push[], int push_count);

/* What finger `number` at world_m does to the body by what haptable_step made of it at at_m, `out`, both in body
 * coordinates: the reaction of the force that the user feels. Returns the energy, J, that the contact has given to hand
 * and body since the last tick beyond what it took and had stored; below 0 where it kept some. */
float haptable_body_push_of(const struct haptable_model* model, const struct haptable_body* body,
                            const struct haptable_servo* servo, struct haptable_body_state* state, int number,
                            const float world_m[3], const float at_m[3], const struct haptable_output* out,
                            struct haptable_body_push* push);

/* Takes that energy out of the body's motion, as far as it has any: what sampled contacts made is in neither. */
void haptable_body_brake(const struct haptable_body* body, struct haptable_body_state* state, float energy_j);

/* One tick of a body and its fingers, which know of one another by its motion alone: finger positions in, in world
 * coordinates; forces out, in world axes. All else of out[] is in body coordinates. before: 1 <= finger_count <=
 * HAPTABLE_BODY_FINGERS; a servo for each. Bounded work: haptable_step for each, then haptable_body_move. */
void haptable_body_step(const struct haptable_model* model, const struct haptable_body* body,
                        struct haptable_body_state* state, struct haptable_servo servo[], int finger_count,
                        const float finger_m[][3], uint32_t now_us, struct haptable_output out[]);

#ifdef __cplusplus
}
#endif

#endif
