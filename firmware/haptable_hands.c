/* SPDX-License-Identifier: MIT
 *
 * fingers -> checked -> god-objects -> loads of all -> forces -> checked -> limited -> out
 */
#include "haptable_hands.h"

#include "haptable_tick.h"

static const struct haptable_points_model* points_of(const struct haptable_scene* scene) {
    return ((const struct haptable_points_scene*)scene)->points; /* the scene is its first member */
}

static struct haptable_hands* hands_of(const struct haptable_points_model* of, void* state) {
    return (struct haptable_hands*)haptable_points_byte(
        state, of->state_at - (uint32_t)offsetof(struct haptable_hands, points));
}

void haptable_hands_force(const struct haptable_model* model, const struct haptable_contact* contact,
                          const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    const struct haptable_hands* hands = (const struct haptable_hands*)model; /* the model is its first member */
    const struct haptable_points_model* of = hands->of;
    const unsigned char* state = (const unsigned char*)&hands->points - of->state_at;
    const struct haptable_servo* first = (const struct haptable_servo*)(state + of->servos_at);
    const struct haptable_servo* servo =
        (const struct haptable_servo*)((const unsigned char*)contact - offsetof(struct haptable_servo, contact));
    const struct haptable_point* point = (const struct haptable_point*)(state + of->points_at) + (servo - first);
    (void)finger_m;
    of->pair->law->load(model, contact, point->load_n, nodal_force_n, force_n);
}

void haptable_hands_brake(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                          float force_n[3]) {
    (void)servo;
    haptable_brake(model, ((const struct haptable_hands*)model)->brake_n_per_m, motion_m, force_n);
}

/* The energy of the last tick's forces over all motions, and what takes back what was given. */
static void observe(struct haptable_hands* hands, const struct haptable_servo servo[], const uint8_t goes_on[],
                    float (*motion_m)[3]) {
    float motion2 = 0.0f;
    for (uint32_t i = 0; i < hands->of->count; ++i) {
        if (!goes_on[i]) continue;
        hands->given_j += vec_dot(servo[i].given_n, motion_m[i]);
        motion2 += vec_length2(motion_m[i]);
    }
    hands->brake_n_per_m = haptable_brake_of(&hands->model, hands->given_j, motion2);
}

/* What a finger is given at the god-object that bears its load; the nearest one goes on from where it is. */
static void give(const struct haptable_hands* hands, struct haptable_servo* servo, const struct haptable_point* point,
                 const float motion_m[3], struct haptable_output* out) {
    const struct haptable_contact nearest = servo->contact;
    if (point->is_inside) servo->contact = point->at;
    finish_tick(&hands->model, servo, motion_m, out);
    servo->contact = nearest;
}

void haptable_step_hands(const struct haptable_scene* scene, void* state, const struct haptable_input in[],
                         uint32_t now_us, struct haptable_output out[]) {
    const struct haptable_points_model* of = points_of(scene);
    struct haptable_hands* hands = hands_of(of, state);
    struct haptable_servo* servo = haptable_points_servos(of, state);
    float motion_m[HAPTABLE_HANDS][3];
    uint8_t goes_on[HAPTABLE_HANDS] = {0};
    haptable_scene_begin(scene, state, in, now_us, out);
    for (uint32_t i = 0; i < of->count; ++i) {
        vec_zero(motion_m[i]);
        goes_on[i] = in[i].is_there && begin_tick(&hands->model, &servo[i], in[i].finger_m, now_us, &out[i]) ? 1u : 0u;
        if (goes_on[i]) move(&hands->model, &servo[i], in[i].finger_m, motion_m[i]);
        haptable_point_see(of, state, i);
    }
    haptable_points_tick(of, state);
    if (hands->model.passivity) observe(hands, servo, goes_on, motion_m);
    for (uint32_t i = 0; i < of->count; ++i)
        if (goes_on[i]) give(hands, &servo[i], &haptable_points_in(of, state)[i], motion_m[i], &out[i]);
}

void haptable_init_hands(const struct haptable_scene* scene, void* state) {
    const struct haptable_points_model* of = points_of(scene);
    struct haptable_hands* hands = hands_of(of, state);
    hands->of = of;
    haptable_points_take_model(scene->model, haptable_hands_force, haptable_hands_brake, &hands->model);
    for (uint32_t i = 0; i < of->count; ++i) {
        haptable_servo_begin(&haptable_points_servos(of, state)[i]);
        haptable_points_servos(of, state)[i].finger = (uint8_t)i;
    }
}
