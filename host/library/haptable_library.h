/* SPDX-License-Identifier: MIT
 *
 * libhaptable: the folder of a scene, loaded and touched at run time: the servo of haptable without code generation.
 *
 *   object   the tables that haptable-precompute wrote: read once, then const; any number of fingers may touch it
 *   finger   one servo on an object, with a state of its own: one thread at a time
 *   fingers  two to eight of them that feel one another's dents, of a scene with [contact] fingers
 *   held     a rigid tool of many points that one hand holds, of a scene with [tool]
 *   touch    what one tick gives: force, nodes, god-object
 *   pose     where a body is that nothing holds ([body] free = true): each servo has one of its own, which its fingers
 *            push, turn and lift
 *   swung    how far the modes of a body have, that rings ([body] modes): each servo has its own likewise
 *
 * The servo is the firmware's, compiled into the library: the same positions at the same times give the same bits as
 * build/NAME/servo. SI units: metres, newtons, joules, microseconds; indices 0-based; nodes are mesh nodes.
 *
 * A function that may fail returns NULL or -1, and haptable_library_error tells the calling thread why. One that is
 * given NULL for what it needs does nothing, returns NULL, -1 or zeros, and says so there. */
#ifndef HAPTABLE_LIBRARY_H
#define HAPTABLE_LIBRARY_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of this header. haptable_library_version() of a library that can be used is the same; the number changes
 * with the library's soname. */
#define HAPTABLE_LIBRARY_VERSION 2

#define HAPTABLE_LIBRARY_API __attribute__((visibility("default")))

struct haptable_object;
struct haptable_finger;
struct haptable_fingers;
struct haptable_held;

enum haptable_touch_state {
    HAPTABLE_TOUCH_SILENT = 0,   /* no position yet, or none for 20 ms: zero force */
    HAPTABLE_TOUCH_FREE = 1,     /* outside: zero force */
    HAPTABLE_TOUCH_CONTACT = 2,  /* the god-object is on the surface */
    HAPTABLE_TOUCH_REJECTED = 3, /* the position is none, or is not believed: zero force */
    HAPTABLE_TOUCH_LIMITED = 4,  /* contact, with less force than the body's */
    HAPTABLE_TOUCH_FAULTED = 5   /* a fault waits to be acknowledged: zero force */
};

/* Bits of haptable_finger_buttons. */
enum haptable_touch_button {
    HAPTABLE_TOUCH_GRAB = 2,       /* the contact holds the finger, where the scene has [contact] grab */
    HAPTABLE_TOUCH_ACKNOWLEDGE = 4 /* a fault that waits for the user is over */
};

/* What one tick gives: 92 bytes without padding. */
struct haptable_touch {
    uint32_t state;            /* enum haptable_touch_state */
    uint32_t faults;           /* bits: 1 tables, 2 force, 4 positions */
    int32_t node[3];           /* of the patch that the god-object is on, or of a dent that recovers (a body that
                                  relaxes, the finger gone); -1 without either */
    float alpha[3];            /* area coordinates there; 0 without either */
    float god_object_m[3];     /* the finger itself without contact; 0 where it was rejected */
    float force_n[3];          /* what the user feels (eq. 12), at most the scene's max_force */
    float nodal_force_n[3][3]; /* on node[0 .. 2] (eq. 10), not cut: what deforms the body */
};

/* J. */
struct haptable_touch_energy {
    double stored_j;      /* in the body now: 1/2 u . f */
    double most_stored_j; /* the largest of it so far */
    double given_j;       /* to the user so far, less what was taken */
    double most_given_j;  /* the largest of it so far */
};

/* Where a body is in the last tick: a point x of it at rest is at centre_m + turn (x - rest_centre_m) turn*. */
struct haptable_pose {
    float rest_centre_m[3]; /* of mass, at rest: 0 of a body that is held, as all but turn[0] = 1 */
    float centre_m[3];
    float turn[4]; /* a quaternion of length 1: w x y z */
    float velocity_m_per_s[3];
    float spin_rad_per_s[3]; /* body axes */
    uint32_t on_floor;       /* bits: points of the body that the floor carries */
};

/* What an object is. The arrays are the object's, and live as long as it does. */
struct haptable_object_facts {
    const char* name;        /* of the scene */
    uint64_t tables_hash;    /* of tables.json: messages and logs carry it */
    float max_force_n;       /* where the servo cuts */
    float stiffness_n_per_m; /* the largest of any point, as felt */
    uint32_t node_count;     /* mesh nodes */
    uint32_t surface_count;  /* patches of the surface */
    uint32_t patch_count;    /* of these, touchable ones */
    uint32_t row_count;      /* mesh nodes whose displacement is kept; 0: columns = "none" */
    const double (*rest_m)[3];
    const int32_t (*surface)[3]; /* mesh nodes, counter-clockwise from outside */
    const int32_t (*patch)[3];   /* the touchable ones */
    const int32_t* row_node;     /* mesh node of each row, ascending */
};

