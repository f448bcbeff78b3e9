/* SPDX-License-Identifier: MIT
 *
 * m x'' = k (x_t - x) + c (v_t - x') - b x' - f x'/|x'| + F: the pointer's finger. The same hand, device and step as
 * host/device/point_device.cpp, which derives it; here without a library, for a page.
 */
#ifndef PAGE_HAND_H
#define PAGE_HAND_H

/* The device and the hand that holds it. SI; all but mass_kg may be 0. */
struct page_hand {
    double mass_kg, damping_n_s_per_m, friction_n, max_force_n;
    double encoder_step_m; /* 0: encoders that see all */
    double stiffness_n_per_m, hand_damping_n_s_per_m;
    double position_m[3], velocity_m_s[3];
    double force_n[3]; /* of the motors, at most max_force_n */
};

/* At rest at a place, without a force. */
void page_hand_place(struct page_hand* hand, const double at_m[3]);

/* Sets the motors' force, cut to max_force_n with its direction kept. */
void page_hand_force(struct page_hand* hand, const double force_n[3]);

/* step_s > 0 further, the goal and its velocity being those of the middle of the step. Stable for every step. */
void page_hand_advance(struct page_hand* hand, const double goal_m[3], const double goal_m_s[3], double step_s);

/* What the encoders read. */
void page_hand_encoders(const struct page_hand* hand, float at_m[3]);

#endif
