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

/* For a span of spans: rows of a table, whose count may be 0 where it has none. */
#define SPAN_OF_TABLE(type, name, count) {of->name, of->name ? (uint32_t)(count) * (uint32_t)sizeof *of->name : 0u},
#define NO_SPAN(...)

struct haptable_span haptable_span_of_compliance(const void* tables, uint32_t field) {
    const struct haptable_model* model = (const struct haptable_model*)tables;
    const struct haptable_compliance* of = model->compliance;
    /* What the list's numbers of rows speak of. */
    const int vertex_count = model->vertex_count;
    const int patch_count = model->patch_count;
    const int edge_count = of->edge_count;
    const int degree = of->degree;
    const struct haptable_span span[] = {{&of->edge_count, sizeof of->edge_count + sizeof of->degree},
                                         HAPTABLE_COMPLIANCE_FIELDS(NO_SPAN, SPAN_OF_TABLE){of, HAPTABLE_SPAN_END}};
    return span[field < sizeof span / sizeof span[0] ? field : sizeof span / sizeof span[0] - 1u];
}

struct haptable_span haptable_span_of_model(const void* tables, uint32_t field) {
    const struct haptable_model* of = (const struct haptable_model*)tables;
    const uint32_t vertex_count = of->vertex_count;
    const uint32_t free_count = of->free_count;
    const uint32_t packed_count = of->packed_count;
    const uint32_t scale_count = of->scale_count;
    const uint32_t patch_count = of->patch_count;
    const uint32_t box_count = of->box_count;
    const uint32_t hinge_count = of->hinge_count;
    const uint32_t term_count = of->term_count;
    haptable_stiffen_fn* const stiffen = of->stiffen;
    const struct haptable_span span[] = {
        {&of->max_force_n, (uint32_t)(offsetof(struct haptable_model, term_count) + sizeof of->term_count -
                                      offsetof(struct haptable_model, max_force_n))},
        HAPTABLE_MODEL_FIELDS(NO_SPAN, SPAN_OF_TABLE, NO_SPAN, NO_SPAN){of, HAPTABLE_SPAN_END}};
    const uint32_t tables_end = sizeof span / sizeof span[0] - 1u;
    if (field < tables_end) return span[field];
    return of->compliance ? of->compliance->span(of, field - tables_end) : span[tables_end];
}

uint32_t haptable_crc_of(const void* tables, haptable_span_fn* span_of) {
    uint32_t remainder = HAPTABLE_CRC_BEGIN;
    for (uint32_t field = 0;; ++field) {
        const struct haptable_span span = span_of(tables, field);
        if (span.bytes == HAPTABLE_SPAN_END) return ~remainder;
        remainder = haptable_crc(remainder, (const uint8_t*)span.at, span.bytes);
    }
}

struct haptable_part haptable_part_of(const struct haptable_scene* scene, uint32_t number) {
    struct haptable_part part = {0, 0, 0};
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

enum { PARTS = 4 };

/* A part is taken whole; 1 where that was the last. */
static int end_part(const struct haptable_scene* scene, const struct haptable_part* part,
                    struct haptable_table_check* check) {
    if (part->tables && check->crc != part->crc) check->damaged = 1;
    check->crc = 0;
    check->field = 0;
    return ++check->part >= (scene->part ? PARTS : 1);
}

/* All parts are taken. */
static void end_check(const struct haptable_scene* scene, struct haptable_servo* servo) {
    servo->check.verdict = servo->check.damaged ? CHECK_DAMAGED : CHECK_WELL;
    for (int finger = 0; finger < haptable_scene_fingers(scene) && servo->check.damaged; ++finger)
        haptable_fault(&servo[finger], HAPTABLE_FAULT_TABLES);
    haptable_check_begin(&servo->check);
}

/* cost: a byte takes two steps of the CRC, a field a search of its part's list. */
void haptable_check_crc(const struct haptable_scene* scene, struct haptable_servo* servo, uint32_t bytes) {
    struct haptable_table_check* check = &servo->check;
    while (bytes > 0u) {
        struct haptable_part part = {scene->model, haptable_span_of_model, scene->model->crc};
        struct haptable_span span = {0, HAPTABLE_SPAN_END};
        if (check->part > 0u) part = scene->part(scene, check->part);
        if (part.tables) span = part.span(part.tables, check->field);
        if (span.bytes == HAPTABLE_SPAN_END) {
            if (!end_part(scene, &part, check)) continue;
            end_check(scene, servo);
            break;
        }
        const uint32_t count = span.bytes - check->byte < bytes ? span.bytes - check->byte : bytes;
        check->crc = ~haptable_crc(~check->crc, (const uint8_t*)span.at + check->byte, count);
        check->byte += count;
        bytes -= count;
        if (check->byte < span.bytes) break;
        check->byte = 0;
        ++check->field;
    }
    for (int finger = 1; finger < haptable_scene_fingers(scene); ++finger) servo[finger].check = *check;
}
