/* SPDX-License-Identifier: MIT
 *
 * The release of a body whose dents stiffen: a force that grows by the tangent is no jump
 */
#include "haptable_release.h"

void haptable_release_slew_stiffening(const struct haptable_model* model, struct haptable_servo* servo,
                                      const float motion_m[3], float force_n[3]) {
    release_slew(model, servo, 1, motion_m, force_n);
}
