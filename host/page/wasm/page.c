/* SPDX-License-Identifier: MIT
 *
 * The servo of firmware/ as a WebAssembly module for a page: it reads its models, feels one or two fingers that hands
 * hold, or a tool, and draws equation 8. Freestanding; the only memory is the module's own. For one caller
 * (host/page/web/engine.js).
 */
#include "deform.h"
#include "hand.h"
#include "haptable_scene_reader.h"

#define EXPORT(name) __attribute__((export_name(#name)))

/* A tick of a finger, as the caller reads it: words of 32 bits in this order. A record has one for each finger; behind
 * them, of a body that rings, how far each mode has swung (float) and, of one that nothing holds, struct page_pose: its
 * frame is that of all but the finger and the force. */
struct page_tick {
    uint32_t state;           /* enum haptable_state */
    int32_t patch, vertex[3]; /* -1 without contact */
    float finger_m[3], alpha[3], god_object_m[3], force_n[3], nodal_force_n[3][3];
    uint32_t buttons; /* held down: bits of enum haptable_button */
    uint32_t faults;  /* bits of enum haptable_fault */
};

struct page_pose {
    float centre_m[3], turn[4];
};

/* A record of a tool: the hand's tick, whose finger is the handle, one of each point, and then this. */
struct page_grip {
    float turn[4], torque_n_m[3];           /* of the hand */
    float tool_position_m[3], tool_turn[4]; /* where the tool is */
};

#define PAGE_BYTES 65536u
#define STEPS_OF_A_TICK 20 /* of the hand: as the simulated device's */
#define AWAY 0x80000000u   /* among the buttons of one of two fingers: it is not there */

extern unsigned char __heap_base;

static uintptr_t used_up;
static struct haptable_points_scene held; /* its points are a tool's: null where the hand has fingers */
static void* state;                       /* of the scene */
static struct haptable_body body;
static float begun_m[3], begun_turn[4]; /* where the body was in the last tick */
static int is_free;                     /* nothing holds the body */
static struct page_hand hand[HAPTABLE_FINGERS];
static float hand_turn[4] = {1.0f}, goal_turn[4] = {1.0f}; /* of a hand that holds a tool, w x y z */
static struct page_columns columns;
static struct page_spread spread;
static struct page_modes shapes;
static int is_spread;
static float* displacement_m;
static uint32_t now_us;

/* Room for `bytes`, for ever, at a multiple of 16. 0: the browser gives no more. */
EXPORT(page_reserve) void* page_reserve(uint32_t bytes) {
    const uintptr_t begin = used_up ? used_up : ((uintptr_t)&__heap_base + 15u) & ~(uintptr_t)15u;
    const uintptr_t end = (begin + bytes + 15u) & ~(uintptr_t)15u;
    const uintptr_t have = __builtin_wasm_memory_size(0) * PAGE_BYTES;
    if (end < begin) return 0;
    if (end > have && __builtin_wasm_memory_grow(0, (end - have + PAGE_BYTES - 1u) / PAGE_BYTES) == (uintptr_t)-1)
        return 0;
    used_up = end;
    return (void*)begin;
}

struct bytes {
    const unsigned char* next;
    uint32_t left;
};

static uint32_t read_bytes(void* from, void* to, uint32_t count) {
    struct bytes* bytes = from;
    unsigned char* out = to;
    uint32_t i;
    if (count > bytes->left) return 0;
    for (i = 0; i < count; ++i) out[i] = bytes->next[i];
    bytes->next += count;
    bytes->left -= count;
    return count;
}

/* A reader of these bytes, which outlives what it reads; 0: the browser gives no more room. */
static struct haptable_scene_reader* reader_of(struct bytes* bytes) {
    struct haptable_scene_reader* reader = page_reserve(sizeof *reader);
    if (!reader) return 0;
    reader->read = read_bytes;
    reader->from = bytes;
    reader->words = bytes->left / 4u + 64u;
    reader->used_words = 0;
    reader->is_whole = 1;
    reader->room = page_reserve(4u * reader->words);
    return reader->room ? reader : 0;
}

/* The model of these bytes; 0 where they are none, or there is no room. */
EXPORT(page_model) const struct haptable_model* page_model(const unsigned char* model_bytes, uint32_t count) {
    struct bytes bytes = {model_bytes, count};
    struct haptable_scene_reader* reader = reader_of(&bytes);
    const struct haptable_model* model = reader ? haptable_read_model(reader) : 0;
    return bytes.left == 0 ? model : 0;
}

