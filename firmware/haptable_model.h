/* SPDX-License-Identifier: MIT
 *
 * F = -(alpha_i S_i + alpha_j S_j + alpha_k S_k) u,   u = finger - god-object,   S = (L_ii)^-1
 *
 * The servo of one finger on one closed triangle surface: Hirota and Kaneko's method. The god-object stays on the rest
 * surface and the force is read from precomputed blocks of the inverse stiffness (equations 9 to 12). A scene's step
 * (haptable_scene.h) is made of it.
 *
 * Tables are const and live in flash (struct haptable_model, written by codegen), state is one struct that the caller
 * owns (struct haptable_servo). There is no other state.
 *
 * Trusted: the model (codegen wrote it; its CRC tells whether it still is what was written). Not trusted: every
 * position and every time.
 */
#ifndef HAPTABLE_MODEL_H
#define HAPTABLE_MODEL_H

#include "haptable_types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The most steps that the slides of one tick take together: comparing one edge with the finger is a step, the nearest
 * point of a patch six. A slide that needs more stops on the surface where it is, goes on at the next tick, and is
 * counted (walk_limits). */
#define HAPTABLE_WALK_STEPS 128

/* The most patches around one vertex, so that going around it fits into a tick. Codegen refuses more. */
#define HAPTABLE_FAN_PATCHES 32

/* The most slides of one tick: an entry, and a re-entry into another part of the surface after letting go. */
#define HAPTABLE_SLIDES 3

/* The most boxes of the spatial index that the searches of one tick visit together. A search that needs more goes on at
 * the next tick where it stopped, and is counted (box_limits): it is late, but misses no entry. The generated model.h
 * says how many boxes a segment of HAPTABLE_FAST_SEGMENT_M may visit at the most. */
#define HAPTABLE_TICK_BOXES 192

/* If these limits keep the test of inside or outside unfinished for this many consecutive ticks, the contact is given
 * up and counted (given_up): its force fades to zero over HAPTABLE_FADE_TICKS, and in again if the test ends meanwhile.
 */
#define HAPTABLE_UNDECIDED_TICKS 20
#define HAPTABLE_FADE_TICKS 20

/* Displacement of a finger in a tick at 5 m/s; a hand moves no faster. */
#define HAPTABLE_FAST_SEGMENT_M 0.005f

/* The most steps of a tick of the least-energy god-object, but for the last trial's: the energy with all derivatives is
 * two, its gradient alone one. One that needs more stays where it is and goes on at the next tick. */
#define HAPTABLE_ENERGY_STEPS 14

/* Consecutive plausible positions that are required after an implausible one. */
#define HAPTABLE_GOOD_TICKS 20

/* An implausible position adds HAPTABLE_DISTRUST_TICKS to a counter, a plausible one takes 1 off; above
 * HAPTABLE_DISTRUST_LIMIT, at the fourth within a second, the sensor is faulty. */
#define HAPTABLE_DISTRUST_TICKS 300
#define HAPTABLE_DISTRUST_LIMIT 1000

/* Patches that resume tests in a tick for the one nearest to the finger. */
#define HAPTABLE_SEEK_PATCHES 8

/* Maximum number of relaxation terms. */
#define HAPTABLE_TERMS 8

/* One box of the spatial index, in grid steps from grid_origin_m. The boxes stand in depth-first order: the
 * next box of a query that meets this one is the one after it, of a query that misses it box `skip`. */
struct haptable_box {
    uint16_t low[3];
    uint16_t high[3];
    uint16_t skip;  /* first box after this one's subtree */
    uint16_t patch; /* leaf: first of its patches; inner box: HAPTABLE_NONE */
};

/* A leaf of the spatial index holds this many patches in a row; only the model's last leaf may hold fewer. */
#define HAPTABLE_LEAF 4

struct haptable_model;

/* A patch at a hinge: a vertex where more than one ring of patches meets, or where an edge of more than two patches
 * ends. All patches of such a vertex stand together, by their rings; vertices and rings ascend. */
struct haptable_hinge {
    uint16_t vertex;
    uint16_t patch;
    uint16_t ring; /* patches of one ring are reached from one another around the vertex */
};

struct fan;

/* How patches go on at a hinge and at the border of the touch region: what closed bodies without a hinge do not link.
 */
struct haptable_hinges {
    /* The fan after the last patch of a turn: turning the other way from the border, or on the next ring; without a
     * patch where all were visited. By value, so that a fan stays in registers. */
    struct fan (*turned)(const struct haptable_model* model, struct fan fan);
    /* The next of a hinge's patches that have the edge of the patch opposite to `corner`, after `last`; after all of
     * them HAPTABLE_NONE. The first comes after the neighbour. */
    uint16_t (*next_across)(const struct haptable_model* model, uint16_t patch, int corner, uint16_t last);
};

