/* SPDX-License-Identifier: MIT
 *
 * The image that shows that a target computes what the host computes. Its words: replay IN OUT, files by semihosting:
 * a path in, ticks out (ticks.h).
 */
#include "model.h"
#include "port.h"
#include "semihosting.h"
#include "ticks.h"

int port_main(void) {
    int in;
    int out;
    const int status = semihosting_files(&in, &out);
    if (status != 0) return status;
    ticks_replay(&HAPTABLE_MODEL, in, out);
    return 0;
}
