/* SPDX-License-Identifier: MIT
 *
 * How a fan goes on where its ring of patches ends
 */
#include "haptable_surface.h"

static struct fan fan_at(const struct haptable_model* model, struct fan fan, uint16_t patch) {
    fan.patch = patch;
    if (patch != HAPTABLE_NONE) fan.corner = corner_of(model, patch, fan.vertex);
    return fan;
}

struct fan haptable_surface_fan_turned(const struct haptable_model* model, struct fan fan) {
    if (!fan.clockwise && fan_turn(model, &fan) == HAPTABLE_NONE) {
        uint16_t next;
        fan = fan_at(model, fan, fan.first);
        fan.clockwise = 1;
        next = fan_turn(model, &fan);
        if (next != HAPTABLE_NONE) return fan_at(model, fan, next);
    }
    if (!model->hinges) return fan_at(model, fan, HAPTABLE_NONE); /* most bodies */
    fan.first = model->hinges->next_ring(model, fan.vertex, fan.first, fan.begin);
    fan.clockwise = 0;
    return fan_at(model, fan, fan.first);
}
