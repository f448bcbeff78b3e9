/* SPDX-License-Identifier: MIT
 *
 * crc == CRC-32 of every value and table of the model, field after field
 *
 * Not covered: the functions that a model names, the addresses of its tables, model->hash and model->relaxed.
 */
#include "haptable.h"
#include "haptable_crc.h"
#include "haptable_safety.h"

/* The fields of a model and of its compliance, in the order of their lists. */
enum {
#define VALUE(type, name) FIELD_##name,
#define TABLE(type, name, count) FIELD_##name,
#define PART_VALUE(type, name) PART_##name,
#define PART_TABLE(type, name, count) PART_##name,
#define NO_FIELD(...)
    HAPTABLE_MODEL_FIELDS(VALUE, TABLE, NO_FIELD, NO_FIELD) HAPTABLE_COMPLIANCE_FIELDS(PART_VALUE, PART_TABLE) FIELDS
#undef VALUE
#undef TABLE
#undef PART_VALUE
#undef PART_TABLE
};

struct span {
    const void* at;
    uint32_t rows; /* 0: the field is not there */
    uint32_t row_bytes;
};

static struct span rows_of(const void* at, int rows, uint32_t row_bytes) {
    const struct span span = {at, at ? (uint32_t)rows : 0u, row_bytes};
    return span;
}

static struct span span_of(const struct haptable_model* model, uint32_t field) {
    static const struct haptable_compliance none = {.degree = 1};
    const struct haptable_compliance* compliance = model->compliance ? model->compliance : &none;
    /* What the lists' numbers of rows speak of. */
    haptable_unpack_fn* const unpack = model->unpack;
    const int vertex_count = model->vertex_count;
    const int free_count = model->free_count;
    const int patch_count = model->patch_count;
    const int box_count = model->box_count;
    const int hinge_count = model->hinge_count;
    const int term_count = model->term_count;
    const int degree = compliance->degree;
    const int edge_count = compliance->edge_count;
#define VALUE(type, name) \
    case FIELD_##name:    \
        return rows_of(&model->name, FIELD_##name != FIELD_crc, sizeof model->name);
#define TABLE(type, name, count) \
    case FIELD_##name:           \
        return rows_of(model->name, count, sizeof *model->name);
#define PART_VALUE(type, name) \
    case PART_##name:          \
        return rows_of(&compliance->name, compliance != &none, sizeof compliance->name);
#define PART_TABLE(type, name, count) \
    case PART_##name:                 \
        return rows_of(compliance->name, count, sizeof *compliance->name);
    switch (field) {
        HAPTABLE_MODEL_FIELDS(VALUE, TABLE, NO_FIELD, NO_FIELD)
        HAPTABLE_COMPLIANCE_FIELDS(PART_VALUE, PART_TABLE)
        default:
            return rows_of(0, 0, 0);
    }
#undef VALUE
#undef TABLE
#undef PART_VALUE
#undef PART_TABLE
#undef NO_FIELD
}

static uint32_t smaller(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* Goes on by at most so many bytes; 1 where all of them are taken. cost: a byte takes two steps of the CRC, a field a
 * look through the list. */
static int take(const struct haptable_model* model, struct haptable_table_check* check, uint32_t bytes) {
    while (bytes > 0) {
        const struct span span = span_of(model, check->field);
        const uint32_t whole = span.rows * span.row_bytes;
        const uint32_t count = smaller(whole - check->byte, bytes);
        if (check->field == FIELDS) return 1;
        if (count > 0) check->crc = haptable_crc(check->crc, (const uint8_t*)span.at + check->byte, count);
        check->byte += count;
        bytes -= count;
        if (check->byte < whole) return 0;
        check->byte = 0;
        ++check->field;
    }
    return 0;
}

uint32_t haptable_tables_crc(const struct haptable_model* model) {
    struct haptable_table_check check;
    haptable_check_begin(&check);
    (void)take(model, &check, HAPTABLE_CHECK_ALL);
    return ~check.crc;
}

void haptable_check_crc(const struct haptable_model* model, struct haptable_servo* servo, uint32_t bytes) {
    struct haptable_table_check* check = &servo->check;
    if (check->field == 0 && check->byte == 0) haptable_check_begin(check);
    if (!take(model, check, bytes)) return;
    check->verdict = ~check->crc == model->crc ? CHECK_WELL : CHECK_DAMAGED;
    if (check->verdict == CHECK_DAMAGED) haptable_fault(servo, HAPTABLE_FAULT_TABLES);
    haptable_check_begin(check);
}
