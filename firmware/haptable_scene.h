/* SPDX-License-Identifier: MIT
 *
 * scene = surface and force law + { a second finger } + { a rigid motion } + { vibration modes }
 *
 * One step for every scene: what a scene does not name is NULL, is not linked and has no state. Contacts are rows,
 * three a finger; what moves under them (the rigid motion, the modes) knows neither how many fingers there are nor what
 * else moves. haptable_moving.h has the tick of a body that moves.
 *
 * The scene is const (codegen writes it); the state is of the size that the scene says.
 */
#ifndef HAPTABLE_SCENE_H
#define HAPTABLE_SCENE_H

#include <stddef.h>

#include "haptable_body.h"
#include "haptable_model.h"
#include "haptable_modes.h"
#include "haptable_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Everything that moves under the contacts: also what the host's bounds, strokes and pages go by. */
#define HAPTABLE_MOVERS(X) HAPTABLE_RIGID_MOVERS(X) HAPTABLE_SURFACE_MOVERS(X)

/* A finger at the end of a moving body's last tick, in body coordinates but for hand_m. */
struct haptable_past {
    float hand_m[3]; /* world coordinates */
    float finger_m[3];
    float load_n[3];  /* on the body since then: the force on the hand with its sign turned */
    uint8_t is_known; /* 0: no finger in that tick */
};

/* Energy balance of contacts and modes. */
struct haptable_account {
    float stored_j; /* in contacts and modes */
    float
        owed_j; /* > 0: generated and not yet paid by the hands, so forces are reduced; < 0: paid by them in advance */
    struct haptable_past past[HAPTABLE_FINGERS];
};

struct haptable_scene;

/* One tick of all contacts. x_m: finger positions in body coordinates, less the displacement of the modes. */
typedef void haptable_contacts_fn(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                                  const float x_m[][3], uint32_t now_us, struct haptable_output out[]);

/* One tick of the scene, as haptable_step: contacts alone, or with a moving body. */
typedef void haptable_step_fn(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                              uint32_t now_us, struct haptable_output out[]);

/* Initialises the fingers: no known position. */
typedef void haptable_init_fn(const struct haptable_scene* scene, void* state);

/* Writes the contacts' compliance, m/N, under the forces that were output to the lower half of a[][]: three rows a
 * finger, the identity for a finger that does not press. Returns a bit for each finger that presses. */
typedef unsigned haptable_rows_fn(const struct haptable_scene* scene, void* state, const struct haptable_past past[],
                                  float (*a)[HAPTABLE_ROWS]);

/* Tables of one part of a scene, for the CRC check. */
struct haptable_part {
    const void* tables; /* NULL: the scene has none */
    haptable_span_fn* span;
    uint32_t crc;
};

/* Parts beside the model: 1 coupling of two fingers, 2 rigid body, 3 modes. */
typedef struct haptable_part haptable_part_fn(const struct haptable_scene* scene, uint32_t number);

struct haptable_scene {
    const struct haptable_model* model;
    const struct haptable_pair_model* pair; /* coupling of fingers; NULL: one finger */
    const struct haptable_body* body;       /* NULL: a held body */
    const struct haptable_modes* modes;     /* NULL: quasi-static */
    haptable_init_fn* init;                 /* haptable_init_one, haptable_init_two */
    haptable_contacts_fn* contacts;         /* haptable_contact_of_one, haptable_contacts_of_two */
    haptable_step_fn* step; /* haptable_step_one, of two haptable_step_held; haptable_moving, _stiffening */
    const struct haptable_rigid_part* rigid;
    const struct haptable_modes_part* ringing;
    haptable_rows_fn* rows; /* with modes: haptable_rows_of_one, haptable_rows_of_two */
    haptable_part_fn* part; /* haptable_part_of; NULL: the model has all tables */
    uint32_t bytes;         /* of the state; it begins with the fingers' servos, or the pair of them, and what the model
                               lets them remember */
    uint32_t body_at;       /* byte of struct haptable_body_state in it */
    uint32_t modes_at;      /* of struct haptable_modes_state */
    uint32_t account_at;    /* of struct haptable_account */
};

haptable_init_fn haptable_init_one;
haptable_init_fn haptable_init_two;
haptable_contacts_fn haptable_contact_of_one;
haptable_contacts_fn haptable_contacts_of_two;
haptable_rows_fn haptable_rows_of_one;
haptable_rows_fn haptable_rows_of_two;
haptable_step_fn haptable_step_one;
haptable_step_fn haptable_step_held;
haptable_step_fn haptable_moving;
haptable_step_fn haptable_moving_stiffening;
haptable_part_fn haptable_part_of;

/* Takes the fingers' presence and buttons of a tick; an absent finger is reset as after silence. */
void haptable_scene_begin(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                          uint32_t now_us, struct haptable_output out[]);

static inline int haptable_scene_fingers(const struct haptable_scene* scene) {
    return scene->pair ? scene->pair->finger_count : 1;
}

/* The servo of a finger. */
static inline struct haptable_servo* haptable_scene_servo(void* state, int finger) {
    return (struct haptable_servo*)state + finger;
}

/* before: the scene has a body; modes. */
static inline struct haptable_body_state* haptable_scene_body(const struct haptable_scene* scene, void* state) {
    return (struct haptable_body_state*)((unsigned char*)state + scene->body_at);
}
static inline struct haptable_modes_state* haptable_scene_modes(const struct haptable_scene* scene, void* state) {
    return (struct haptable_modes_state*)((unsigned char*)state + scene->modes_at);
}
static inline struct haptable_account* haptable_scene_account(const struct haptable_scene* scene, void* state) {
    return (struct haptable_account*)((unsigned char*)state + scene->account_at);
}

/* State layout of a model that was made at run time; of a generated scene codegen writes a layout of what it names. */
struct haptable_room {
    struct haptable_pair fingers;
    struct haptable_freed freed[HAPTABLE_FINGERS];
    struct haptable_relaxed relaxed[HAPTABLE_FINGERS];
};

/* Writes the offsets of that layout to the model. */
static inline void haptable_lay_out(struct haptable_model* model) {
    model->freed_at = (uint32_t)offsetof(struct haptable_room, freed);
    model->relaxed_at = (uint32_t)offsetof(struct haptable_room, relaxed);
}

/* Makes a scene of tables that are known at run time and lays out its state; pair, body, modes: NULL if it has none.
 * Links every part. before: haptable_lay_out of the model. */
void haptable_scene_make(const struct haptable_model* model, const struct haptable_pair_model* pair,
                         const struct haptable_body* body, const struct haptable_modes* modes,
                         struct haptable_scene* scene);

#ifdef __cplusplus
}
#endif

#endif
