/* SPDX-License-Identifier: MIT
 *
 * The image that shows that a target computes what the host computes. Its words: replay IN OUT, files by semihosting:
 * a path in, ticks out (haptable_ticks.h).
 */
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "haptable_ticks.h"
#include "haptable_tool.h"
#include "model.h"

static HAPTABLE_MODEL_STATE scene_state;
static const struct haptable_tool_model* const tool = HAPTABLE_MODEL_TOOL;

int haptable_port_main(void) {
    int in;
    int out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    if (tool)
        haptable_ticks_replay_tool(&HAPTABLE_MODEL_SCENE, &scene_state, in, out);
    else
        haptable_ticks_replay(&HAPTABLE_MODEL_SCENE, &scene_state, in, out);
    return 0;
}