extern const struct haptable_hinges haptable_hinges_of_table;

struct haptable_seen;

/* What lies beyond patches that are too thin to tell inside from outside: what bodies without such do not link. */
struct haptable_slivers {
    /* 1 where a patch may be so thin that every point of it is next to an edge; NULL where none is. */
    int (*is_thin)(const struct haptable_model* model, uint16_t patch);
    /* What a vertex at at_m sees of the fan's patch. before: seen->end has the patch's own two. */
    void (*see)(const struct haptable_model* model, const struct fan* fan, const float at_m[3], float thin_m,
                struct haptable_seen* seen);
    /* A point of the edge opposite to `corner` of the patch, as far from its vertex as patches that are no slivers are
     * apart. */
    void (*along_edge)(const struct haptable_model* model, uint16_t patch, int corner, uint16_t vertex, float thin_m,
                       float at_m[3]);
    /* From a patch that is that thin at the point at_m of its edge between the vertices end[0] and end[1] to the one
     * beyond its other edge there, with that edge's ends. */
    void (*beyond)(const struct haptable_model* model, uint16_t* patch, uint16_t end[2], const float at_m[3],
                   float thin_m);
};

extern const struct haptable_slivers haptable_slivers_of_patches;
extern const struct haptable_slivers haptable_slivers_of_corners; /* sharp ones, of patches that are not that thin */

/* ---- what tables hold ------------------------------------------------------------------------------------------
 * One list for each struct of tables makes the struct, codegen's own, its C text, the tables' hash, and the file that
 * port/measure.c reads. Its entries:
 *   VALUE(type, name)
 *   TABLE(type, name, count)        that many rows, by the values of other fields; NULL: there is none
 *   FUNCTION(type, name, choices)   one of the list `choices`; or NULL
 *   PART(type, name)                another struct with a list; or NULL */
#define HAPTABLE_VALUE_FIELD(type, name) type name;
#define HAPTABLE_TABLE_FIELD(type, name, count) const type* name;
#define HAPTABLE_FUNCTION_FIELD(type, name, choices) type* name;
#define HAPTABLE_PART_FIELD(type, name) const type* name;

/* Rows of tables. */
typedef float haptable_float3[3];
typedef float haptable_float6[6];
typedef uint16_t haptable_index3[3];
typedef uint16_t haptable_packed6[6];

/* A field of a part's tables, by its number in the order of their list. */
struct haptable_span {
    const void* at;
    uint32_t bytes; /* 0: it is not there; HAPTABLE_SPAN_END: there is no such field */
};
#define HAPTABLE_SPAN_END 0xFFFFFFFFu

typedef struct haptable_span haptable_span_fn(const void* tables, uint32_t field);

/* The compliance of a contact, m/N, as a polynomial of the area coordinates on every patch, in Bernstein's form:
 * C(alpha) = sum over i + j + k = degree of degree! / (i! j! k!) alpha_0^i alpha_1^j alpha_2^k B_ijk.
 * Symmetric blocks: xx yy zz xy yz zx. Blocks of vertices and edges are shared, so C is continuous over the surface. */
#define HAPTABLE_COMPLIANCE_FIELDS(VALUE, TABLE)                                                                   \
    VALUE(uint16_t, edge_count)                                                                                    \
    VALUE(uint8_t, degree) /* 2: force = "consistent", 4: force = "pressure-mask" */                               \
    TABLE(haptable_float6, vertex, vertex_count)                                                                   \
    TABLE(haptable_float6, edge, (degree - 1) * edge_count) /* from an edge's lower vertex to its higher one */    \
    TABLE(haptable_float6, patch, 3 * patch_count)          /* with exponent 2 at corner 0, 1, 2; degree 4 only */ \
    TABLE(haptable_index3, patch_edge, patch_count)         /* the edge opposite to corner c */

struct haptable_compliance {
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_VALUE_FIELD, HAPTABLE_TABLE_FIELD)
    haptable_span_fn* span; /* haptable_span_of_compliance, of the model */
};

struct haptable_contact;
struct haptable_segment;
struct haptable_counters;
struct haptable_servo;

/* Moves the god-object of one tick, servo->contact, the finger having come from servo->finger_m to x_m. Without
 * contact, servo->segment.to_m is the last position up to which the finger's segment was searched, or the end of a
 * search that is not finished; segment.boxes is 0. */
typedef void haptable_god_object_fn(const struct haptable_model* model, struct haptable_servo* servo,
                                    const float x_m[3]);

