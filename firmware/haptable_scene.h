/* SPDX-License-Identifier: MIT
 *
 * scene = surface and force law + { a second finger } + { a rigid motion } + { vibration modes }
 *
 * One step for every scene: what a scene does not name is NULL, is not linked and has no state. Contacts are rows,
 * three a finger; what moves under them (the rigid motion, the modes) knows neither how many fingers there are nor what
 * else moves. haptable_moving.c has the tick of a body that moves.
 *
 * The scene is const (codegen writes it); the state is of the size that the scene says. A board does:
 *
 *     static struct haptable_input in[HAPTABLE_MODEL_FINGERS];
 *     static struct haptable_output out[HAPTABLE_MODEL_FINGERS];
 *     static HAPTABLE_MODEL_STATE state;
 *
 *     haptable_scene_init(&HAPTABLE_MODEL_SCENE, &state);
 *     haptable_scene_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);
 *     for (;;) {                                    every millisecond:
 *         in[0].is_there = ..., in[0].finger_m = ...
 *         haptable_scene_step(&HAPTABLE_MODEL_SCENE, &state, in, now_us, out);
 *         ... = out[0].force_n;
 *     }
 */
#ifndef HAPTABLE_SCENE_H
#define HAPTABLE_SCENE_H

#include "haptable.h"
#include "haptable_body.h"
#include "haptable_modes.h"
#include "haptable_pair.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A finger in a tick. */
struct haptable_input {
    float finger_m[3]; /* world coordinates; not trusted */
    uint32_t buttons;  /* held down: bits of enum haptable_button */
    uint8_t is_there;  /* 0: it has no position in this tick, and no contact */
};

/* A finger as the last tick of a body that moves left it; body coordinates but for hand_m. */
struct haptable_past {
    float hand_m[3]; /* world coordinates */
    float finger_m[3];
    float load_n[3];  /* on the body since then: the force on the hand with its sign turned */
    uint8_t is_known; /* 0: there was none */
};

/* The energy of contacts and modes, and what they made that nothing has paid for. */
struct haptable_account {
    float stored_j; /* in contacts and modes */
    float owed_j;   /* > 0: forces are the less for it; < 0: what hands have paid and nothing has used */
    struct haptable_past past[HAPTABLE_FINGERS];
};

struct haptable_scene;

/* A tick of all contacts, x_m in body coordinates as the modes have left the surface. after: x_m less a contact's
 * god-object is its dent. */
typedef void haptable_contacts_fn(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                                  float x_m[][3], uint32_t now_us, struct haptable_output out[]);

/* A tick of the scene, as haptable_scene_step: of contacts alone, or of a body that moves under them. */
typedef void haptable_step_fn(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                              uint32_t now_us, struct haptable_output out[]);

/* Fingers that are not known. */
typedef void haptable_init_fn(const struct haptable_scene* scene, void* state);

/* The check of all tables of the scene. */
typedef void haptable_scene_check_fn(const struct haptable_scene* scene, void* state, uint32_t bytes);

/* The compliance of the contacts that there are, as the forces were given: rows and columns of a[][], its lower half,
 * and bits that say which fingers press. 1 on the diagonal of the others. */
typedef unsigned haptable_rows_fn(const struct haptable_scene* scene, void* state, const struct haptable_past past[],
                                  float (*a)[HAPTABLE_ROWS]);

struct haptable_scene {
    const struct haptable_model* model;
    const struct haptable_pair_model* pair; /* what couples two fingers; NULL: there is one */
    const struct haptable_body* body;       /* NULL: it is held */
    const struct haptable_modes* modes;     /* NULL: it follows at once */
    haptable_init_fn* init;                 /* haptable_init_one, haptable_init_two */
    haptable_contacts_fn* contacts;         /* haptable_contact_of_one, haptable_contacts_of_two */
    haptable_scene_check_fn* check;         /* haptable_check_of_one, haptable_check_of_two */
    haptable_step_fn* step;                 /* haptable_step_one, of two haptable_step_held; haptable_moving */
    const struct haptable_rigid_part* rigid;
    const struct haptable_modes_part* ringing;
    haptable_rows_fn* rows; /* with modes: haptable_rows_of_one, haptable_rows_of_two */
    uint32_t bytes;         /* of the state; it begins with the fingers' servos, or the pair of them */
    uint32_t body_at;       /* byte of struct haptable_body_state in it */
    uint32_t modes_at;      /* of struct haptable_modes_state */
    uint32_t account_at;    /* of struct haptable_account */
};

haptable_init_fn haptable_init_one;
haptable_init_fn haptable_init_two;
haptable_contacts_fn haptable_contact_of_one;
haptable_contacts_fn haptable_contacts_of_two;
haptable_scene_check_fn haptable_check_of_one;
haptable_scene_check_fn haptable_check_of_two;
haptable_rows_fn haptable_rows_of_one;
haptable_rows_fn haptable_rows_of_two;
haptable_step_fn haptable_step_one;
haptable_step_fn haptable_step_held;
haptable_step_fn haptable_moving;

/* Who is there in a tick and what is pressed; who is not is released, as after silence. */
void haptable_scene_begin(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                          uint32_t now_us, struct haptable_output out[]);

static inline int haptable_scene_fingers(const struct haptable_scene* scene) { return scene->pair ? 2 : 1; }

/* The servo of finger 0, or 1 where the scene has two. */
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

/* A scene of tables that are known at run time, and how its state is laid out; pair, body, modes: NULL where it has
 * none. It links every part. */
void haptable_scene_make(const struct haptable_model* model, const struct haptable_pair_model* pair,
                         const struct haptable_body* body, const struct haptable_modes* modes,
                         struct haptable_scene* scene);

/* Fingers that are not known, a body that rests where it was made. before: state has scene->bytes, aligned as a
 * pointer. */
void haptable_scene_init(const struct haptable_scene* scene, void* state);

/* One tick: fingers in, forces out, in world coordinates and axes; all else of out[] is in the body's frame of that
 * tick. in, out: of each finger of the scene. A gap of HAPTABLE_SILENCE_US, and a finger that is not there, drop its
 * contact. now_us may wrap. Bounded work; see SPEC.md. */
void haptable_scene_step(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                         uint32_t now_us, struct haptable_output out[]);

/* As haptable_watch, of every finger: to be called when no position has come. Returns the bits of those that are
 * silent, whose out was written. */
unsigned haptable_scene_watch(const struct haptable_scene* scene, void* state, uint32_t now_us,
                              struct haptable_output out[]);

/* As haptable_check, of every table of the scene. */
void haptable_scene_check(const struct haptable_scene* scene, void* state, uint32_t bytes);

#ifdef __cplusplus
}
#endif

#endif
