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
    static char text[512];
    const char* word[3] = {0, 0, 0};
    int in;
    int out;
    if (semihosting_words(text, sizeof text, word, 3) != 3) return 64;
    in = semihosting_open(word[1], SEMIHOSTING_READ);
    out = semihosting_open(word[2], SEMIHOSTING_WRITE);
    if (in < 0 || out < 0) return 66;
    ticks_replay(&HAPTABLE_MODEL, in, out);
    return 0;
}