HAPTABLE_LIBRARY_API uint32_t haptable_library_version(void);

/* One line: why the last call of this thread that failed did. "" where none has. */
HAPTABLE_LIBRARY_API const char* haptable_library_error(void);

/* Reads a folder that haptable-precompute wrote. Every file is checked by its hash in tables.json, and the servo's
 * tables, built again, by their tables_hash. tables_hash: those that are wanted; 0: whichever. NULL where it fails. */
HAPTABLE_LIBRARY_API struct haptable_object* haptable_object_load(const char* folder, uint64_t tables_hash);

/* What a servo takes from its scene, and may take otherwise without other tables. */
struct haptable_object_options {
    const char* precision;  /* how blocks are stored: "float32", "float16" or "int16"; NULL: as the scene says */
    const char* god_object; /* "nearest" or "least-energy"; NULL: as the scene says */
    int is_bare;            /* 1: the body's own force: no limit, no max_force, no release */
};

/* The same as haptable_object_load of such a scene: its tables_hash is another. For comparisons: a device has the
 * scene's. */
HAPTABLE_LIBRARY_API struct haptable_object* haptable_object_load_as(const char* folder,
                                                                     const struct haptable_object_options* options);

/* Fingers on it keep it as long as they need it. NULL is allowed. */
HAPTABLE_LIBRARY_API void haptable_object_free(struct haptable_object* object);

HAPTABLE_LIBRARY_API struct haptable_object_facts haptable_object_describe(const struct haptable_object* object);

/* Displacements under the load of a touch (equation 8), m: of the rows row[0 .. count - 1], or, where row is NULL, of
 * all, count being row_count. Zero without contact or dent. Float32; any number of threads. -1 where there are no
 * columns or a number is wrong; then nothing is written. cost: 3 loads (a mask: its nodes) of 18 flops a row. */
HAPTABLE_LIBRARY_API int haptable_object_deform(const struct haptable_object* object,
                                                const struct haptable_touch* touch, const uint32_t* row, size_t count,
                                                float (*displacement_m)[3]);

/* By how many modes it rings; 0: it follows at once. */
HAPTABLE_LIBRARY_API uint32_t haptable_object_modes(const struct haptable_object* object);

/* Adds to displacements, as haptable_object_deform gave them, how far the modes have moved the rows: sum phi q, m.
 * swung: [modes] of the tick. -1 as there; then nothing is added. */
HAPTABLE_LIBRARY_API int haptable_object_swing(const struct haptable_object* object, const float* swung,
                                               const uint32_t* row, size_t count, float (*displacement_m)[3]);

/* 1: nothing holds it, and it moves with every tick. Then positions are in world coordinates, force_n is along world
 * axes, and all else of a touch, and displacements, are in the body's frame: that of the tick's pose. */
HAPTABLE_LIBRARY_API int haptable_object_is_free(const struct haptable_object* object);

/* A servo without contact, its tables checked. NULL where it fails. */
HAPTABLE_LIBRARY_API struct haptable_finger* haptable_finger_new(const struct haptable_object* object);
HAPTABLE_LIBRARY_API void haptable_finger_free(struct haptable_finger* finger);

/* One tick, to be called every millisecond: a position in, a force out. now_us may wrap. Cannot fail: what is wrong
 * with a position is in touch->state and in the counters. */
HAPTABLE_LIBRARY_API void haptable_finger_step(struct haptable_finger* finger, const float position_m[3],
                                               uint32_t now_us, struct haptable_touch* touch);

/* Where no position came: 1, and zero force, when that lasts for 20 ms; 0 while it is in time, touch untouched. */
HAPTABLE_LIBRARY_API int haptable_finger_watch(struct haptable_finger* finger, uint32_t now_us,
                                               struct haptable_touch* touch);

/* Held down from the next tick on: bits of enum haptable_touch_button. */
HAPTABLE_LIBRARY_API void haptable_finger_buttons(struct haptable_finger* finger, uint32_t buttons);

/* `count` ticks, one a millisecond from begin_us on: as many calls of haptable_finger_step. */
HAPTABLE_LIBRARY_API void haptable_finger_replay(struct haptable_finger* finger, const float (*position_m)[3],
                                                 size_t count, uint32_t begin_us, struct haptable_touch* touch);

HAPTABLE_LIBRARY_API struct haptable_touch_energy haptable_finger_energy(const struct haptable_finger* finger);
HAPTABLE_LIBRARY_API struct haptable_pose haptable_finger_pose(const struct haptable_finger* finger);

/* How far each mode has swung by the end of the last tick: swung[haptable_object_modes], sqrt(kg) m. Of a body that
 * rings nodal_force_n loads what is left of its compliance, and the modes move it besides (haptable_object_swing). */
HAPTABLE_LIBRARY_API void haptable_finger_swung(const struct haptable_finger* finger, float* swung);

/* ---- fingers -------------------------------------------------------------------------------------------------- */

/* Fingers of the object's scene: 1 to 8. */
HAPTABLE_LIBRARY_API uint32_t haptable_object_fingers(const struct haptable_object* object);

