/* SPDX-License-Identifier: MIT
 *
 * crc == CRC-32 of every value and table of a part, field after field: of the model, what couples two fingers, the
 * rigid body, the modes
 *
 * Not covered: functions, the addresses of tables, where parts stand in the state, and model->hash.
 */
#include "haptable_crc.h"
#include "haptable_safety.h"
#include "haptable_scene.h"

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

static struct haptable_span rows_of(const void* at, int rows, uint32_t row_bytes) {
    const struct haptable_span span = {at, at ? (uint32_t)rows * row_bytes : 0u};
    return span;
}

struct haptable_span haptable_span_of_model(const void* tables, uint32_t field) {
    const struct haptable_model* model = (const struct haptable_model*)tables;
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
            return rows_of(model, 1, HAPTABLE_SPAN_END);
    }
#undef VALUE
#undef TABLE
#undef PART_VALUE
#undef PART_TABLE
#undef NO_FIELD
}

/* Goes on through a part by at most *bytes bytes, which it takes off; 1 where all of it is taken. cost: a byte takes
 * two steps of the CRC, a field a look through the list. */
static int take(const void* tables, haptable_span_fn* span_of, struct haptable_table_check* check, uint32_t* bytes) {
    while (*bytes > 0u) {
        const struct haptable_span span = span_of(tables, check->field);
        uint32_t count;
        if (span.bytes == HAPTABLE_SPAN_END) return 1;
        count = span.bytes - check->byte < *bytes ? span.bytes - check->byte : *bytes;
        if (count > 0u) check->crc = haptable_crc(check->crc, (const uint8_t*)span.at + check->byte, count);
        check->byte += count;
        *bytes -= count;
        if (check->byte < span.bytes) return 0;
        check->byte = 0;
        ++check->field;
    }
    return 0;
}

uint32_t haptable_crc_of(const void* tables, haptable_span_fn* span) {
    struct haptable_table_check check;
    uint32_t bytes = HAPTABLE_CHECK_ALL;
    haptable_check_begin(&check);
    (void)take(tables, span, &check, &bytes);
    return ~check.crc;
}

/* A part of a scene. */
struct part {
    const void* tables; /* NULL: the scene has none */
    haptable_span_fn* span;
    uint32_t crc;
};

enum { PARTS = 4 };

static struct part part_of(const struct haptable_scene* scene, uint32_t number) {
    const struct part model = {scene->model, haptable_span_of_model, scene->model->crc};
    struct part part = {0, 0, 0};
    if (number == 0u) return model;
    if (number == 1u && scene->pair) {
        part.tables = scene->pair;
        part.span = scene->pair->span;
        part.crc = scene->pair->crc;
    } else if (number == 2u && scene->body) {
        part.tables = scene->body;
        part.span = scene->rigid->span;
        part.crc = scene->body->crc;
    } else if (number == 3u && scene->modes) {
        part.tables = scene->modes;
        part.span = scene->ringing->span;
        part.crc = scene->modes->crc;
    }
    return part;
}

/* The next part begins. */
static void end_part(uint32_t crc, struct haptable_table_check* check) {
    const uint8_t damaged = (uint8_t)(check->damaged | (~check->crc != crc));
    const uint8_t next = (uint8_t)(check->part + 1u);
    haptable_check_begin(check);
    check->part = next;
    check->damaged = damaged;
}

/* Goes on by at most so many bytes; 1 where all parts are taken. */
static int take_parts(const struct haptable_scene* scene, struct haptable_table_check* check, uint32_t bytes) {
    while (check->part < PARTS) {
        const struct part part = part_of(scene, check->part);
        if (part.tables && !take(part.tables, part.span, check, &bytes)) return 0;
        end_part(part.tables ? part.crc : ~check->crc, check);
    }
    return 1;
}

void haptable_check_crc(const struct haptable_scene* scene, struct haptable_servo* servo, uint32_t bytes) {
    struct haptable_table_check* check = &servo->check;
    int finger;
    if (check->part == 0u && check->field == 0u && check->byte == 0u) haptable_check_begin(check);
    if (take_parts(scene, check, bytes)) {
        check->verdict = check->damaged ? CHECK_DAMAGED : CHECK_WELL;
        if (check->verdict == CHECK_DAMAGED)
            for (finger = 0; finger < haptable_scene_fingers(scene); ++finger)
                haptable_fault(&servo[finger], HAPTABLE_FAULT_TABLES);
        haptable_check_begin(check);
    }
    for (finger = 1; finger < haptable_scene_fingers(scene); ++finger) servo[finger].check = *check;
}