/* A block that is stored in 16 bits, expanded. before: block < packed_count. */
typedef void haptable_unpack_fn(const struct haptable_model* model, uint32_t block, float s[6]);

/* The force of a contact: on the patch's vertices, and what the user feels (not clamped). */
typedef void haptable_force_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                               const float finger_m[3], float nodal_force_n[3][3], float force_n[3]);

/* Stored elastic energy of a contact and its derivatives by alpha_1 and alpha_2, with alpha_0 = 1 - alpha_1 - alpha_2,
 * at a fixed finger position. */
struct haptable_energy {
    float energy_j;              /* E = 1/2 u^T S u */
    float load_n[3];             /* S u, on the body */
    float gradient_j[2];         /* dE by alpha_1, alpha_2 */
    float hessian_j[3];          /* second derivatives 11 12 22 */
    float gauss_newton_j[3];     /* their Gauss-Newton part, positive semidefinite: 11 12 22 */
    float load_gradient_n[2][3]; /* of the load by alpha_1, alpha_2; and so of the gradient by the finger */
    float compliance_m_per_n[6]; /* with LOAD, of a force that has one: C there, as it was inverted */
};

/* Requested members. ALL: every one. GRADIENT: the gradient alone, at the same point on another patch, the load being
 * known. SLOPE: energy, load and gradient. LOAD: energy and load. For SLOPE and LOAD a function may write every one. */
enum haptable_energy_terms {
    HAPTABLE_ENERGY_ALL,
    HAPTABLE_ENERGY_GRADIENT,
    HAPTABLE_ENERGY_SLOPE,
    HAPTABLE_ENERGY_LOAD
};

typedef void haptable_energy_fn(const struct haptable_model* model, const struct haptable_contact* contact,
                                const float finger_m[3], enum haptable_energy_terms terms,
                                struct haptable_energy* energy);

/* Changes a tick's force after it was clamped to max_force_n. motion_m: displacement of the finger since the last tick.
 */
typedef void haptable_finish_fn(const struct haptable_model* model, struct haptable_servo* servo,
                                const float motion_m[3], float force_n[3]);

/* Returns 1 if a position is plausible elapsed_us after servo->finger_m; else counts it, makes it servo->finger_m and
 * returns 0. */
typedef int haptable_plausible_fn(const struct haptable_model* model, struct haptable_servo* servo,
                                  const float finger_m[3], uint32_t elapsed_us);

/* Lowers servo->gain so that the force times the gain keeps a limit. before: servo->given_n is the last tick's. */
typedef void haptable_limit_fn(const struct haptable_model* model, struct haptable_servo* servo,
                               const float force_n[3]);

struct haptable_output;

/* What a contact has that stiffens, beside the same force of one that does not. */
struct haptable_stiffened {
    float stored;  /* Psi / (e Psi'): of the energy 1/2 u . F */
    float tangent; /* 1 + 2 e Psi'' / Psi': of the stiffness along the load */
};

/* Returns Psi' of a servo's contact that stiffens, and writes what it has. */
typedef float haptable_stiffen_fn(const struct haptable_model* model, const struct haptable_servo* servo,
                                  struct haptable_stiffened* stiffened);

/* Stiffens and relaxes the contact's force, or relaxes the dent that it left: changes out. before: out holds the
 * linear elastic force, or none, not clamped. */
typedef void haptable_relax_fn(const struct haptable_model* model, struct haptable_servo* servo,
                               struct haptable_output* out);

/* Scales a tick's force by servo->gain: changes out. */
typedef void haptable_gain_fn(const struct haptable_model* model, struct haptable_servo* servo,
                              struct haptable_output* out);

struct haptable_scene;

/* Continues the CRC check of all tables of a scene; the first servo holds its progress. servo: of each finger. */
typedef void haptable_check_fn(const struct haptable_scene* scene, struct haptable_servo* servo, uint32_t bytes);

/* The tables of one object, and how it is touched. Written by codegen by field name; const, so that they stay in flash.
 * The functions that it names are linked, others are not: a mode that no table chose costs no byte. Values but the crc
 * stand together and have no gap, the largest first: the check takes them as one. */