/* What couples two fingers of a model, of these bytes; 0 as page_model. */
EXPORT(page_coupling)
const struct haptable_pair_model* page_coupling(const struct haptable_model* model, const unsigned char* coupling_bytes,
                                                uint32_t count) {
    struct bytes bytes = {coupling_bytes, count};
    struct haptable_scene_reader* reader = reader_of(&bytes);
    const struct haptable_pair_model* tables = reader ? haptable_read_pair(reader, model) : 0;
    return bytes.left == 0 ? tables : 0;
}

/* The modes of a body, of these bytes; 0 as page_model. */
EXPORT(page_body_modes)
const struct haptable_modes* page_body_modes(const struct haptable_model* model, const unsigned char* mode_bytes,
                                             uint32_t count) {
    struct bytes bytes = {mode_bytes, count};
    struct haptable_scene_reader* reader = reader_of(&bytes);
    const struct haptable_modes* modes = reader ? haptable_read_modes(reader) : 0;
    (void)model; /* as page_coupling is called */
    return bytes.left == 0 ? modes : 0;
}

/* A tool whose points these tables couple, of these bytes; 0 as page_model. */
EXPORT(page_tool)
const struct haptable_tool_model* page_tool(const struct haptable_pair_model* tables, const unsigned char* tool_bytes,
                                            uint32_t count) {
    struct bytes bytes = {tool_bytes, count};
    struct haptable_scene_reader* reader = reader_of(&bytes);
    const struct haptable_tool_model* tool = reader ? haptable_read_tool(reader, tables) : 0;
    return bytes.left == 0 ? tool : 0;
}

/* What moves, where nothing holds the body: struct haptable_body, which is the same here and on the host. 0: it is not.
 */
EXPORT(page_body) int page_body(const unsigned char* body_bytes, uint32_t count) {
    struct bytes bytes = {body_bytes, count};
    is_free = count == sizeof body && read_bytes(&bytes, &body, count) == count;
    return is_free;
}

/* Fingers that are not known, a body that rests where it is made; tables: 0, or those of two fingers; modes: 0, or
 * those of the body; tool: 0, or what the hand holds. 0: the browser gives no more room. */
EXPORT(page_begin)
int page_begin(const struct haptable_model* model, const struct haptable_pair_model* tables,
               const struct haptable_modes* modes, const struct haptable_tool_model* tool) {
    const uint32_t had = held.scene.bytes;
    held.points = 0;
    if (tool)
        haptable_tool_scene_make(model, tool, &held);
    else
        haptable_scene_make(model, tables, is_free ? &body : 0, modes, &held.scene);
    if (!state || held.scene.bytes > had) state = page_reserve(held.scene.bytes);
    if (!state) return 0;
    haptable_init(&held.scene, state);
    haptable_check(&held.scene, state, HAPTABLE_CHECK_ALL);
    now_us = 0;
    return 1;
}

static void fill(struct page_tick* tick, const float finger_m[3], const struct haptable_output* out) {
    const int touches = out->patch != HAPTABLE_NONE; /* else vertices may be those of a dent */
    int a;
    tick->state = out->state;
    tick->patch = touches ? out->patch : -1;
    for (a = 0; a < 3; ++a) {
        tick->vertex[a] = touches ? out->vertex[a] : -1;
        tick->finger_m[a] = finger_m[a];
        tick->alpha[a] = touches ? out->alpha[a] : 0.0f;
        tick->god_object_m[a] = out->god_object_m[a];
        tick->force_n[a] = out->force_n[a];
    }
    for (a = 0; a < 9; ++a) tick->nodal_force_n[a / 3][a % 3] = out->nodal_force_n[a / 3][a % 3];
}

/* One tick of a tool: position and turn of its handle; where the next record begins. */
static struct page_tick* step_tool(const float pose[7], uint32_t buttons, struct page_tick* ticks) {
    struct haptable_tool_input in;
    struct haptable_tool_output out;
    struct page_grip* grip;
    int a, i;
    in.hand.is_there = 1;
    in.hand.buttons = buttons;
    for (a = 0; a < 3; ++a) in.hand.finger_m[a] = pose[a];
    for (a = 0; a < 4; ++a) in.turn[a] = pose[3 + a];
    haptable_step(&held.scene, state, &in.hand, now_us, &out.hand);
    now_us += HAPTABLE_TICK_US;
    fill(ticks, pose, &out.hand);
    ticks->buttons = buttons;
    ticks->faults = out.hand.faults;
    ++ticks;
    for (i = 0; i < held.points->count; ++i, ++ticks) {
        struct haptable_output point;
        haptable_tool_point_of(&held.scene, state, i, &point);
        fill(ticks, haptable_points_servos(held.points, state)[i].finger_m, &point);
        ticks->buttons = ticks->faults = 0;
    }
    grip = (struct page_grip*)ticks;
    for (a = 0; a < 4; ++a) grip->turn[a] = pose[3 + a];
    for (a = 0; a < 3; ++a) grip->torque_n_m[a] = out.torque_n_m[a];
    for (a = 0; a < 3; ++a) grip->tool_position_m[a] = out.position_m[a];
    for (a = 0; a < 4; ++a) grip->tool_turn[a] = out.turn[a];
    return (struct page_tick*)(grip + 1);
}

