/* SPDX-License-Identifier: MIT
 *
 * What goes into a tick and comes out of it, and its limits. Boards include haptable.h; the servo's own files take no
 * more of it than this.
 */
#ifndef HAPTABLE_TYPES_H
#define HAPTABLE_TYPES_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* No patch, no neighbour. A model has at most 65,534 patches and as many vertices. */
#define HAPTABLE_NONE 0xFFFFu

/* The most fingers on any body, and on one that is held, follows at once and has a compliance; the most modes of a body
 * that rings; the most points of a tool. */
#define HAPTABLE_FINGERS 2
#define HAPTABLE_HANDS 8
#define HAPTABLE_MODES 16
#define HAPTABLE_POINTS 32

/* A tick, microseconds: the servo is called so often. */
#define HAPTABLE_TICK_US 1000u

/* No position for this long (microseconds): the force goes to zero. */
#define HAPTABLE_SILENCE_US 20000u

enum haptable_state {
    HAPTABLE_SILENT = 0,   /* no position yet, or none for HAPTABLE_SILENCE_US: zero force */
    HAPTABLE_FREE = 1,     /* finger outside: zero force */
    HAPTABLE_CONTACT = 2,  /* god-object on the surface */
    HAPTABLE_REJECTED = 3, /* the last position was not one, or is not believed yet: zero force, contact dropped */
    HAPTABLE_LIMITED = 4,  /* contact, with less force than the body's: gain < 1 */
    HAPTABLE_FAULTED = 5   /* a fault that waits to be acknowledged, or tables that were not checked: zero force */
};

/* 1 in the states with contact. */
static inline int haptable_touches(int state) { return state == HAPTABLE_CONTACT || state == HAPTABLE_LIMITED; }

/* Why a servo is HAPTABLE_FAULTED: bits. They stand until HAPTABLE_BUTTON_ACKNOWLEDGE is pressed. */
enum haptable_fault {
    HAPTABLE_FAULT_TABLES = 1,   /* the tables' CRC is wrong, or was not taken yet: this one ends by the next check */
    HAPTABLE_FAULT_FORCE = 2,    /* a force was not a number */
    HAPTABLE_FAULT_POSITIONS = 4 /* implausible positions came again and again */
};

/* What a hand may hold down: bits of haptable_input.buttons. */
enum haptable_button {
    HAPTABLE_BUTTON_CLUTCH = 1,     /* the host's: the finger moves without the device's position */
    HAPTABLE_BUTTON_GRAB = 2,       /* the contact holds the finger */
    HAPTABLE_BUTTON_ACKNOWLEDGE = 4 /* a fault that waits for the user is over */
};

/* What the servo counts, by name: one list drives the struct, the messages and the reports. */
#define HAPTABLE_COUNTERS(X)                                              \
    X(ticks)              /* calls of haptable_step */                    \
    X(contact_ticks)      /* of these, with contact */                    \
    X(contacts)           /* contacts begun */                            \
    X(rejected_positions) /* NaN, infinite or absurd finger positions */  \
    X(implausible)        /* positions that no finger reaches in time */  \
    X(rejected_forces)    /* forces that were not finite: zero given */   \
    X(limited_ticks)      /* contact_ticks with less than the body's */   \
    X(rate_limits)        /* of these, where the rise of the force was */ \
    X(mean_limits)        /* of these, where the mean force was */        \
    X(faulted)            /* faults that had to be acknowledged */        \
    X(grabbed_ticks)      /* contact_ticks in which the hand held on */   \
    X(clamped_forces)     /* forces cut to max_force_n */                 \
    X(walk_limits)        /* slides that met HAPTABLE_WALK_STEPS */       \
    X(slide_limits)       /* ticks that met HAPTABLE_SLIDES */            \
    X(box_limits)         /* ticks that met HAPTABLE_TICK_BOXES */        \
    X(given_up)           /* contacts let go as limits left them open */  \
    X(jumps)              /* with release: forces that it smoothed */     \
    X(silences)           /* times without a position for SILENCE_US */   \
    X(most_steps)         /* most steps of the walk in one tick */        \
    X(most_held_steps)    /* with friction: most steps of holding back */ \
    X(most_energies)      /* most steps of the energy in one tick */      \
    X(most_boxes)         /* most boxes that one tick visited */

struct haptable_counters {
#define HAPTABLE_COUNTER_FIELD(name) uint32_t name;
    HAPTABLE_COUNTERS(HAPTABLE_COUNTER_FIELD)
#undef HAPTABLE_COUNTER_FIELD
};

/* A finger in a tick. */
struct haptable_input {
    float finger_m[3]; /* world coordinates; not trusted */
    uint32_t buttons;  /* held down: bits of enum haptable_button */
    uint8_t is_there;  /* 0: it has no position in this tick, and no contact */
};

/* What one tick gives. */
struct haptable_output {
    uint8_t state;             /* enum haptable_state */
    uint8_t faults;            /* enum haptable_fault; 0 but in HAPTABLE_FAULTED, HAPTABLE_SILENT */
    uint16_t patch;            /* HAPTABLE_NONE without contact */
    uint16_t vertex[3];        /* of that patch, or of a dent that recovers; HAPTABLE_NONE without either */
    float alpha[3];            /* 0 without either */
    float god_object_m[3];     /* the finger itself without contact; 0 when it was rejected */
    float nodal_force_n[3][3]; /* F_i on vertex[i] (eq. 10), not clamped: the load of the drawn deformation; where the
                                  body relaxes, that by which it would be so deformed at once; where its
                                  dents stiffen, that of the linear body */
    float force_n[3];          /* what the user feels (eq. 12), |force_n| <= max_force_n */
};

/* A tool of many points in a tick ([tool] in the scene). haptable_step takes &in.hand and &out.hand. */
struct haptable_tool_input {
    struct haptable_input hand; /* finger_m: where the handle is */
    float turn[4];              /* unit quaternion w x y z from the tool's axes to the world's; not trusted */
};

struct haptable_tool_output {
    struct haptable_output hand; /* force_n; else the contact of the point that presses most */
    float torque_n_m[3];         /* about the handle: what the user feels, |torque_n_m| <= max_torque_n_m */
    float position_m[3];         /* where the tool is drawn: at the hand, or as its virtual coupling has it */
    float turn[4];
};

/* What codegen writes; haptable_scene.h, haptable_deformation.h say what is in it. */
struct haptable_scene;
struct haptable_deformation;

/* Where a body is that nothing holds, and how it moves. */
struct haptable_body_pose {
    float position_m[3];
    float turn[4];
    float velocity_m_per_s[3];
    float spin_rad_per_s[3];
    uint8_t on_floor;
};

#ifdef __cplusplus
}
#endif

#endif
