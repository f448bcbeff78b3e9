/* SPDX-License-Identifier: MIT */
#include "haptable_scene_reader.h"

static void take(struct haptable_scene_reader* in, void* to, uint32_t bytes) {
    if (in->read(in->from, to, bytes) != bytes) in->is_whole = 0;
}

static uint32_t take_word(struct haptable_scene_reader* in) {
    uint32_t word = 0;
    take(in, &word, sizeof word);
    return word;
}

/* A table after its number of rows; every one begins at a whole word. */
static void* take_table(struct haptable_scene_reader* in, uint32_t row_bytes) {
    uint32_t* table = in->room + in->used_words;
    const uint32_t rows = take_word(in);
    if (rows > (in->words - in->used_words) * (uint32_t)sizeof *table / row_bytes) in->is_whole = 0;
    if (rows == 0 || !in->is_whole) return 0;
    take(in, table, rows * row_bytes);
    in->used_words += (rows * row_bytes + 3u) / 4u;
    return table;
}

/* A number below `choices`, or 0. */
static uint32_t take_choice(struct haptable_scene_reader* in, uint32_t choices) {
    const uint32_t choice = take_word(in);
    if (choice < choices) return choice;
    in->is_whole = 0;
    return 0;
}

#define TAKE_VALUE(type, name) take(in, &to->name, sizeof to->name);
#define TAKE_TABLE(type, name, count) to->name = take_table(in, sizeof *to->name);
#define CHOICE(function) function,
#define TAKE_FUNCTION(type, name, choices)                                                                         \
    {                                                                                                              \
        static type* const choice[] = {0, choices(CHOICE)}; /* NOLINT(bugprone-macro-parentheses): it is a type */ \
        to->name = choice[take_choice(in, sizeof choice / sizeof choice[0])];                                      \
    }
#define TAKE_PART(type, name) \
    if (take_word(in)) to->name = take_##name(in, &in->name);

static const struct haptable_compliance* take_compliance(struct haptable_scene_reader* in,
                                                         struct haptable_compliance* to) {
    HAPTABLE_COMPLIANCE_FIELDS(TAKE_VALUE, TAKE_TABLE)
    to->span = haptable_span_of_compliance;
    return to;
}

const struct haptable_model* haptable_read_model(struct haptable_scene_reader* in) {
    struct haptable_model* to = &in->model;
    to->compliance = 0;
    haptable_lay_out(to);
    HAPTABLE_MODEL_FIELDS(TAKE_VALUE, TAKE_TABLE, TAKE_FUNCTION, TAKE_PART)
    if (!in->is_whole) return 0;
    haptable_model_surface(to);
    return to;
}

const struct haptable_pair_model* haptable_read_pair(struct haptable_scene_reader* in,
                                                     const struct haptable_model* model) {
    /* By the number that codegen/pair.cpp writes. */
#define LAW(name)                                               \
    {{&haptable_pair_##name, &haptable_pair_stiffening_##name}, \
     {&haptable_pair_bend_##name, &haptable_pair_bend_stiffening_##name}},
    static const struct { /* by whether dents stiffen */
        const struct haptable_pair_law* law[2];
        const struct haptable_pair_bend* bend[2];
    } laws[] = {HAPTABLE_PAIR_LAWS(LAW)};
#undef LAW
    struct haptable_pair_model* to = &in->pair;
    const uint32_t law = take_choice(in, sizeof laws / sizeof laws[0]);
    HAPTABLE_PAIR_FIELDS(TAKE_VALUE, TAKE_TABLE)
    to->model = model;
    to->law = laws[law].law[model->stiffen != 0];
    to->bend = model->energy ? laws[law].bend[model->stiffen != 0] : 0;
    to->energy = model->energy ? haptable_pair_energy : 0;
    to->settle = model->energy && !model->frictionless ? haptable_pair_settle : 0;
    to->cross = to->place_count == 0 ? haptable_pair_cross_exact : haptable_pair_cross_clusters;
    to->blocks = to->place_count == 0 ? haptable_pair_blocks_exact : haptable_pair_blocks_clusters;
    to->span = haptable_span_of_pair;
    return in->is_whole && to->finger_count <= HAPTABLE_HANDS ? to : 0;
}

const struct haptable_body* haptable_read_body(struct haptable_scene_reader* in) {
    take(in, &in->body, sizeof in->body);
    if (in->body.point_count > HAPTABLE_BODY_POINTS || in->body.motion >= HAPTABLE_RIGID_MOTIONS) return 0;
    return in->is_whole ? &in->body : 0;
}

const struct haptable_modes* haptable_read_modes(struct haptable_scene_reader* in) {
    struct haptable_modes* to = &in->modes;
    to->count = (uint8_t)take_choice(in, HAPTABLE_MODES + 1u);
    to->controls = (uint8_t)take_choice(in, HAPTABLE_MODES_CONTROLS + 1u);
    to->mode = take_table(in, sizeof *to->mode);
    to->shape = take_table(in, sizeof *to->shape);
    to->control_count = (uint16_t)take_word(in);
    to->crc = take_word(in);
    return in->is_whole ? to : 0;
}

const struct haptable_tool_model* haptable_read_tool(struct haptable_scene_reader* in,
                                                     const struct haptable_pair_model* pair) {
    struct haptable_tool_model* to = &in->tool;
    const uint32_t point_count = take_word(in);
    HAPTABLE_TOOL_FIELDS(TAKE_VALUE, TAKE_TABLE)
    haptable_points_model_make(pair, &to->points);
    to->points.count = (uint16_t)point_count;
    to->span = haptable_span_of_tool;
    haptable_tool_lay_out(&to->points);
    return in->is_whole && point_count <= HAPTABLE_POINTS ? to : 0;
}

int haptable_read_scene(struct haptable_scene_reader* in, struct haptable_points_scene* scene) {
    const uint32_t parts = take_word(in);
    const struct haptable_model* model = haptable_read_model(in);
    const struct haptable_pair_model* pair = 0;
    const struct haptable_body* body = 0;
    const struct haptable_modes* modes = 0;
    const struct haptable_tool_model* tool = 0;
    if (!model) return 0;
    if ((parts & HAPTABLE_PART_PAIR) != 0u && !(pair = haptable_read_pair(in, model))) return 0;
    if ((parts & HAPTABLE_PART_BODY) != 0u && !(body = haptable_read_body(in))) return 0;
    if ((parts & HAPTABLE_PART_MODES) != 0u && !(modes = haptable_read_modes(in))) return 0;
    if ((parts & HAPTABLE_PART_TOOL) != 0u && !(pair && (tool = haptable_read_tool(in, pair)))) return 0;
    scene->points = 0;
    if (tool)
        haptable_tool_scene_make(model, tool, scene);
    else if (pair && pair->finger_count > HAPTABLE_FINGERS)
        haptable_hands_scene_make(pair, &in->hands, scene);
    else
        haptable_scene_make(model, pair, body, modes, &scene->scene);
    return 1;
}
