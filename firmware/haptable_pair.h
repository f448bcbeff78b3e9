/* SPDX-License-Identifier: MIT
 *
 * [C_11 C_12; C_21 C_22] f = u,   F = -f,   C_cd = sum_ab w_a(g_c) w_b(g_d) L_ab
 *
 * Two fingers on one body: each feels the dent that the other makes. Two servos on one model, and a table of what
 * couples two places of its surface. An entry of its own: where no program calls it, nothing of it is linked.
 *
 * Positions, forces and outputs are in the body's frame, as those of haptable_servo_step.
 */
#ifndef HAPTABLE_PAIR_H
#define HAPTABLE_PAIR_H

#include "haptable_law.h"
#include "haptable_model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tables and firmware trust each other only through this number, beside HAPTABLE_TABLE_VERSION. */
#define HAPTABLE_PAIR_VERSION 5

/* Of the coupling in clusters: places of one, the most vectors of its basis, the most places that a patch loads. */
#define HAPTABLE_PAIR_CLUSTER 8
#define HAPTABLE_PAIR_RANK 12
#define HAPTABLE_PAIR_PLACES 48

/* Pairs of so many places' clusters, a cluster with itself and each two once. */
#define HAPTABLE_PAIR_CLUSTERS(places) (((places) + HAPTABLE_PAIR_CLUSTER - 1) / HAPTABLE_PAIR_CLUSTER)
#define HAPTABLE_PAIR_CORES(places) (HAPTABLE_PAIR_CLUSTERS(places) * (HAPTABLE_PAIR_CLUSTERS(places) + 1) / 2)

/* How a core is kept, beside its rank: as the blocks of its places, in 8 bits or in 16. */
#define HAPTABLE_PAIR_DENSE 254
#define HAPTABLE_PAIR_FINE 255

/* Evaluations of both fingers' energy at once, in a tick that tries to settle them together: at its begin and, where
 * that fails, once more at its end. */
#define HAPTABLE_PAIR_EVALUATIONS 6

/* Ticks in a row of both that go by one curvature of their energy, the one that took it among them. */
#define HAPTABLE_PAIR_REUSED 8

/* Of the coupling in clusters: so often a tick that settles both together reads the blocks of two other patches. */
#define HAPTABLE_PAIR_READS 1

/* Looks of a tick from a place at another patch of its edge or vertex. */
#define HAPTABLE_PAIR_LOOKS 28

/* By so much the coupling of two fingers is less where they meet; it fades in from meeting_m apart. What is left keeps
 * C positive definite by an eighth of C_11 and C_22. */
#define HAPTABLE_PAIR_MEETING 0.125f

/* How much of its patch's controls a place loads. */
struct haptable_pair_place {
    uint16_t patch;
    float weight[HAPTABLE_PAIR_CONTROLS]; /* sum 1 */
};

struct haptable_pair;
struct haptable_pair_model;
struct haptable_pair_view;

/* What couples the controls of a patch, row by row, to the other finger's place: x[k] = sum_l w_l C_kl. */
typedef void haptable_pair_cross_fn(const struct haptable_pair_view* view, uint16_t patch, float (*x)[9]);

/* The blocks C_kl of all pairs of the controls of two patches, row by row. */
typedef void haptable_pair_blocks_fn(const struct haptable_pair_model* tables, uint16_t first, uint16_t second,
                                     float (*block)[9]);

/* X = sum_kl w_k w_l C_kl of two places, row by row. */
typedef void haptable_pair_couple_fn(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                     const struct haptable_pair_place* second, float x[9]);

/* v . X w by the controls of two places: of the first q_k = v . sum_l w_l C_kl w, of the second r_l. */
typedef void haptable_pair_pull_fn(const struct haptable_pair_model* tables, const struct haptable_pair_place* first,
                                   const struct haptable_pair_place* second, const float v[3], const float w[3],
                                   float q[HAPTABLE_PAIR_CONTROLS], float r[HAPTABLE_PAIR_CONTROLS]);

/* Both god-objects of a tick at once, where they rest together; 0 where they do not, and then nothing was moved: where
 * they rest but the one gives no force, pair->touches says so. is_late: 1 where each has moved in this tick already,
 * and looked at its finger: they rest only where both surely press. */
typedef int haptable_pair_settle_fn(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                                    const float* const finger_m[HAPTABLE_FINGERS], int is_late);

/* Rows of tables. */
typedef float haptable_float9[9];
typedef int16_t haptable_step3[3];
typedef int16_t haptable_step6[6];
typedef int16_t haptable_step9[9];