#define HAPTABLE_MODEL_FIELDS(VALUE, TABLE, FUNCTION, PART)                                                            \
    TABLE(haptable_float3, vertex_m, vertex_count)        /* rest positions V_i */                                     \
    TABLE(haptable_float6, stiffness_n_per_m, free_count) /* S_i, xx yy zz xy yz zx, where the force reads it so */    \
    TABLE(haptable_packed6, packed, packed_count)         /* in 16 bits: numbers to be scaled */                       \
    TABLE(float, packed_scale, scale_count)               /* N/m; C: m/N */                                            \
    TABLE(haptable_index3, patch, patch_count)            /* vertices, counter-clockwise from outside */               \
    TABLE(haptable_index3, neighbour, patch_count)        /* patch across the edge opposite to corner c, or NONE */    \
    TABLE(struct haptable_box, box, box_count)                                                                         \
    TABLE(struct haptable_hinge, hinge, hinge_count)                                                                   \
    TABLE(haptable_float3, term, term_count)               /* share g; 1 - exp(-tick / time) = d; time / tick d */     \
    TABLE(float, stiffening, stiffen ? 4 : 0)              /* c_1, c_2, c_3 of Psi' by s; 1 / (2 e_0) */               \
    FUNCTION(haptable_unpack_fn, unpack, HAPTABLE_UNPACKS) /* how blocks are read from packed; NULL: none is packed */ \
    FUNCTION(haptable_god_object_fn, god_object, HAPTABLE_GOD_OBJECTS)                                                 \
    FUNCTION(haptable_force_fn, force, HAPTABLE_FORCES)                                                                \
    FUNCTION(haptable_energy_fn, energy, HAPTABLE_ENERGIES) /* of that force, for a god-object that needs it */        \
    PART(struct haptable_compliance, compliance)            /* for a force that needs it */                            \
    FUNCTION(haptable_god_object_fn, frictionless, HAPTABLE_GOD_OBJECTS) /* that god_object_friction holds back */     \
    FUNCTION(haptable_finish_fn, release, HAPTABLE_FINISHES)                                                           \
    FUNCTION(haptable_finish_fn, passivity, HAPTABLE_FINISHES)                                                         \
    FUNCTION(haptable_god_object_fn, ungrabbed, HAPTABLE_GOD_OBJECTS) /* that god_object_grab holds still */           \
    FUNCTION(haptable_plausible_fn, plausible, HAPTABLE_PLAUSIBLES)                                                    \
    FUNCTION(haptable_gain_fn, limit, HAPTABLE_GAINS) /* of rate, mean, resume, where it has one of them */            \
    FUNCTION(haptable_limit_fn, rate, HAPTABLE_LIMITS)                                                                 \
    FUNCTION(haptable_limit_fn, mean, HAPTABLE_LIMITS)                                                                 \
    FUNCTION(haptable_god_object_fn, resume, HAPTABLE_RESUMES)                                                         \
    FUNCTION(haptable_stiffen_fn, stiffen, HAPTABLE_STIFFENINGS)                                                       \
    FUNCTION(haptable_relax_fn, relax, HAPTABLE_RELAXATIONS)                                                           \
    FUNCTION(haptable_check_fn, check, HAPTABLE_CHECKS)                                                                \
    VALUE(float, max_force_n)             /* the device's limit, > 0 */                                                \
    VALUE(float, rigid_stiffness_n_per_m) /* S of a fixed node is this times the identity, > 0 */                      \
    VALUE(float, tolerance_m)             /* 2^-20 of the body's diagonal: points nearer than this are the same */     \
    VALUE(float, workspace_limit_m)       /* a finger farther than this from grid_origin_m is refused */               \
    VALUE(haptable_float3, grid_origin_m) /* spatial index: lowest corner of the surface */                            \
    VALUE(float, grid_per_m)              /* spatial index: grid steps in a metre */                                   \
    VALUE(float, stiffness_limit_n_per_m) /* the largest eigenvalue of any point's S */                                \
    VALUE(float, static_friction)         /* for god_object_friction: >= kinetic_friction */                           \
    VALUE(float, kinetic_friction)        /* for god_object_friction: > 0 */                                           \
    VALUE(float, release_n)               /* for release: by how much a force may fall in a tick that lets go */       \
    VALUE(float, max_motion_m)            /* for plausible: the farthest that a finger comes in a tick, > 0 */         \
    VALUE(float, rate_n)                  /* for rate: by how much the force may rise in a tick, > 0 */                \
    VALUE(float, mean_limit_n2)           /* for mean: what the mean of the squared force stays below, > 0 */          \
    VALUE(float, mean_share)         /* for mean: of a tick in the filter's time, (1 + mean_slope) mean_share <= 1 */  \
    VALUE(float, mean_slope)         /* for mean: 2 (max_force_n^2 / mean_limit_n2 - 1), > 0 */                        \
    VALUE(float, resume_gain)        /* for resume: by how much the gain rises in a tick, > 0 */                       \
    VALUE(float, rest_share)         /* for relax: 1 less all shares, > 0 */                                           \
    VALUE(float, tick_share)         /* for relax: what a tick leaves of a steady rise: rest and g d time / tick */    \
    VALUE(float, relaxation_reach_m) /* for relax: from the last contact; a new one beyond knows nothing of it */      \
    VALUE(uint32_t, packed_count)    /* of the free vertices; or a compliance's: vertices, edges, patches in a row */  \
    VALUE(uint32_t, scale_count)     /* of int16 one a block, of float16 one for all */                                \
    VALUE(uint16_t, vertex_count)    /* vertices of touchable patches: free ones first */                              \
    VALUE(uint16_t, free_count)      /* how many of them are free: these have a block */                               \
    VALUE(uint16_t, patch_count)                                                                                       \
    VALUE(uint16_t, box_count)                                                                                         \
    VALUE(uint16_t, hinge_count) /* 0: every vertex has one ring of patches and every edge two */                      \
    VALUE(uint8_t, term_count)   /* for relax: at most HAPTABLE_TERMS */                                               \
    VALUE(uint32_t, crc)         /* for check: of all other values and tables, haptable_crc_of */

