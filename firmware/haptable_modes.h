/* SPDX-License-Identifier: MIT
 *
 *   q'' + 2 zeta omega q' + omega^2 q = phi^T f,   u = L_rest f + sum phi q,   L_rest = L - sum phi phi^T / omega^2
 *
 * A body that rings: its lowest modes have a motion of their own, what is left of its compliance gives way at once. The
 * model's tables are those of L_rest, and the finger is felt against the surface as the modes have moved it: a force
 * that is held comes to that of L. docs/design/moving.md has what it keeps.
 *
 * Tables are const (struct haptable_modes, written by codegen), state is one struct that the caller owns. It is a part
 * of a tick: haptable_moving.h.
 */
#ifndef HAPTABLE_MODES_H
#define HAPTABLE_MODES_H

#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_MODES_VERSION 3

/* The most controls of a patch: its vertices, and under a mask the edges opposite to them. */
#define HAPTABLE_MODES_CONTROLS 6

/* A tick of one mode, exact for a force that is held: what q and q' change by, of q, of q' and of the force. */
struct haptable_mode {
    float q_by_q;
    float q_by_p; /* also p by the force */
    float p_by_q;
    float p_by_p;
    float q_by_f;
    float stiffness; /* omega^2: of the energy (p^2 + omega^2 q^2) / 2 */
};

/* The model's tables are those of L_rest. */
struct haptable_modes {
    uint8_t count;                    /* <= HAPTABLE_MODES */
    uint8_t controls;                 /* of a patch: 3, or 6 under a mask */
    const struct haptable_mode* mode; /* [count] */
    const float (*shape)[3];          /* phi of control c and mode k at c count + k, 1/sqrt(kg) */
    uint16_t control_count;           /* of the surface */
    uint32_t crc;                     /* for a model's check: of all other values and tables, haptable_crc_of */
};

/* The rows of a load: three a finger. */
#define HAPTABLE_ROWS (3 * HAPTABLE_FINGERS)

/* How the surface is met that the modes move, at one finger. */
struct haptable_met {
    float shift_m[3]; /* of the surface, by which the finger is felt */
    float alpha[3];
    uint16_t patch; /* of the last contact, whose place moves with the modes; HAPTABLE_NONE: there was none */
};

/* How far the modes have swung. The caller owns it. */
struct haptable_modes_state {
    float q[HAPTABLE_MODES]; /* sqrt(kg) m */
    float p[HAPTABLE_MODES]; /* and a second */
    float q_low[HAPTABLE_MODES];
    float p_low[HAPTABLE_MODES]; /* of the sums above, what float32 did not hold (Kahan) */
    struct haptable_met met[HAPTABLE_FINGERS];
};

/* What drives the modes in a tick. */
struct haptable_modes_load {
    float compliance[HAPTABLE_ROWS][HAPTABLE_ROWS]; /* C of the contacts, its lower half; changed */
    float load_n[HAPTABLE_ROWS];                    /* on the body as the hands have felt it; then that of the tick */
    float moved_m[HAPTABLE_ROWS];                   /* how far the fingers went, as C is to feel it */
    unsigned presses;                               /* bits: which of them do */
};

/* No mode has swung, and no contact was. */
void haptable_modes_init(struct haptable_modes_state* state);

/* A tick of all modes under the load; the surface goes with them at the fingers' last places. */
void haptable_modes_advance(const struct haptable_modes* modes, const struct haptable_model* model,
                            struct haptable_modes_state* state, struct haptable_modes_load* load);

/* Brings the shift of a finger to where the modes have the surface at the god-object's place. What that costs the
 * contact at the most, J, is taken from the credit; where that does not do, it goes a part of the way. Without contact
 * nothing bears on the surface, and nothing is to be paid. load_n: on the body. */
void haptable_modes_follow(const struct haptable_modes* modes, const struct haptable_model* model,
                           struct haptable_modes_state* state, int finger, const struct haptable_contact* contact,
                           const float load_n[3], float* credit_j);

/* J, of the modes alone. */
float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_modes_state* state);

/* The same as a part of a scene's tick: linked where a scene names it. */
struct haptable_modes_part {
    void (*init)(struct haptable_modes_state* state);
    void (*advance)(const struct haptable_modes* modes, const struct haptable_model* model,
                    struct haptable_modes_state* state, struct haptable_modes_load* load);
    void (*follow)(const struct haptable_modes* modes, const struct haptable_model* model,
                   struct haptable_modes_state* state, int finger, const struct haptable_contact* contact,
                   const float load_n[3], float* credit_j);
    float (*energy)(const struct haptable_modes* modes, const struct haptable_modes_state* state);
    haptable_span_fn* span;
};

/* How the surface moves in the body, as HAPTABLE_RIGID_MOVERS; EACH: of each mode. */
#define HAPTABLE_SURFACE_MOVERS(X) X(modes, "body.modes", "rings", "modes", 1500, 400, 5000, 900)

extern const struct haptable_modes_part haptable_part_modes;
haptable_span_fn haptable_span_of_modes; /* of a struct haptable_modes */

#ifdef __cplusplus
}
#endif

#endif
