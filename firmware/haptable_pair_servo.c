/* SPDX-License-Identifier: MIT
 *
 * Both god-objects, one after the other; then [A_1 X; X^T A_2] v = s once, and the forces of both
 *
 * A god-object that goes by the energy, or by friction, is told of the other finger by its model: a copy whose energy
 * and force are the pair's. It goes downhill in the energy of both while the other stays, so a tick gives no energy,
 * however often the two would have to take turns to rest.
 */
#include "haptable_pair.h"

#include "haptable_contact.h"
#include "haptable_pair_terms.h"
#include "haptable_tick.h"

/* ---- what a finger is told of the other ----------------------------------------------------------------------- */

/* A finger's place of the position x. */
static void own_of(const struct haptable_pair_model* tables, const struct haptable_pair* pair, int finger,
                   const float x_m[3], struct haptable_pair_own* own) {
    float felt_m[3];
    pair_felt(&pair->view[finger], x_m, felt_m);
    tables->law->own(tables->model, &pair->servo[finger].contact, felt_m, own);
}

static int has_contact(const struct haptable_servo* servo) { return servo->contact.patch != HAPTABLE_NONE; }

/* One that holds the surface is not let go. */
static int grabs(const struct haptable_servo* servo) { return (servo->buttons & HAPTABLE_BUTTON_GRAB) != 0; }

static void forget_sensitivity(struct haptable_servo* servo) {
    vec_zero(servo->sensitivity_per_m[0]);
    vec_zero(servo->sensitivity_per_m[1]);
}

/* Before a finger moves alone. A god-object that has rested moves with the other finger too. One that has no contact
 * meets the surface as if alone (see begin_contacts). */
static void tell(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                 const float finger_m[3], const float other_m[3]) {
    const int other = 1 - finger;
    struct haptable_pair_view* view = &pair->view[finger];
    struct haptable_servo* servo = &pair->servo[finger];
    struct haptable_pair_own own;
    view->is_coupled = has_contact(servo) && has_contact(&pair->servo[other]) && pair->touches[other];
    if (!has_contact(servo)) vec_zero(view->raised_m);
    if (!view->is_coupled) return;
    own_of(tables, pair, other, other_m, &own);
    haptable_pair_tell(view, &pair->servo[other].contact, &own);
    haptable_pair_put_rows(tables, pair, finger, servo->contact.patch);
    if (gap2(finger_m, servo->finger_m) <= 0.0f) forget_sensitivity(servo);
}

/* ---- the pair ---------------------------------------------------------------------------------------------------- */

/* passivity: takes back what both hands were given, from both as they move. */
static void brake(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                  float force_n[3]) {
    (void)servo;
    haptable_brake(model, pair_view_of(model)->brake_n_per_m, motion_m, force_n);
}

/* One that is alone touches but where it has come out of its dent, as the other has left. */
static void solve_one(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger, int is_off) {
    const struct haptable_servo* servo = &pair->servo[finger];
    struct haptable_pair_view* view = &pair->view[finger];
    float* v = view->v;
    struct haptable_pair_own own;
    float u[3], dent[3];
    own_of(tables, pair, finger, servo->finger_m, &own);
    haptable_pair_inwards(view, &servo->contact, servo->finger_m, u);
    vec_sub(servo->finger_m, servo->contact.god_object_m, dent);
    pair_felt(view, dent, dent);
    const struct sym_factored factored = sym_factor(own.a);
    sym_solve(&factored, own.s, v);
    pair->touches[finger] = !is_off && (!(vec_dot(u, dent) < 0.0f) || grabs(servo));
    pair->touches[1 - finger] = 0;
    if (!pair->touches[finger]) vec_zero(v);
    pair->energy_j = 0.5f * vec_dot(own.s, v);
}

/* ---- a surface that the other has raised ---------------------------------------------------------------------- */

/* Outward, of any length. */
static void normal_of(const struct haptable_pair_model* tables, const struct haptable_pair* pair, int finger,
                      float normal[3]) {
    float edge[2][3];
    patch_frame(tables->model, pair->servo[finger].contact.patch, edge[0], edge[1], normal);
}

