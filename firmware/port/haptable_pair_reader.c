/* SPDX-License-Identifier: MIT */
#include "haptable_pair_reader.h"

/* By the number that codegen/pair.cpp writes. */
static const struct {
    const struct haptable_pair_law* law;
    const struct haptable_pair_bend* bend;
} laws[] = {{&haptable_pair_interpolated, &haptable_pair_bend_interpolated},
            {&haptable_pair_consistent, &haptable_pair_bend_consistent},
            {&haptable_pair_pressure_mask, &haptable_pair_bend_pressure_mask}};

#define TAKE_VALUE(type, name) haptable_reader_take(in, &to->name, sizeof to->name);
#define TAKE_TABLE(type, name, count) to->name = haptable_reader_table(in, sizeof *to->name);

int haptable_read_pair(struct haptable_model_reader* in, const struct haptable_model* model,
                       struct haptable_pair_model* to) {
    uint32_t law = 0;
    haptable_reader_take(in, &law, sizeof law);
    if (law >= sizeof laws / sizeof laws[0]) return 0;
    HAPTABLE_PAIR_FIELDS(TAKE_VALUE, TAKE_TABLE)
    to->model = model;
    to->law = laws[law].law;
    to->bend = model->energy ? laws[law].bend : 0;
    to->energy = model->energy ? haptable_pair_energy : 0;
    to->settle = model->energy && !model->frictionless ? haptable_pair_settle : 0;
    to->track = model->energy ? haptable_pair_track : 0;
    to->cross = to->place_count == 0 ? haptable_pair_cross_exact : haptable_pair_cross_clusters;
    to->blocks = to->place_count == 0 ? haptable_pair_blocks_exact : haptable_pair_blocks_clusters;
    to->freed = model->freed ? &in->freed_of_second : 0;
    to->check = model->check ? haptable_pair_check_crc : 0;
    return in->is_whole;
}
