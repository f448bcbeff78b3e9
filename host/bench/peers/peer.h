/* SPDX-License-Identifier: GPL-2.0-or-later */
/* A haptic library that haptable-contact times beside the servo, as a shared library of its own (make peers). */
#ifndef HAPTABLE_BENCH_PEER_H
#define HAPTABLE_BENCH_PEER_H

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A rigid closed surface: points, m, three a point; patches, three points each, counter-clockwise from outside. Its
 * stiffness, N/m; Coulomb's coefficients, 0: none. It lives as long as the process. */
void* haptable_peer_make(const double* point_m, const int* patch, int patches, double stiffness_n_per_m,
                         double static_friction, double dynamic_friction);
/* A new session: the proxy is at the finger. */
void haptable_peer_begin(void* peer, const double finger_m[3]);
/* One tick of a millisecond: the force on the finger, N. */
void haptable_peer_step(void* peer, const double finger_m[3], double force_n[3]);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
