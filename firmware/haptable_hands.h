/* SPDX-License-Identifier: MIT
 *
 * Three fingers and more that are hands of their own: points that each have a position and feel their own load
 *
 * One or two fingers have haptable_servo.c and haptable_pair_servo.c, which more kinds of scenes take.
 */
#ifndef HAPTABLE_HANDS_H
#define HAPTABLE_HANDS_H

#include "haptable_points.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state behind the fingers' servos, before their points and the system. */
struct haptable_hands {
    struct haptable_model model; /* the scene's, with the points' force and the nearest god-object */
    const struct haptable_points_model* of;
    float given_j;       /* with passivity: energy given to all hands, less what was taken */
    float brake_n_per_m; /* with passivity: what takes it back */
    struct haptable_points points;
};

haptable_init_fn haptable_init_hands;
haptable_step_fn haptable_step_hands;
haptable_force_fn haptable_hands_force;
haptable_finish_fn haptable_hands_brake;

/* State layout of fingers whose number is known at run time. */
struct haptable_hands_room {
    struct haptable_servo servo[HAPTABLE_HANDS];
    struct haptable_hands hands;
    struct haptable_point point[HAPTABLE_HANDS];
    float system[HAPTABLE_POINTS_SETTLING_SYSTEM(HAPTABLE_HANDS)];
};

/* Makes a scene of tables that are known at run time, and its points, which the scene names. before: pair->finger_count
 * is 3 to HAPTABLE_HANDS. */
void haptable_hands_scene_make(const struct haptable_pair_model* pair, struct haptable_points_model* points,
                               struct haptable_points_scene* scene);

#ifdef __cplusplus
}
#endif

#endif