/* Two contacts, and what couples them: X. */
struct coupled {
    struct haptable_pair_own own[HAPTABLE_FINGERS];
    float x[9];
};

/* Tells the other finger of this one. */
static void tell_other(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                       struct coupled* both) {
    own_of(tables, pair, finger, pair->servo[finger].finger_m, &both->own[finger]);
    haptable_pair_tell(&pair->view[1 - finger], &pair->servo[finger].contact, &both->own[finger]);
}

static void couple(const struct haptable_pair_model* tables, struct haptable_pair* pair, struct coupled* both) {
    tell_other(tables, pair, 0, both);
    tell_other(tables, pair, 1, both);
    haptable_pair_cross_of_both(tables, pair, &pair->servo[0].contact, both->x);
}

/* How far the other finger, pressing alone, has moved the surface at this one's contact. */
static void moved_by_other(const struct haptable_pair_model* tables, const struct haptable_pair* pair, int finger,
                           const struct coupled* both, float moved_m[3]) {
    float pressed[3];
    haptable_pair_pressed(&pair->view[finger], finger, both->x, pressed);
    if (tables->law->is_stiffness)
        vec_symmetric_product(pair->view[1 - finger].m, pressed, moved_m);
    else
        vec_copy(pressed, moved_m);
    if (tables->law->stiffening) tables->law->stiffening->straighten(tables->model, both->own[finger].a, moved_m);
}

/* Sets raised_m to where the surface was moved, but along the outward normal to `along`, of the normal's length. */
static void put_raised(const struct haptable_pair_model* tables, const float moved_m[3], const float normal[3],
                       float along, float raised_m[3]) {
    if (!tables->energy && !(along > 0.0f)) { /* a nearest god-object's tangent is the law's */
        vec_zero(raised_m);
        return;
    }
    vec_copy(moved_m, raised_m);
    vec_add_scaled((along - vec_dot(normal, moved_m)) / vec_dot(normal, normal), normal, raised_m);
}

/* A finger that meets a surface that the other has moved begins there with no force, as at a body at rest; what the
 * other has lowered it has still to reach. */
static void begin_on_raised(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger) {
    struct coupled both;
    float normal[3], moved_m[3];
    normal_of(tables, pair, finger, normal);
    couple(tables, pair, &both);
    moved_by_other(tables, pair, finger, &both, moved_m);
    const float along = vec_dot(normal, moved_m);
    put_raised(tables, moved_m, normal, along > 0.0f ? along : 0.0f, pair->view[finger].raised_m);
}

/* A finger that gave no force begins anew where it is: the surface that it had met is lower now, or was aside. As it is
 * left behind its god-object goes to the nearest point, and begins there. Returns 1 where it does not press yet. both:
 * NULL where the other has no contact. */
static int begin_again(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                       struct coupled* both) {
    float* raised_m = pair->view[finger].raised_m;
    float normal[3];
    float moved_m[3] = {0.0f, 0.0f, 0.0f};
    float raised_before_m[3];
    normal_of(tables, pair, finger, normal);
    vec_copy(raised_m, raised_before_m);
    if (both && pair->touches[1 - finger]) moved_by_other(tables, pair, finger, both, moved_m);
    vec_sub(moved_m, pair->servo[finger].finger_m, moved_m);
    vec_add_scaled(1.0f, pair->servo[finger].contact.god_object_m, moved_m);
    float along = vec_dot(normal, moved_m); /* from the finger up to the surface */
    const float was = vec_dot(normal, raised_m);
    const int presses = was < along && (!tables->energy || pair->view[finger].left_ticks > 1);
    if (presses) along = was;
    put_raised(tables, moved_m, normal, along > 0.0f ? along : 0.0f, raised_m);
    if (both && gap2(raised_m, raised_before_m) > 0.0f) tell_other(tables, pair, finger, both);
    return !presses;
}

