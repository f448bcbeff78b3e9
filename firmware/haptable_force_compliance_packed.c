/* SPDX-License-Identifier: MIT
 *
 * F = -C^-1 u with blocks in 16 bits, expanded on the stack
 */
#include "haptable_polynomial.h"

#define HAPTABLE_STORED(name) name##_packed
#define HAPTABLE_GATHER gather_packed
#include "haptable_compliance_template.h"

void haptable_force_consistent_packed(const struct haptable_model* model, const struct haptable_contact* contact,
                                      const float finger_m[3], float nodal_force_n[3][3], float force_n[3]) {
    force_of_packed(model, &consistent_form, contact, finger_m, nodal_force_n, force_n);
}