struct haptable_model {
    const struct haptable_hinges* hinges; /* haptable_hinges_of_table; NULL where no vertex is at one or at a border */
    const struct haptable_slivers* slivers; /* haptable_slivers_of_patches, _corners; NULL where there is none */
    HAPTABLE_MODEL_FIELDS(HAPTABLE_VALUE_FIELD, HAPTABLE_TABLE_FIELD, HAPTABLE_FUNCTION_FIELD, HAPTABLE_PART_FIELD)
    uint32_t relaxed_at; /* for relax: byte of each finger's struct haptable_relaxed in the state, behind the servos */
    uint32_t freed_at;   /* for god_object_friction: of each finger's struct haptable_freed */
    uint64_t hash;       /* of these tables, every bit of them, and of what they were made from: messages carry it */
};
#undef HAPTABLE_VALUE_FIELD
#undef HAPTABLE_TABLE_FIELD
#undef HAPTABLE_FUNCTION_FIELD
#undef HAPTABLE_PART_FIELD

/* Fields that a key of the scene gives alone. VALUE(field, key): its number, 0 where the scene has none. STAGE(field,
 * function, key): the function where that is above 0, or true, else NULL. */
#define HAPTABLE_MODEL_KEYS(VALUE, STAGE)                         \
    VALUE(release_n, "contact.release_slew")                      \
    STAGE(release, haptable_release_slew, "contact.release_slew") \
    STAGE(passivity, haptable_passivity_control, "contact.passivity")

/* The god-object on the rest surface: where it is and on which patch. */
struct haptable_contact {
    uint16_t patch; /* HAPTABLE_NONE: no contact */
    uint8_t slips;  /* with friction: 1 while the god-object slides */
    float alpha[3]; /* area coordinates of the god-object (eq. 11): each in 0..1, sum 1 */
    float god_object_m[3];
    float load_n[3]; /* with god_object_least_energy, with friction: S u there; otherwise meaningless */
};

/* A segment that is searched for the first patch that it enters: of the finger's path, or, in contact, from the surface
 * to the finger. */
struct haptable_segment {
    float from_m[3];
    float to_m[3];
    float fraction;     /* of the segment: where it enters `patch` */
    uint16_t patch;     /* the first that it enters, of those that were searched; HAPTABLE_NONE */
    uint16_t box;       /* of the index: where the search goes on */
    uint16_t boxes;     /* visited in this tick */
    uint16_t left[3];   /* the patches that it leaves are those with these vertices; first one HAPTABLE_NONE: none */
    uint8_t is_beside;  /* 1: it begins in front of or behind them, and may enter them; 0: it begins on them */
    uint8_t unfinished; /* 1: the next tick goes on with it */
};

/* Progress of the CRC check of the tables. */
struct haptable_table_check {
    uint32_t crc;    /* of what was taken of the part */
    uint32_t byte;   /* of the field, that comes next */
    uint8_t field;   /* of the part, that comes next */
    uint8_t verdict; /* of the last whole check: 0 none yet, 1 well, 2 damaged */
    uint8_t part;    /* of the scene, that comes next */
    uint8_t damaged; /* 1: a part before it is */
};

/* The whole state of one servo. The caller owns it; haptable_servo_init makes it valid. The state of a scene with one
 * finger ends before nearest_m2, or before the first of those after it that its model does not name. */
