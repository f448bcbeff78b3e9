/* SPDX-License-Identifier: MIT */
#include "hand.h"

static double norm(const double v[3]) { return __builtin_sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

void page_hand_place(struct page_hand* hand, const double at_m[3]) {
    int a;
    for (a = 0; a < 3; ++a) {
        hand->position_m[a] = at_m[a];
        hand->velocity_m_s[a] = hand->force_n[a] = 0.0;
    }
}

void page_hand_force(struct page_hand* hand, const double force_n[3]) {
    const double size_n = norm(force_n);
    const double share = size_n > hand->max_force_n ? hand->max_force_n / size_n : 1.0;
    int a;
    for (a = 0; a < 3; ++a) hand->force_n[a] = share * force_n[a];
}

void page_hand_advance(struct page_hand* hand, const double goal_m[3], const double goal_m_s[3], double step_s) {
    const double inertia = 2.0 * hand->mass_kg / step_s, k = hand->stiffness_n_per_m, c = hand->hand_damping_n_s_per_m;
    const double all = inertia + k * step_s / 2.0 + c + hand->damping_n_s_per_m;
    double r[3], size, share;
    int a;
    for (a = 0; a < 3; ++a)
        r[a] = inertia * hand->velocity_m_s[a] + k * (goal_m[a] - hand->position_m[a]) + c * goal_m_s[a] +
               hand->force_n[a];
    size = norm(r);
    share = size > hand->friction_n ? (1.0 - hand->friction_n / size) / all : 0.0;
    for (a = 0; a < 3; ++a) {
        const double w = share * r[a];
        hand->position_m[a] += step_s * w;
        hand->velocity_m_s[a] = share > 0.0 ? 2.0 * w - hand->velocity_m_s[a] : 0.0;
    }
}

void page_hand_encoders(const struct page_hand* hand, float at_m[3]) {
    const double step_m = hand->encoder_step_m;
    int a;
    for (a = 0; a < 3; ++a) {
        const double x = hand->position_m[a];
        at_m[a] = (float)(step_m > 0.0 ? __builtin_floor(x / step_m + 0.5) * step_m : x);
    }
}
