/* SPDX-License-Identifier: MIT
 *
 * The image that shows that a target computes what the host computes, of a scene with two fingers. Its words: pair IN
 * OUT, files by semihosting: a path in, records out (haptable_pair_ticks.h).
 */
#include "haptable_pair_ticks.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "model.h"

int haptable_port_main(void) {
    int in;
    int out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    haptable_pair_ticks_replay(HAPTABLE_MODEL_PAIR, in, out);
    return 0;
}