/* What tables hold: one list as a model's, for the struct, its C text, its CRC and the file that port/measure_pair.c
 * reads. Either block; or the others: places in clusters of HAPTABLE_PAIR_CLUSTER in their order, and for each two
 * clusters I >= J a core at core_begin. Of a rank r: [r,r], C_kl = s_k s_l step sum_ab U_ka core_ab U_lb^T; dense:
 * [8,8,9], C_kl = s_k s_l step core_kl; fine: the same at fine, [8,8], from its row core_begin on. */
#define HAPTABLE_PAIR_FIELDS(VALUE, TABLE)                                                                           \
    VALUE(float, meeting_m)        /* fingers nearer than this meet, > 0 */                                          \
    VALUE(uint16_t, control_count) /* n: free vertices; or vertices, then edges */                                   \
    VALUE(uint16_t, place_count)   /* m; 0: every pair of controls has its block */                                  \
    VALUE(uint16_t, load_count)    /* patches of which each says what it loads; 0: places are controls */            \
    VALUE(uint16_t, rank)          /* r <= HAPTABLE_PAIR_RANK: vectors of each place */                              \
    VALUE(uint16_t, finger_count)  /* 2; or 3 to HAPTABLE_HANDS, each a point; of a tool 1 */                        \
    VALUE(uint32_t, fine_count)    /* blocks in 16 bits */                                                           \
    TABLE(haptable_float9, block, place_count ? 0 : control_count*(control_count + 1) / 2) /* C_kl, k >= l, by k */  \
    TABLE(float, scale, place_count)                                                       /* s */                   \
    TABLE(haptable_step3, basis, place_count* rank) /* U, in 1/32767; step has its square */                         \
    TABLE(uint32_t, core_begin, place_count ? HAPTABLE_PAIR_CORES(place_count) + 1 : 0) /* the last: of all cores */ \
    TABLE(float, core_step, HAPTABLE_PAIR_CORES(place_count))                                                        \
    TABLE(uint8_t, core_form, HAPTABLE_PAIR_CORES(place_count)) /* rank, 0: nothing; or HAPTABLE_PAIR_DENSE, FINE */ \
    TABLE(int8_t, core, core_begin ? core_begin[HAPTABLE_PAIR_CORES(place_count)] : 0)                               \
    TABLE(haptable_step9, fine, fine_count)                                                                          \
    TABLE(uint16_t, place, place_count && !load_count ? control_count : 0)     /* of each control */                 \
    TABLE(uint32_t, load_begin, load_count ? load_count + 1 : 0)               /* of each patch */                   \
    TABLE(uint16_t, load_place, load_begin ? load_begin[load_count] : 0)       /* ascending in a patch */            \
    TABLE(haptable_step6, load_share, load_begin ? load_begin[load_count] : 0) /* of its controls, in 1/32767 */     \
    VALUE(uint32_t, crc) /* for check: of all other values and tables, haptable_crc_of */

#define HAPTABLE_PAIR_VALUE(type, name) type name;
#define HAPTABLE_PAIR_TABLE(type, name, count) const type* name;

/* The coupling of one object, beside its model; const, so that it stays in flash. */
struct haptable_pair_model {
    const struct haptable_model* model;
    const struct haptable_pair_law* law;
    const struct haptable_pair_bend* bend; /* for god_object_least_energy; else NULL */
    haptable_energy_fn* energy;            /* the same */
    haptable_pair_settle_fn* settle;       /* the same, without friction */
    haptable_pair_cross_fn* cross;         /* one of those below, by place_count */
    haptable_pair_blocks_fn* blocks;       /* the same */
    haptable_span_fn* span;                /* for a model's check */
    HAPTABLE_PAIR_FIELDS(HAPTABLE_PAIR_VALUE, HAPTABLE_PAIR_TABLE)
};
#undef HAPTABLE_PAIR_VALUE
#undef HAPTABLE_PAIR_TABLE

/* Every pair is a block. cost: controls squared blocks. */
haptable_pair_cross_fn haptable_pair_cross_exact;
haptable_pair_blocks_fn haptable_pair_blocks_exact;
haptable_pair_couple_fn haptable_pair_couple_exact;
haptable_pair_pull_fn haptable_pair_pull_exact;

/* Pairs of clusters of places. cost: for each two clusters that the patches load a core of the rank squared, or a
 * block for each two places; blocks: controls times that. */
haptable_pair_cross_fn haptable_pair_cross_clusters;
haptable_pair_blocks_fn haptable_pair_blocks_clusters;
haptable_pair_couple_fn haptable_pair_couple_clusters;
haptable_pair_pull_fn haptable_pair_pull_clusters;