struct haptable_servo {
    uint8_t finger_known;    /* 0 or 1 */
    uint8_t state;           /* enum haptable_state */
    uint8_t undecided_ticks; /* in a row that could not tell inside from outside */
    uint8_t fade_ticks;      /* by so many of HAPTABLE_FADE_TICKS the force is down */
    uint16_t slide_patch;    /* where a slide to the nearest point that met its limit goes on; HAPTABLE_NONE */
    uint8_t finger;          /* its number among the servos of a state */
    uint8_t felt_known;      /* with release: 0 where contact was dropped since; then nothing was felt, nor is owed */
    uint16_t distrust_ticks; /* with plausible: HAPTABLE_DISTRUST_TICKS */
    uint8_t wait_ticks;      /* with plausible: until positions are believed again */
    uint8_t faults;          /* enum haptable_fault */
    struct haptable_contact contact;
    uint32_t position_us; /* when the last position came; wraps */
    uint32_t buttons;     /* held down: enum haptable_button */
    uint32_t pressed;     /* of them, those that were not held down a tick before */
    struct haptable_table_check check;
    struct haptable_counters counters;
    struct haptable_segment segment;
    float finger_m[3]; /* last accepted position; meaningless unless finger_known */
    float given_n[3];  /* the force of the last tick as it was given */
    float gain;        /* with limits: of the force, 0..1; falls in a contact, but for resume */
    float mean_n2;     /* with mean: of the squared force, filtered */
    /* with resume */
    float nearest_m2;       /* of the patches looked at, to the finger */
    uint16_t nearest_patch; /* that one */
    uint16_t seek_patch;    /* the next to look at; HAPTABLE_NONE: none is sought */
    /* with passivity */
    float given_j; /* energy given to the user, less what was taken; never far above 0 */
    /* with release */
    float felt_n[3];     /* the force of the last tick, before release and passivity; 0 without contact */
    float released_n[3]; /* what release still adds: of forces that have ended, or are to come up */
    float owed_j;        /* energy that is stored and not yet paid by the finger; >= 0 */
    /* with god_object_least_energy */
    float sensitivity_per_m[2][3]; /* of alpha_1, alpha_2 to the finger; 0: unknown */
};

/* One term of a relaxing body: its own load, g times which is a part of the force. */
struct haptable_relaxed_term {
    float branch[3]; /* sqrt(J), of which one is used; or N, where `held` */
    float lost[3];   /* what rounding left of it */
};

/* Relaxation state of a finger, behind its servo if a model names `relax`: haptable_relaxed_of. Reset if positions
 * pause. */
struct haptable_relaxed {
    uint32_t tick;    /* of the servo's counters: the last */
    uint32_t time_us; /* of that tick */
    uint8_t touches;  /* 1: it had contact */
    uint8_t held;     /* 1: branches are vectors */
    float dent;       /* of the surface: the root of twice the elastic energy that it would store; where the body
                         stiffens, times its factor */
    float dent_lost;  /* what rounding left of it */
    float stress;     /* the same of the relaxed load, > 0; 0 where the surface is free */
    float branches;   /* the sum of all, by their shares */
    float fall;       /* by how much that falls in a tick of rest */
    float pressed;    /* the dent when the finger left it, with these loads: */
    uint16_t vertex[3];
    float alpha[3];
    float god_object_m[3];
    float nodal_force_n[3][3];
    float offset_m[3]; /* where a contact may be held: u of the last tick */
    float load_n[3];   /* and the elastic load */
    struct haptable_relaxed_term term[HAPTABLE_TERMS];
};

/* Friction state of a finger, behind its servo if a model names it: haptable_freed_of. Reset by a tick without
 * frictional contact. */
struct haptable_freed {
    uint32_t tick;              /* of the servo's counters: the last */
    uint32_t contacts;          /* of its counters: the contact that this is of */
    float tangent;              /* of the load there, foreseen, squared: along the surface to the normal */
    struct haptable_contact at; /* where the god-object would be without friction */
    uint8_t has_compliance;     /* 1: that of the contact as the last tick left it is known: */
    float compliance_m_per_n[6];
};

/* State behind the servos. before: the model names `relax`; friction. */
static inline struct haptable_relaxed* haptable_relaxed_of(const struct haptable_model* model,
                                                           struct haptable_servo* servo) {
    unsigned char* const state = (unsigned char*)(servo - servo->finger);
    return (struct haptable_relaxed*)(state + model->relaxed_at) + servo->finger;
}
static inline struct haptable_freed* haptable_freed_of(const struct haptable_model* model,
                                                       struct haptable_servo* servo) {
    unsigned char* const state = (unsigned char*)(servo - servo->finger);
    return (struct haptable_freed*)(state + model->freed_at) + servo->finger;
}

/* Initialises a servo: no contact, no known finger position. */
void haptable_servo_init(struct haptable_servo* servo);