/* Of two that meet the surface at once neither has moved it yet. */
static void begin_contacts(const struct haptable_pair_model* tables, struct haptable_pair* pair) {
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        const struct haptable_servo* servo = &pair->servo[f];
        struct haptable_pair_view* view = &pair->view[f];
        if (!has_contact(servo)) pair->touches[f] = 0;
        if (has_contact(servo) && view->met == servo->counters.contacts) continue;
        view->is_new = (uint8_t)has_contact(servo);
        if (view->is_new) pair->touches[f] = 1;
        view->met = servo->counters.contacts;
        vec_zero(view->raised_m);
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        if (pair->view[f].is_new && !pair->view[1 - f].is_new && pair->touches[1 - f]) begin_on_raised(tables, pair, f);
}

/* Those that gave no force before this tick, and which of them do not yet. */
static void begin_left(const struct haptable_pair_model* tables, struct haptable_pair* pair, struct coupled* both,
                       int is_off[HAPTABLE_FINGERS]) {
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        struct haptable_pair_view* view = &pair->view[f];
        is_off[f] = 0;
        if (!has_contact(&pair->servo[f]) || view->is_new || pair->touches[f]) continue;
        if (view->left_ticks < 2) ++view->left_ticks;
        is_off[f] = begin_again(tables, pair, f, both) && !grabs(&pair->servo[f]);
    }
}

/* Of four cases, which fingers touch: both; one, where it has dented the surface away from the other; or none. Where
 * each would leave the other behind, both do touch. */
static void solve_two(struct haptable_pair* pair, struct coupled* both, const int is_off[HAPTABLE_FINGERS]) {
    const struct haptable_contact* const at[HAPTABLE_FINGERS] = {&pair->servo[0].contact, &pair->servo[1].contact};
    const float* const x_m[HAPTABLE_FINGERS] = {pair->servo[0].finger_m, pair->servo[1].finger_m};
    const struct haptable_pair_own* const owns[HAPTABLE_FINGERS] = {&both->own[0], &both->own[1]};
    struct pair_system system;
    int touches[HAPTABLE_FINGERS];
    (void)haptable_pair_solve(&pair->view[0], owns[0], both->x, &system);
    haptable_pair_touch(pair, at, x_m, owns, both->x, system.v, touches);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) touches[f] = !is_off[f] && (touches[f] || grabs(&pair->servo[f]));
    pair->energy_j = 0.0f;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        float* v = pair->view[f].v;
        pair->touches[f] = (uint8_t)(touches[f] || touches[0] == touches[1]);
        if (touches[0] == touches[1])
            vec_copy(system.v[f], v);
        else if (touches[f])
            vec_copy(pair->view[1 - f].alone, v);
        else
            vec_zero(v);
        pair->energy_j += 0.5f * vec_dot(owns[f]->s, v);
    }
}

static void solve_pair(const struct haptable_pair_model* tables, struct haptable_pair* pair) {
    const int first = has_contact(&pair->servo[0]);
    const int second = has_contact(&pair->servo[1]);
    struct coupled both;
    int is_off[HAPTABLE_FINGERS];
    begin_contacts(tables, pair);
    if (first && second) couple(tables, pair, &both);
    begin_left(tables, pair, first && second ? &both : 0, is_off);
    pair->view[0].is_solved = pair->view[1].is_solved = 1;
    if (first && second) {
        solve_two(pair, &both, is_off);
    } else if (first || second) {
        solve_one(tables, pair, first ? 0 : 1, is_off[first ? 0 : 1]);
    } else {
        pair->touches[0] = pair->touches[1] = 0;
        pair->energy_j = 0.0f;
    }
}

/* ---- a tick --------------------------------------------------------------------------------------------------- */

