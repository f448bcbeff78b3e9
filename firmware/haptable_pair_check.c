/* SPDX-License-Identifier: MIT
 *
 * crc == CRC-32 of every value and table of the coupling, field after field, as haptable_check.c does it of a model
 */
#include "haptable_crc.h"
#include "haptable_pair.h"
#include "haptable_safety.h"

enum {
#define VALUE(type, name) FIELD_##name,
#define TABLE(type, name, count) FIELD_##name,
    HAPTABLE_PAIR_FIELDS(VALUE, TABLE) FIELDS
#undef VALUE
#undef TABLE
};

struct span {
    const void* at;
    uint32_t bytes;
};

static struct span bytes_of(const void* at, uint32_t rows, uint32_t row_bytes) {
    const struct span span = {at, at ? rows * row_bytes : 0u};
    return span;
}

static struct span span_of(const struct haptable_pair_model* tables, uint32_t field) {
    /* What the list's numbers of rows speak of. */
    const uint32_t control_count = tables->control_count;
    const uint32_t place_count = tables->place_count;
    const uint32_t load_count = tables->load_count;
    const uint32_t rank = tables->rank;
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
            return bytes_of(0, 0, 0);
    }
}

/* Goes on by at most so many bytes; 1 where all of them are taken. */
static int take(const struct haptable_pair_model* tables, struct haptable_table_check* check, uint32_t bytes) {
    while (bytes > 0 && check->field < FIELDS) {
        const struct span span = span_of(tables, check->field);
        const uint32_t left = span.bytes - check->byte;
        const uint32_t count = left < bytes ? left : bytes;
        if (count > 0) check->crc = haptable_crc(check->crc, (const uint8_t*)span.at + check->byte, count);
        check->byte += count;
        bytes -= count;
        if (check->byte < span.bytes) return 0;
        check->byte = 0;
        ++check->field;
    }
    return check->field == FIELDS;
}

uint32_t haptable_pair_crc(const struct haptable_pair_model* tables) {
    struct haptable_table_check check;
    haptable_check_begin(&check);
    (void)take(tables, &check, HAPTABLE_CHECK_ALL);
    return ~check.crc;
}

void haptable_pair_check_crc(const struct haptable_pair_model* tables, struct haptable_pair* pair, uint32_t bytes) {
    struct haptable_table_check* check = &pair->check;
    int finger;
    if (check->field == 0 && check->byte == 0) haptable_check_begin(check);
    if (!take(tables, check, bytes)) return;
    check->verdict = ~check->crc == tables->crc ? CHECK_WELL : CHECK_DAMAGED;
    for (finger = 0; finger < HAPTABLE_FINGERS && check->verdict == CHECK_DAMAGED; ++finger)
        haptable_fault(&pair->servo[finger], HAPTABLE_FAULT_TABLES);
    haptable_check_begin(check);
}