/* The same for a state of zeros. */
void haptable_servo_begin(struct haptable_servo* servo);

/* The buttons of the next tick, to be called before it by who has any: bits of enum haptable_button, all others 0. They
 * stay as they are until the next call. */
void haptable_servo_buttons(struct haptable_servo* servo, uint32_t buttons);

/* One tick: a finger position in, a force out. now_us may wrap. Bounded work; see SPEC.md for the bound. */
void haptable_servo_step(const struct haptable_model* model, struct haptable_servo* servo, const float finger_m[3],
                         uint32_t now_us, struct haptable_output* out);

/* To be called when no position has come: after HAPTABLE_SILENCE_US the output is zero force and the contact is
 * dropped. Returns 1 when out was written (the servo fell silent now or earlier), 0 when it is still in time. */
int haptable_servo_watch(struct haptable_servo* servo, uint32_t now_us, struct haptable_output* out);

/* Names what the surface of a model's tables needs: hinges, slivers. */
void haptable_model_surface(struct haptable_model* model);

/* CRC-32 (ISO-HDLC) of all values and tables of a part of a scene but its crc itself, in the order of their list. */
uint32_t haptable_crc_of(const void* tables, haptable_span_fn* span);

haptable_span_fn haptable_span_of_model;      /* of a struct haptable_model: its values, its tables, its compliance's */
haptable_span_fn haptable_span_of_compliance; /* these, of a model that has one */

/* ---- what a model may name: each in a file of its own --------------------------------------------------------- */

#define HAPTABLE_GOD_OBJECTS(X)         \
    X(haptable_god_object_nearest)      \
    X(haptable_god_object_least_energy) \
    X(haptable_god_object_friction)     \
    X(haptable_god_object_grab)
#define HAPTABLE_FORCES(X)              \
    X(haptable_force_interpolated)      \
    X(haptable_force_consistent)        \
    X(haptable_force_pressure_mask)     \
    X(haptable_force_of_least_energy)   \
    X(haptable_force_consistent_packed) \
    X(haptable_force_pressure_mask_packed)
#define HAPTABLE_ENERGIES(X)             \
    X(haptable_energy_interpolated)      \
    X(haptable_energy_consistent)        \
    X(haptable_energy_pressure_mask)     \
    X(haptable_energy_consistent_packed) \
    X(haptable_energy_pressure_mask_packed)
/* Force laws of two fingers: after haptable_pair_ (haptable_law.h). */
#define HAPTABLE_PAIR_LAWS(X) \
    X(interpolated)           \
    X(consistent)             \
    X(pressure_mask)          \
    X(consistent_packed)      \
    X(pressure_mask_packed)
#define HAPTABLE_FINISHES(X) X(haptable_release_slew) X(haptable_passivity_control) X(haptable_release_slew_stiffening)
#define HAPTABLE_PLAUSIBLES(X) X(haptable_plausible_motion)
#define HAPTABLE_GAINS(X) X(haptable_limit_force)
#define HAPTABLE_LIMITS(X) X(haptable_limit_rate) X(haptable_limit_mean)
#define HAPTABLE_RESUMES(X) X(haptable_resume_ramp)
#define HAPTABLE_CHECKS(X) X(haptable_check_crc)
#define HAPTABLE_STIFFENINGS(X) X(haptable_stiffened_of)
#define HAPTABLE_RELAXATIONS(X)            \
    X(haptable_relaxation)                 \
    X(haptable_relaxation_held)            \
    X(haptable_stiffening)                 \
    X(haptable_relaxation_stiffening)      \
    X(haptable_relaxation_held_stiffening) \
    X(haptable_pair_relaxation_stiffening)
#define HAPTABLE_UNPACKS(X) X(haptable_unpack_float16) X(haptable_unpack_int16)

/* god_object: the point with the least stored energy E(g) = 1/2 u^T S(g) u, tracked downhill from where it was; needs
 * model->energy. By the envelope theorem the force is minus the gradient of E, so moving in closed loops gains nothing.
 * haptable_least_energy.c has its conditions. */
haptable_god_object_fn haptable_god_object_least_energy;

/* god_object: the nearest point of the rest surface (Zilles and Salisbury 1995). haptable_contact.c has its conditions.
 */
haptable_god_object_fn haptable_god_object_nearest;

/* force: nodal forces F_i = alpha_i S_i u on the contact's patch (eq. 9, 10), u = finger - god-object, and the reaction
 * -(F_i + F_j + F_k) that the user feels (eq. 12). A fixed vertex has S = rigid_stiffness I.
 * before: contact->patch < patch_count. cost: three symmetric 3x3 products. */
