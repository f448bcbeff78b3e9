/* SPDX-License-Identifier: MIT
 *
 * The coupling's values and tables, one after another: what its CRC is of
 */
#include "haptable_pair.h"

enum {
#define VALUE(type, name) FIELD_##name,
#define TABLE(type, name, count) FIELD_##name,
    HAPTABLE_PAIR_FIELDS(VALUE, TABLE) FIELDS
#undef VALUE
#undef TABLE
};

static struct haptable_span bytes_of(const void* at, uint32_t rows, uint32_t row_bytes) {
    const struct haptable_span span = {at, at ? rows * row_bytes : 0u};
    return span;
}

struct haptable_span haptable_span_of_pair(const void* of, uint32_t field) {
    const struct haptable_pair_model* tables = (const struct haptable_pair_model*)of;
    /* What the list's numbers of rows speak of. */
    const uint32_t control_count = tables->control_count;
    const uint32_t place_count = tables->place_count;
    const uint32_t load_count = tables->load_count;
    const uint32_t rank = tables->rank;
    const uint32_t fine_count = tables->fine_count;
    const uint32_t* const core_begin = tables->core_begin;
    const uint32_t* const load_begin = tables->load_begin;
    switch (field) {
#define VALUE(type, name) \
    case FIELD_##name:    \
        return bytes_of(&tables->name, FIELD_##name != FIELD_crc, (uint32_t)sizeof tables->name);
#define TABLE(type, name, count) \
    case FIELD_##name:           \
        return bytes_of(tables->name, count, (uint32_t)sizeof *tables->name);
        HAPTABLE_PAIR_FIELDS(VALUE, TABLE)
#undef VALUE
#undef TABLE
        default:
            return bytes_of(tables, 1, HAPTABLE_SPAN_END);
    }
}
