/* SPDX-License-Identifier: MIT
 *
 * u_r = sum over the loaded vertices of L_ri F_i (eq. 8)
 */
#include "haptable_deformation.h"

#include <stddef.h>

#include "haptable.h"
#include "haptable_vector.h"

void haptable_column_float32(const struct haptable_deformation* deformation, uint16_t vertex, const float force_n[3],
                             float (*displacement_m)[3]) {
    const float(*block)[9] = &deformation->column_m_per_n[(size_t)vertex * deformation->row_count];
    for (uint16_t row = 0; row < deformation->row_count; ++row) {
        displacement_m[row][0] += vec_dot(&block[row][0], force_n);
        displacement_m[row][1] += vec_dot(&block[row][3], force_n);
        displacement_m[row][2] += vec_dot(&block[row][6], force_n);
    }
}

static float packed_dot(const int16_t a[3], const float b[3]) {
    return (float)a[0] * b[0] + (float)a[1] * b[1] + (float)a[2] * b[2];
}

void haptable_column_int16(const struct haptable_deformation* deformation, uint16_t vertex, const float force_n[3],
                           float (*displacement_m)[3]) {
    const int16_t(*block)[9] = &deformation->packed[(size_t)vertex * deformation->row_count];
    float scaled[3];
    vec_zero(scaled);
    vec_add_scaled(deformation->packed_scale_m_per_n[vertex], force_n, scaled);
    for (uint16_t row = 0; row < deformation->row_count; ++row) {
        displacement_m[row][0] += packed_dot(&block[row][0], scaled);
        displacement_m[row][1] += packed_dot(&block[row][3], scaled);
        displacement_m[row][2] += packed_dot(&block[row][6], scaled);
    }
}

void haptable_deform(const struct haptable_deformation* deformation, const struct haptable_output* out,
                     float (*displacement_m)[3]) {
    for (uint16_t row = 0; row < deformation->row_count; ++row) vec_zero(displacement_m[row]);
    for (int corner = 0; corner < 3; ++corner)
        if (out->vertex[corner] < deformation->free_count)
            deformation->add(deformation, out->vertex[corner], out->nodal_force_n[corner], displacement_m);
}