haptable_force_fn haptable_force_interpolated;
haptable_energy_fn haptable_energy_interpolated;

/* force: F = -C^-1 u with the compliance C of the contact point (model->compliance, degree 2), nodal forces
 * alpha_i C^-1 u: the body's surface, so loaded, meets the finger. A fixed vertex adds no compliance; where that would
 * leave the point stiffer than its fraction of rigid_stiffness, it is lifted to that (haptable_compliance.h). */
haptable_force_fn haptable_force_consistent;
haptable_energy_fn haptable_energy_consistent;
haptable_force_fn haptable_force_consistent_packed;
haptable_energy_fn haptable_energy_consistent_packed;

/* force: the same for a contact of finite size (degree 4). The nodal forces are those of the whole load by alpha;
 * the load's distribution over the nodes under the mask is in the host's tables. */
haptable_force_fn haptable_force_pressure_mask;
haptable_energy_fn haptable_energy_pressure_mask;
haptable_force_fn haptable_force_pressure_mask_packed;
haptable_energy_fn haptable_energy_pressure_mask_packed;

/* force: the load that god_object_least_energy found at its point, which is that of the two forces above; not under
 * another god-object, nor under friction. */
haptable_force_fn haptable_force_of_least_energy;

/* god_object: with friction. It holds the god-object back where it was as long as the force there lies in the cone of
 * static friction, and lets it follow the frictionless one just so far that it lies in the cone of kinetic friction. */
haptable_god_object_fn haptable_god_object_friction;

/* release: when contact ends, or the god-object jumps, the difference of the forces is not dropped but brought down by
 * release_n a tick: a force that has ended only brakes, one that brakes more comes up. What the finger has not paid of
 * that is owed, and nothing pushes it until it is paid. */
haptable_finish_fn haptable_release_slew;

/* passivity: observes the energy that the servo gives over what it took, and damps the finger's motion until it is paid
 * back (Hannaford and Ryu 2002, time domain). */
haptable_finish_fn haptable_passivity_control;

/* god_object: while HAPTABLE_BUTTON_GRAB is held, the contact point stays where it is on the body: it pulls too, and
 * does not let go. Otherwise as model->ungrabbed. */
haptable_god_object_fn haptable_god_object_grab;

/* plausible: no finger is faster than max_motion_m a tick. After one that is, HAPTABLE_GOOD_TICKS plausible positions
 * come before one is believed. */
haptable_plausible_fn haptable_plausible_motion;

/* limit: times the gain, which the limits below lower. */
haptable_gain_fn haptable_limit_force;

/* rate: the force rises by no more than rate_n a tick, in any direction: it lies within rate_n of what is between none
 * and the last. Falling is free. */
haptable_limit_fn haptable_limit_rate;

/* mean: a filter of first order over the squared force, which heats the motors, stays below mean_limit_n2. From half of
 * that on the largest force comes down, from max_force_n to the root of mean_limit_n2. */
haptable_limit_fn haptable_limit_mean;

/* resume: a finger that is inside without having come through the surface (at the start, after silence or a fault) gets
 * a contact at the nearest patch, with a gain that rises from zero by resume_gain a tick, as does one that a limit has
 * lowered. Without it contact begins after the finger has left. */
haptable_god_object_fn haptable_resume_ramp;

/* relax: a body whose dents stiffen: the force times a cubic of the root of the energy that it stores. Nodal forces
 * stay the linear body's, which dent it to the finger. haptable_stiffening.c has the law. */
haptable_relax_fn haptable_stiffening;
haptable_stiffen_fn haptable_stiffened_of;
haptable_finish_fn haptable_release_slew_stiffening;

/* relax: a body whose stiffness falls with time by a sum of exponentials, the same everywhere. A finger is met where
 * the surface is, which comes back slowly; then the dent is still drawn. The one for a contact that friction or a hand
 * may hold: there each direction has its own history. haptable_relaxation.c has the law. */
haptable_relax_fn haptable_relaxation;
haptable_relax_fn haptable_relaxation_held;
haptable_relax_fn haptable_relaxation_stiffening;
haptable_relax_fn haptable_relaxation_held_stiffening;
haptable_relax_fn haptable_pair_relaxation_stiffening; /* of two fingers */

/* check: CRC-32 of every value and table of every part of a scene. */
haptable_check_fn haptable_check_crc;

/* unpack: binary16 with one scale for all blocks; integers with a scale for each. */
haptable_unpack_fn haptable_unpack_float16;
haptable_unpack_fn haptable_unpack_int16;

#ifdef __cplusplus
}
#endif

#endif