/* One tick of all fingers, AWAY among the buttons of one that is not there; where the next record begins. */
static struct page_tick* step(const float (*finger_m)[3], const uint32_t* buttons, struct page_tick* ticks) {
    static const float nowhere[3] = {__builtin_nanf(""), __builtin_nanf(""), __builtin_nanf("")};
    const int fingers = haptable_scene_fingers(&held.scene);
    struct haptable_output out[HAPTABLE_FINGERS];
    struct haptable_input in[HAPTABLE_FINGERS];
    float* swung = (float*)(ticks + fingers);
    struct page_pose* pose;
    int f;
    int a;
    for (f = 0; f < fingers; ++f) {
        in[f].is_there = (buttons[f] & AWAY) == 0u;
        in[f].buttons = buttons[f] & ~AWAY;
        for (a = 0; a < 3; ++a) in[f].finger_m[a] = finger_m[f][a];
    }
    for (a = 0; is_free && a < 3; ++a) begun_m[a] = haptable_scene_body(&held.scene, state)->position_m[a];
    for (a = 0; is_free && a < 4; ++a) begun_turn[a] = haptable_scene_body(&held.scene, state)->turn[a];
    haptable_step(&held.scene, state, in, now_us, out);
    now_us += HAPTABLE_TICK_US;
    for (f = 0; f < fingers; ++f) {
        fill(&ticks[f], in[f].is_there ? finger_m[f] : nowhere, &out[f]);
        ticks[f].buttons = in[f].buttons;
        ticks[f].faults = out[f].faults;
    }
    for (a = 0; held.scene.modes && a < held.scene.modes->count; ++a)
        *swung++ = haptable_scene_modes(&held.scene, state)->q[a];
    pose = (struct page_pose*)swung;
    if (!is_free) return (struct page_tick*)pose;
    for (a = 0; a < 3; ++a) pose->centre_m[a] = begun_m[a];
    for (a = 0; a < 4; ++a) pose->turn[a] = begun_turn[a];
    return (struct page_tick*)(pose + 1);
}

/* `count` ticks, one a millisecond: positions [count, fingers, 3] in m, and the buttons held down [count, fingers],
 * AWAY among them; null: none. Of a tool [count, 7]: its handle, and its turn w x y z. */
EXPORT(page_replay)
void page_replay(const float (*finger_m)[3], const uint32_t* buttons, uint32_t count, struct page_tick* ticks) {
    static const uint32_t none[HAPTABLE_FINGERS];
    const uint32_t fingers = (uint32_t)haptable_scene_fingers(&held.scene);
    uint32_t i;
    if (held.points) {
        const float* pose = (const float*)finger_m;
        for (i = 0; i < count; ++i) ticks = step_tool(pose + 7 * i, buttons ? buttons[i] : 0u, ticks);
        return;
    }
    for (i = 0; i < fingers * count; i += fingers) ticks = step(finger_m + i, buttons ? buttons + i : none, ticks);
}

EXPORT(page_hand) struct page_hand* page_hand(int finger) { return &hand[finger]; }
EXPORT(page_place) void page_place(int finger, double x, double y, double z) {
    const double at_m[3] = {x, y, z};
    page_hand_place(&hand[finger], at_m);
}
/* Where the hand turns a tool to by the end of the next page_feel; at_once: it is turned so. */
EXPORT(page_turn) void page_turn(double w, double x, double y, double z, int at_once) {
    const double turn[4] = {w, x, y, z};
    int a;
    for (a = 0; a < 4; ++a) goal_turn[a] = (float)turn[a];
    for (a = 0; at_once && a < 4; ++a) hand_turn[a] = goal_turn[a];
}

/* Turns the hand by its part of what is left in so many ticks. */
static void turn_hand(uint32_t left) {
    float length2 = 0.0f, along = 0.0f, length;
    int a;
    for (a = 0; a < 4; ++a) along += hand_turn[a] * goal_turn[a];
    for (a = 0; a < 4; ++a) {
        hand_turn[a] += ((along < 0.0f ? -goal_turn[a] : goal_turn[a]) - hand_turn[a]) / (float)left;
        length2 += hand_turn[a] * hand_turn[a];
    }
    length = __builtin_sqrtf(length2);
    for (a = 0; a < 4; ++a) hand_turn[a] /= length;
}