/* A servo for all of them without contact, its tables checked. NULL where it fails, or the scene has one finger. */
HAPTABLE_LIBRARY_API struct haptable_fingers* haptable_fingers_new(const struct haptable_object* object);
HAPTABLE_LIBRARY_API void haptable_fingers_free(struct haptable_fingers* fingers);

/* One tick of all, as haptable_finger_step. position_m, touch: of each finger; one whose position is NULL is away: it
 * lets go, and one that is left alone feels what a haptable_finger does; with all away a free body rests where it is.
 * The load is that of all touches: haptable_object_deform of each, added. */
HAPTABLE_LIBRARY_API void haptable_fingers_step(struct haptable_fingers* fingers, const float* const position_m[],
                                                uint32_t now_us, struct haptable_touch touch[]);

/* As haptable_finger_buttons, of a finger, 0 the first. */
HAPTABLE_LIBRARY_API void haptable_fingers_buttons(struct haptable_fingers* fingers, uint32_t finger, uint32_t buttons);

/* `count` ticks, one a millisecond from begin_us on: as many calls of haptable_fingers_step. position_m, touch: of each
 * finger of the first tick, then of each of the second, count times as many as the scene has fingers. */
HAPTABLE_LIBRARY_API void haptable_fingers_replay(struct haptable_fingers* fingers, const float (*position_m)[3],
                                                  size_t count, uint32_t begin_us, struct haptable_touch touch[]);

HAPTABLE_LIBRARY_API struct haptable_touch_energy haptable_fingers_energy(const struct haptable_fingers* fingers,
                                                                          uint32_t finger);
HAPTABLE_LIBRARY_API void haptable_fingers_swung(const struct haptable_fingers* fingers, float* swung);
HAPTABLE_LIBRARY_API struct haptable_pose haptable_fingers_pose(const struct haptable_fingers* fingers);
HAPTABLE_LIBRARY_API uint32_t haptable_fingers_counter(const struct haptable_fingers* fingers, uint32_t finger,
                                                       uint32_t counter);

/* ---- a tool --------------------------------------------------------------------------------------------------- */

/* What one tick gives of a tool: 132 bytes without padding. */
struct haptable_wrench {
    struct haptable_touch hand; /* force_n on the hand; the contact is that of the point that presses most */
    float torque_n_m[3];        /* on the hand about the handle, world axes, at most the tool's max_torque */
    float position_m[3];        /* of the handle, where the tool is: the hand's, or behind a virtual coupling */
    float turn[4];              /* w x y z, from the tool's axes there to the world's */
};

/* Points of the tool of the object's scene; 0: it has none. */
HAPTABLE_LIBRARY_API uint32_t haptable_object_points(const struct haptable_object* object);

/* Their places about the handle, in the tool's axes: point_m[haptable_object_points]. */
HAPTABLE_LIBRARY_API void haptable_object_tool(const struct haptable_object* object, float (*point_m)[3]);

/* A servo of the tool without contact, its tables checked. NULL where it fails, or the scene has none. */
HAPTABLE_LIBRARY_API struct haptable_held* haptable_held_new(const struct haptable_object* object);
HAPTABLE_LIBRARY_API void haptable_held_free(struct haptable_held* held);

/* One tick, as haptable_finger_step: the handle's position and the tool's orientation in, w x y z of length 1 to 1e-3
 * (else the tick is rejected). The load is that of all points: haptable_object_deform of each, added. */
HAPTABLE_LIBRARY_API void haptable_held_step(struct haptable_held* held, const float position_m[3], const float turn[4],
                                             uint32_t now_us, struct haptable_wrench* wrench);

/* `count` ticks, one a millisecond from begin_us on: as many calls of haptable_held_step. */
HAPTABLE_LIBRARY_API void haptable_held_replay(struct haptable_held* held, const float (*position_m)[3],
                                               const float (*turn)[4], size_t count, uint32_t begin_us,
                                               struct haptable_wrench* wrench);

/* Contact of a point in the last tick, 0 .. haptable_object_points() - 1. -1 beyond. */
HAPTABLE_LIBRARY_API int haptable_held_point(const struct haptable_held* held, uint32_t point,
                                             struct haptable_touch* touch);

/* As haptable_finger_buttons and haptable_finger_counter. */
HAPTABLE_LIBRARY_API void haptable_held_buttons(struct haptable_held* held, uint32_t buttons);
HAPTABLE_LIBRARY_API uint32_t haptable_held_counter(const struct haptable_held* held, uint32_t counter);

/* What a servo counts, by number: 0 .. haptable_library_counters() - 1. NULL beyond. */
HAPTABLE_LIBRARY_API uint32_t haptable_library_counters(void);
HAPTABLE_LIBRARY_API const char* haptable_library_counter_name(uint32_t counter);
HAPTABLE_LIBRARY_API uint32_t haptable_finger_counter(const struct haptable_finger* finger, uint32_t counter);

#ifdef __cplusplus
}
#endif

#endif
