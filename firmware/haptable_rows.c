/* SPDX-License-Identifier: MIT
 *
 * C = S^-1 of a contact, S by columns: what the load grows by with the finger, the god-object staying
 */
#include "haptable_rows.h"

#include "haptable_vector.h"

/* S u of a contact, whatever the force is made of. */
static void load_of(const struct haptable_model* model, const struct haptable_contact* contact, const float finger_m[3],
                    float load_n[3]) {
    if (model->energy) {
        struct haptable_energy energy;
        model->energy(model, contact, finger_m, HAPTABLE_ENERGY_LOAD, &energy);
        vec_copy(energy.load_n, load_n);
    } else {
        float nodal_n[3][3], force_n[3];
        model->force(model, contact, finger_m, nodal_n, force_n);
        vec_zero(load_n);
        vec_add_scaled(-1.0f, force_n, load_n);
    }
}

/* The finger moves so far, m, for a column of S: its load is linear in that. */
#define UNIT_M 1e-3f

/* How much of the contact's load was given, which was one: limits, and what is owed, may have lowered it. */
static float given_part(const float load_n[3], const float given_n[3]) {
    const float load2 = vec_length2(load_n);
    if (!(load2 > HAPTABLE_NO_FORCE2)) return 0.0f;
    const float share2 = vec_length2(given_n) / load2;
    return share2 < 1.0f ? share2 * vec_inverse_root(share2) : 1.0f;
}

int haptable_rows_alone(const struct haptable_model* model, const struct haptable_servo* servo, int finger,
                        const float load_n[3], float (*a)[HAPTABLE_ROWS]) {
    const struct haptable_contact* contact = &servo->contact;
    const int at = 3 * finger;
    float s[3][3], across[3][3], full_n[3] = {0.0f, 0.0f, 0.0f};
    for (int i = 0; i < 3; ++i) {
        vec_zero(&a[at + i][at]);
        a[at + i][at + i] = 1.0f;
    }
    if (contact->patch == HAPTABLE_NONE || !(vec_length2(load_n) > HAPTABLE_NO_FORCE2)) return 0;
    for (int i = 0; i < 3; ++i) {
        float at_m[3], column_n[3];
        vec_copy(contact->god_object_m, at_m);
        at_m[i] += UNIT_M;
        load_of(model, contact, at_m, column_n);
        vec_zero(s[i]);
        vec_add_scaled(1.0f / (at_m[i] - contact->god_object_m[i]), column_n, s[i]); /* UNIT_M as it was rounded */
        vec_add_scaled(servo->finger_m[i] - contact->god_object_m[i], s[i], full_n);
    }
    for (int i = 0; i < 3; ++i) vec_cross(s[(i + 1) % 3], s[(i + 2) % 3], across[i]);
    const float volume = given_part(full_n, load_n) * vec_dot(s[0], across[0]);
    if (!(volume > 0.0f)) return 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j) a[at + i][at + j] = 0.5f * (across[i][j] + across[j][i]) / volume;
    return 1;
}

unsigned haptable_rows_of_one(const struct haptable_scene* scene, void* state, const struct haptable_past past[],
                              float (*a)[HAPTABLE_ROWS]) {
    return (unsigned)haptable_rows_alone(scene->model, haptable_scene_servo(state, 0), 0, past[0].load_n, a);
}