/* The hand's part of tick i of `count`: its goal goes evenly from `from` to `to`, its motors give the force. */
static void advance(struct page_hand* of, const double from_m[3], const double to_m[3], uint32_t i, uint32_t count,
                    const float force_n[3], double gain) {
    const double tick_s = 1e-6 * HAPTABLE_TICK_US, step_s = tick_s / STEPS_OF_A_TICK;
    double goal_m_s[3], goal_m[3], motor_n[3];
    int a, s;
    for (a = 0; a < 3; ++a) {
        goal_m_s[a] = (to_m[a] - from_m[a]) / (count * tick_s);
        motor_n[a] = gain * (double)force_n[a];
    }
    page_hand_force(of, motor_n);
    for (s = 0; s < STEPS_OF_A_TICK; ++s) {
        for (a = 0; a < 3; ++a) goal_m[a] = from_m[a] + goal_m_s[a] * (i * tick_s + (s + 0.5) * step_s);
        page_hand_advance(of, goal_m, goal_m_s, step_s);
    }
}

/* `count` ticks in a closed loop: each hand's goal goes evenly from `from` to `to` [fingers, 3], the motors give `gain`
 * times the force. away: [fingers], AWAY for one that is not there. */
EXPORT(page_feel)
void page_feel(const double (*from_m)[3], const double (*to_m)[3], double gain, const uint32_t* away, uint32_t count,
               struct page_tick* ticks) {
    const int fingers = haptable_scene_fingers(&held.scene);
    float finger_m[HAPTABLE_FINGERS][3];
    uint32_t i;
    int f;
    for (i = 0; i < count; ++i) {
        const struct page_tick* tick = ticks;
        for (f = 0; f < fingers; ++f) page_hand_encoders(&hand[f], finger_m[f]);
        if (held.points) {
            float pose[7];
            turn_hand(count - i);
            for (f = 0; f < 7; ++f) pose[f] = f < 3 ? finger_m[0][f] : hand_turn[f - 3];
            ticks = step_tool(pose, 0, ticks);
        } else {
            ticks = step((const float(*)[3])finger_m, away, ticks);
        }
        for (f = 0; f < fingers; ++f)
            if (away[f] == 0u) advance(&hand[f], from_m[f], to_m[f], i, count, tick[f].force_n, gain);
    }
}

/* Columns of equation 8; single or half is null. */
EXPORT(page_columns)
void page_columns(uint32_t column_count, uint32_t row_count, float unit_m_per_n, const float* single,
                  const uint16_t* half) {
    columns.column_count = column_count;
    columns.row_count = row_count;
    columns.unit_m_per_n = unit_m_per_n;
    columns.single = single;
    columns.half = half;
    displacement_m = page_reserve(12u * row_count);
}

/* How the mask's load is spread. */
EXPORT(page_spread)
void page_spread(const int32_t* vertex_control, const int32_t* edge_control, const int32_t* begin,
                 const int32_t* column, const float* weight) {
    spread.vertex_control = vertex_control;
    spread.edge_control = edge_control;
    spread.begin = begin;
    spread.column = column;
    spread.weight = weight;
}

/* How the modes move the rows: [row_count, count, 3]. */
EXPORT(page_shapes) void page_shapes(uint32_t count, const float (*row)[3]) {
    shapes.count = count;
    shapes.row = row;
}

/* Whether the loads that come are a mask's. */
EXPORT(page_spreads) void page_spreads(int yes) { is_spread = yes; }

static void displace(const struct page_tick* tick) {
    int c;
    /* Free, it may have a dent that the finger left. */
    if (!haptable_touches((int)tick->state) && (tick->state != HAPTABLE_FREE || tick->vertex[0] < 0)) return;
    if (is_spread) {
        const uint16_t vertex[3] = {(uint16_t)tick->vertex[0], (uint16_t)tick->vertex[1], (uint16_t)tick->vertex[2]};
        page_deform_add_spread(&columns, &spread, vertex, (uint16_t)tick->patch, tick->nodal_force_n, displacement_m);
        return;
    }
    for (c = 0; c < 3; ++c)
        if ((uint32_t)tick->vertex[c] < columns.column_count)
            page_deform_add(&columns, (uint32_t)tick->vertex[c], tick->nodal_force_n[c], displacement_m);
}

/* The displacements [row_count, 3] in m under the loads of a record's fingers and as its modes have swung; 0 where
 * there was no room for them. */
EXPORT(page_displace) const float* page_displace(const struct page_tick* ticks, int fingers) {
    int f;
    if (!displacement_m) return 0;
    page_deform_clear(&columns, displacement_m);
    for (f = 0; f < fingers; ++f) displace(&ticks[f]);
    page_deform_add_modes(&columns, &shapes, (const float*)(ticks + fingers), displacement_m);
    return displacement_m;
}