void haptable_pair_init(const struct haptable_pair_model* tables, struct haptable_pair* pair) {
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger) {
        struct haptable_pair_view* view = &pair->view[finger];
        haptable_servo_init(&pair->servo[finger]);
        pair->servo[finger].finger = (uint8_t)finger;
        view->model = *tables->model;
        view->model.force = haptable_pair_force;
        view->model.energy = tables->energy;
        if (view->model.passivity) view->model.passivity = brake;
        if (tables->law->stiffening) tables->law->stiffening->see(&view->model);
        view->tables = tables;
        view->is_coupled = view->is_solved = 0;
        view->brake_n_per_m = 0.0f;
        view->share = 1.0f;
        view->met = 0;
        view->is_new = view->left_ticks = 0;
        vec_zero(view->raised_m);
        vec_zero(view->v);
        view->rows[0].patch = view->rows[1].patch = HAPTABLE_NONE;
        pair->touches[finger] = 0;
        pair->net.patch[finger] = HAPTABLE_NONE;
        pair->net.is_read = 0;
    }
    pair->is_following = 0;
    pair->evaluations = 0;
    pair->looks = 0;
    pair->energy_j = 0.0f;
    pair->given_j = 0.0f;
}

/* 1 where the other's dent left it behind in the last tick. */
static int is_left(const struct haptable_pair* pair, int finger) {
    return has_contact(&pair->servo[finger]) && has_contact(&pair->servo[1 - finger]) && !pair->touches[finger];
}

/* One that is left behind gives no force: it goes to the nearest point, where the surface would meet it again. */
static void move_finger(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                        const float finger_m[3], const float other_m[3], float motion_m[3]) {
    struct haptable_model* model = &pair->view[finger].model;
    struct haptable_servo* servo = &pair->servo[finger];
    if (!(tables->energy || tables->model->frictionless)) {
        move(model, servo, finger_m, motion_m);
    } else if (is_left(pair, finger)) {
        model->god_object = haptable_god_object_nearest;
        move(model, servo, finger_m, motion_m);
        model->god_object = tables->model->god_object;
        forget_sensitivity(servo);
        vec_zero(servo->contact.load_n);
    } else {
        tell(tables, pair, finger, finger_m, other_m);
        move(model, servo, finger_m, motion_m);
    }
}

/* The energy of the last tick's forces over both motions, and what takes back what is given. */
static void observe(struct haptable_pair* pair, float motion_m[HAPTABLE_FINGERS][3]) {
    float motion2 = 0.0f;
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger) {
        pair->given_j += vec_dot(pair->servo[finger].given_n, motion_m[finger]);
        motion2 += vec_dot(motion_m[finger], motion_m[finger]);
    }
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        pair->view[finger].brake_n_per_m = haptable_brake_of(&pair->view[finger].model, pair->given_j, motion2);
}

/* Each looks at its finger from where both have settled, and may let go, or go over to where less is stored. */
static void look_both(struct haptable_pair* pair, const float* const finger_m[HAPTABLE_FINGERS]) {
    float motion_m[3];
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger) {
        struct haptable_servo* servo = &pair->servo[finger];
        const uint32_t contacts = servo->counters.contacts;
        move(&pair->view[finger].model, servo, finger_m[finger], motion_m);
        if (!has_contact(servo) || servo->counters.contacts != contacts)
            pair->is_following = pair->view[0].is_solved = pair->view[1].is_solved = 0;
    }
}

/* Where both rest, the one gives no force. */
static void leave_behind(const struct haptable_pair_model* tables, struct haptable_pair* pair) {
    const int other = pair->touches[0] ? 0 : 1;
    if (!has_contact(&pair->servo[0]) || !has_contact(&pair->servo[1])) return;
    vec_zero(pair->view[1 - other].v);
    solve_one(tables, pair, other, 0);
    pair->view[0].is_solved = pair->view[1].is_solved = 1;
}

