/* SPDX-License-Identifier: MIT
 *
 * s = scale * half
 */
#include "haptable_model.h"

/* IEEE 754 binary16 to float, exactly: its exponent and fraction as a float's are 2^112 too small. Subnormal halves
 * come right too where the processor does not flush subnormals to zero. before: half is finite (codegen saw to it). */
static float widened(uint16_t half) {
    union {
        uint32_t bits;
        float number;
    } value;
    value.bits = (uint32_t)(half & 0x7fffu) << 13;
    value.number *= 0x1p112f;
    value.bits |= (uint32_t)(half & 0x8000u) << 16;
    return value.number;
}

void haptable_unpack_float16(const struct haptable_model* model, uint32_t block, float s[6]) {
    for (int i = 0; i < 6; ++i) s[i] = model->packed_scale[0] * widened(model->packed[block][i]);
}
