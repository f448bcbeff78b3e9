/* SPDX-License-Identifier: MIT
 *
 * The release of a body whose dents are linear
 */
#include "haptable_release.h"

void haptable_release_slew(const struct haptable_model* model, struct haptable_servo* servo, const float motion_m[3],
                           float force_n[3]) {
    release_slew(model, servo, 0, motion_m, force_n);
}
