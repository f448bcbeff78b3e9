/* SPDX-License-Identifier: MIT
 *
 * s = scale_i * integer
 */
#include "haptable_model.h"

void haptable_unpack_int16(const struct haptable_model* model, uint32_t block, float s[6]) {
    const float scale = model->packed_scale[block];
    for (int i = 0; i < 6; ++i) s[i] = scale * (float)(int16_t)model->packed[block][i];
}
