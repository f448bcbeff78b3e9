/* SPDX-License-Identifier: MIT
 *
 * What all parts of the state machine use (docs/SAFETY.md): faults, and the check of the tables.
 */
#ifndef HAPTABLE_SAFETY_H
#define HAPTABLE_SAFETY_H

#include "haptable_model.h"

/* haptable_check.verdict */
enum { CHECK_NONE = 0, CHECK_WELL = 1, CHECK_DAMAGED = 2 };

static inline void haptable_check_begin(struct haptable_table_check* check) {
    check->crc = 0;
    check->byte = 0;
    check->field = 0;
    check->part = 0;
    check->damaged = 0;
}

/* A fault stands from now on, enum haptable_fault: the next tick has no force. Counted once. */
static inline void haptable_fault(struct haptable_servo* servo, uint8_t fault) {
    if ((servo->faults & fault) == 0) ++servo->counters.faulted;
    servo->faults |= fault;
}

#endif