haptable_energy_fn haptable_pair_energy;
haptable_pair_settle_fn haptable_pair_settle;
haptable_span_fn haptable_span_of_pair; /* of a struct haptable_pair_model: HAPTABLE_PAIR_FIELDS */

/* What couples the controls of two patches: while the fingers stay on them it is read once. */
struct haptable_pair_net {
    uint16_t patch[HAPTABLE_FINGERS]; /* which was asked for last; first one HAPTABLE_NONE: none */
    uint8_t is_read;                  /* 0: in clusters, one answer took a row of blocks, as the fingers may go on */
    uint8_t reads;                    /* of the tick's settling: at most HAPTABLE_PAIR_READS */
    float block[HAPTABLE_PAIR_CONTROLS * HAPTABLE_PAIR_CONTROLS][9];
};

/* What couples the controls of a patch to the other finger's place, while that stays there. */
struct haptable_pair_rows {
    uint16_t patch; /* HAPTABLE_NONE: none */
    float x[HAPTABLE_PAIR_CONTROLS][9];
};

/* What a finger is told of the other in a tick. The model comes first: functions that a model names get it. */
struct haptable_pair_view {
    struct haptable_model model; /* of the tables, with the force and the energy that the other changes */
    const struct haptable_pair_model* tables;
    uint8_t is_coupled; /* 0: alone */
    uint8_t is_solved;  /* 1: v is the pair's */
    struct haptable_pair_place place;
    float at_m[3];                     /* the other's god-object */
    float m[6];                        /* its A^-1 */
    float s[3];                        /* its s */
    float alone[3];                    /* its A^-1 s */
    float share;                       /* of what couples the two: 1, or less where the last energy was not definite */
    float v[3];                        /* this finger's, where is_solved */
    uint8_t is_new;                    /* 1: its contact began in the last tick */
    uint8_t left_ticks;                /* that the other left it behind, up to 2 */
    uint32_t met;                      /* contacts of its servo, as raised_m is of the last */
    float raised_m[3];                 /* of its contact: the surface is as far outwards as the other had it then */
    float brake_n_per_m;               /* with passivity: what takes back what was given, of the tick's motion */
    struct haptable_pair_rows rows[2]; /* of the patch that was asked for last, and of another one */
};

/* How a minimum of both goes with the fingers: by alpha_1 and alpha_2 of the first, then of the second. */
struct haptable_pair_follow {
    uint16_t patch[HAPTABLE_FINGERS];    /* of which this is known */
    uint8_t free[HAPTABLE_FINGERS];      /* coordinates by which each may move: 2 within a patch, 1 along an edge, 0 */
    float curvature_j[4][4];             /* factored */
    float slope[4][HAPTABLE_FINGERS][3]; /* of v by a coordinate */
    float a[HAPTABLE_FINGERS][6];        /* of a stiffness: A */
    float a_v[4][3];                     /* of a stiffness: A_p v of the coordinate's own finger */
};

/* The state of two fingers on one body. The caller owns it; haptable_pair_init makes it valid. */
struct haptable_pair {
    struct haptable_servo servo[HAPTABLE_FINGERS];
    struct haptable_pair_view view[HAPTABLE_FINGERS];
    struct haptable_pair_net net;
    struct haptable_pair_follow follow;
    uint8_t is_following; /* ticks that both rested together by one curvature, the last among them; 0: not */
    uint8_t evaluations;  /* of both fingers' energy at once, in the last tick: at most HAPTABLE_PAIR_EVALUATIONS */
    uint16_t looks;       /* of the last tick: at most HAPTABLE_PAIR_LOOKS */
    uint8_t touches[HAPTABLE_FINGERS]; /* 0: no contact, or the other's dent leaves it behind: it gives no force */
    float energy_j;                    /* stored by both, of the last tick */
    float given_j;                     /* with passivity: energy given to both hands, less what was taken */
};

/* Two servos without a contact. */
void haptable_pair_init(const struct haptable_pair_model* tables, struct haptable_pair* pair);

/* One tick of both fingers at once: positions in, forces out. cost: each finger's own tick and twice the coupling of
 * two patches; with least energy, friction: the coupling of two patches beside every energy, every force. */
void haptable_pair_step(const struct haptable_pair_model* tables, struct haptable_pair* pair, const float first_m[3],
                        const float second_m[3], uint32_t now_us, struct haptable_output out[HAPTABLE_FINGERS]);

/* One tick of one finger, the other being not there: as in a scene with one, but where that had raised the surface. */
void haptable_pair_step_one(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                            const float finger_m[3], uint32_t now_us, struct haptable_output* out);

#ifdef __cplusplus
}
#endif

#endif
