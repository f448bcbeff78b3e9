/* SPDX-License-Identifier: MIT
 *
 *   q'' + 2 zeta omega q' + omega^2 q = phi^T f,   u = L_rest f + sum phi q,   L_rest = L - sum phi phi^T / omega^2
 *
 * A body that rings: its lowest modes have a motion of their own, what is left of its compliance gives way at once. The
 * model's tables are those of L_rest, and the finger is felt against the surface as the modes have moved it: a force
 * that is held comes to that of L. docs/MODES.md has what it keeps.
 *
 * Tables are const (struct haptable_modes, written by codegen), state is one struct that the caller owns. Not trusted:
 * what the finger does.
 */
#ifndef HAPTABLE_MODES_H
#define HAPTABLE_MODES_H

#include "haptable.h"

#ifdef __cplusplus
extern "C" {
#endif

#define HAPTABLE_MODES_VERSION 1

/* The most modes, and the most controls of a patch: its vertices, and under a mask the edges opposite to them. */
#define HAPTABLE_MODES 16
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

struct haptable_modes {
    const struct haptable_model* model; /* without the modes */
    uint8_t count;                      /* <= HAPTABLE_MODES */
    uint8_t controls;                   /* of a patch: 3, or 6 under a mask */
    const struct haptable_mode* mode;   /* [count] */
    const float (*shape)[3];            /* phi of control c and mode k at c count + k, 1/sqrt(kg) */
};

/* How far the modes have swung. */
struct haptable_swings {
    float q[HAPTABLE_MODES]; /* sqrt(kg) m */
    float p[HAPTABLE_MODES]; /* and a second */
    float q_low[HAPTABLE_MODES];
    float p_low[HAPTABLE_MODES]; /* of the sums above, what float32 did not hold (Kahan) */
};

/* A finger as the modes met it in the last tick. */
struct haptable_met {
    float finger_m[3]; /* last position */
    float load_n[3];   /* on the body since then */
    float shift_m[3];  /* of the surface, by which the finger is felt: that of the modes at: */
    float alpha[3];
    uint16_t patch; /* of the last contact; HAPTABLE_NONE: there was none */
};

/* What one finger leaves of a body that rings. The caller owns it; haptable_modes_init makes it valid. */
struct haptable_modes_state {
    struct haptable_swings swings;
    struct haptable_met met;
    float stored_j; /* in the modes and in the contact, then; and what the shift may cost the contact next */
};

void haptable_modes_init(struct haptable_modes_state* state);

/* One tick: as haptable_step, on a body that rings. out->god_object_m and the nodal forces are those of the rest shape;
 * what is drawn is L_rest of these forces and sum phi q. Bounded work: haptable_step, three energies or forces more,
 * and HAPTABLE_MODES (6 x 3 + 60) multiplications. */
void haptable_modes_step(const struct haptable_modes* modes, struct haptable_modes_state* state,
                         struct haptable_servo* servo, const float finger_m[3], uint32_t now_us,
                         struct haptable_output* out);

/* J, of the modes alone. */
float haptable_modes_energy(const struct haptable_modes* modes, const struct haptable_swings* swings);

#ifdef __cplusplus
}
#endif

#endif
