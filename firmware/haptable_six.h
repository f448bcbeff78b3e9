/* SPDX-License-Identifier: MIT
 *
 * A x = b of six unknowns, three along axes and three about them. Not inlined: who includes this calls both, and some
 * from two places.
 */
#ifndef HAPTABLE_SIX_H
#define HAPTABLE_SIX_H

#include "haptable_vector.h"

/* A = L D L^T of six unknowns, by A's lower half and in place: L below the diagonal, 1/D on it. */
static void six_factor(float (*a)[6]) {
    float d[6], scaled[6] = {0.0f};
    for (int j = 0; j < 6; ++j) {
        d[j] = a[j][j];
        for (int k = 0; k < j; ++k) {
            scaled[k] = a[j][k] * d[k];
            d[j] -= a[j][k] * scaled[k];
        }
        a[j][j] = 1.0f / d[j];
        for (int i = j + 1; i < 6; ++i) {
            for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * scaled[k];
            a[i][j] *= a[j][j];
        }
    }
}

/* before: six_factor. */
static void six_solve(const float (*a)[6], const float b[6], float x[6]) {
    HAPTABLE_UNROLLED_SIX
    for (int i = 0; i < 6; ++i) {
        float sum = b[i];
        HAPTABLE_UNROLLED_SIX
        for (int k = 0; k < i; ++k) sum -= a[i][k] * x[k]; /* cppcheck-suppress uninitvar ; it is written here */
        x[i] = sum;
    }
    HAPTABLE_UNROLLED_SIX
    for (int i = 5; i >= 0; --i) {
        float sum = x[i] * a[i][i];
        HAPTABLE_UNROLLED_SIX
        for (int k = i + 1; k < 6; ++k) sum -= a[k][i] * x[k];
        x[i] = sum;
    }
}

#endif
