/* SPDX-License-Identifier: MIT
 *
 * A scene that is read instead of linked: its bytes are those of codegen/scene_bytes.cpp. All functions that a scene
 * can name are linked with it. For images that feel any body: tests, and the page in a browser.
 */
#ifndef HAPTABLE_SCENE_READER_H
#define HAPTABLE_SCENE_READER_H

#include "haptable.h"
#include "haptable_hands.h"
#include "haptable_tool.h"

/* Where the bytes come from, where the tables go, and what a scene points to. It outlives the scene. */
struct haptable_scene_reader {
    uint32_t (*read)(void* from, void* to, uint32_t bytes); /* gives how many came */
    void* from;
    uint32_t* room;      /* for the tables; outlives the scene */
    uint32_t words;      /* of room */
    uint32_t used_words; /* 0 at first */
    int is_whole;        /* 1 at first; 0 where the bytes end too early, name what there is not, or need more room */
    struct haptable_model model;
    struct haptable_pair_model pair;
    struct haptable_body body;
    struct haptable_modes modes;
    struct haptable_compliance compliance;
    struct haptable_tool_model tool;
    struct haptable_points_model hands;
};

/* The parts of a scene: each reads its bytes into the reader, and returns it, or NULL where the reader is not whole.
 * What couples two places needs the model, a tool the coupling. The model's hash is not among its bytes. */
const struct haptable_model* haptable_read_model(struct haptable_scene_reader* reader);
const struct haptable_pair_model* haptable_read_pair(struct haptable_scene_reader* reader,
                                                     const struct haptable_model* model);
const struct haptable_body* haptable_read_body(struct haptable_scene_reader* reader);
const struct haptable_modes* haptable_read_modes(struct haptable_scene_reader* reader);
const struct haptable_tool_model* haptable_read_tool(struct haptable_scene_reader* reader,
                                                     const struct haptable_pair_model* pair);

/* A number that says which parts there are (enum haptable_scene_part), then the model and these. Returns 1, or 0 where
 * the reader is not whole. scene->points: of a tool, which has no pair, or of three fingers and more; else NULL. */
enum haptable_scene_part {
    HAPTABLE_PART_PAIR = 1,
    HAPTABLE_PART_BODY = 2,
    HAPTABLE_PART_MODES = 4,
    HAPTABLE_PART_TOOL = 8
};
int haptable_read_scene(struct haptable_scene_reader* reader, struct haptable_points_scene* scene);

#endif