/* Both god-objects of a tick: together where they rest so, or else one after the other. */
static void move_both(const struct haptable_pair_model* tables, struct haptable_pair* pair,
                      const float* const finger_m[HAPTABLE_FINGERS], const int goes_on[HAPTABLE_FINGERS],
                      float motion_m[HAPTABLE_FINGERS][3]) {
    const int together = tables->settle && goes_on[0] && goes_on[1];
    const int left = together && (is_left(pair, 0) || is_left(pair, 1));
    if (together && !left) {
        for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger)
            if (pair->servo[finger].finger_known)
                vec_sub(finger_m[finger], pair->servo[finger].finger_m, motion_m[finger]);
        if (tables->settle(tables, pair, finger_m, 0)) {
            look_both(pair, finger_m);
            return;
        }
    }
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        if (pair->is_following) forget_sensitivity(&pair->servo[finger]); /* was of both */
    pair->is_following = 0;
    for (int finger = 0; finger < HAPTABLE_FINGERS; ++finger)
        if (goes_on[finger])
            move_finger(tables, pair, finger, finger_m[finger], finger_m[1 - finger], motion_m[finger]);
    if (!together) return;
    begin_contacts(tables, pair);
    if (!left && (is_left(pair, 0) || is_left(pair, 1))) { /* as they settled */
        leave_behind(tables, pair);
        return;
    }
    if (left) solve_pair(tables, pair);
    if (is_left(pair, 0) || is_left(pair, 1)) return;
    (void)tables->settle(tables, pair, finger_m, 1); /* as the first rested, the other had not moved */
    if (is_left(pair, 0) || is_left(pair, 1)) leave_behind(tables, pair);
}

/* One tick of the fingers that are there, a bit each; the other stays where it was. */
static void step(const struct haptable_pair_model* tables, struct haptable_pair* pair, unsigned there,
                 const float* const finger_m[HAPTABLE_FINGERS], uint32_t now_us,
                 struct haptable_output* const out[HAPTABLE_FINGERS]) {
    float motion_m[HAPTABLE_FINGERS][3];
    int goes_on[HAPTABLE_FINGERS];
    pair->evaluations = 0;
    pair->net.reads = 0;
    pair->looks = 0;
    for (int f = 0; f < HAPTABLE_FINGERS; ++f) {
        vec_zero(motion_m[f]);
        pair->view[f].is_solved = pair->view[f].is_new = 0;
        if (pair->touches[f]) pair->view[f].left_ticks = 0;
    }
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        goes_on[f] = (there >> f & 1u) != 0u && begin_tick(tables->model, &pair->servo[f], finger_m[f], now_us, out[f]);
    move_both(tables, pair, finger_m, goes_on, motion_m);
    if (!pair->view[0].is_solved) solve_pair(tables, pair);
    if (tables->model->passivity) observe(pair, motion_m);
    for (int f = 0; f < HAPTABLE_FINGERS; ++f)
        if (goes_on[f]) finish_tick(&pair->view[f].model, &pair->servo[f], motion_m[f], out[f]);
}

void haptable_pair_step(const struct haptable_pair_model* tables, struct haptable_pair* pair, const float first_m[3],
                        const float second_m[3], uint32_t now_us, struct haptable_output out[HAPTABLE_FINGERS]) {
    const float* const finger_m[HAPTABLE_FINGERS] = {first_m, second_m};
    struct haptable_output* const each[HAPTABLE_FINGERS] = {&out[0], &out[1]};
    step(tables, pair, 3u, finger_m, now_us, each);
}

void haptable_pair_step_one(const struct haptable_pair_model* tables, struct haptable_pair* pair, int finger,
                            const float finger_m[3], uint32_t now_us, struct haptable_output* out) {
    struct haptable_pair_view* view = &pair->view[finger];
    struct haptable_servo* servo = &pair->servo[finger];
    if (has_contact(servo) && pair_is_raised(view)) {
        const float* const x_m[HAPTABLE_FINGERS] = {finger == 0 ? finger_m : pair->servo[0].finger_m,
                                                    finger == 1 ? finger_m : pair->servo[1].finger_m};
        struct haptable_output* const each[HAPTABLE_FINGERS] = {out, out};
        step(tables, pair, 1u << finger, x_m, now_us, each);
    } else {
        vec_zero(view->raised_m);
        haptable_servo_step(tables->model, servo, finger_m, now_us, out);
        view->met = servo->counters.contacts;
        pair->touches[finger] = (uint8_t)has_contact(servo);
        pair->touches[1 - finger] = 0;
    }
}
