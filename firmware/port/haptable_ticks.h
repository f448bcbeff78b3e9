/* SPDX-License-Identifier: MIT
 *
 * positions (float32[fingers][3], raw) -> haptable_step, a millisecond apart -> a record a tick
 *
 * A record, in words: of each finger state, patch, alpha[3], god_object_m[3], force_n[3]; where nothing holds the body
 * position_m[3] and turn[4] after the tick; where it rings q of each mode.
 */
#ifndef HAPTABLE_TICKS_H
#define HAPTABLE_TICKS_H

#include "haptable_scene.h"

/* Steps a fresh state through what is left of file `in`, between the marks of haptable_port.h, and writes the records
 * to `out`. before: state has scene->bytes. */
void haptable_ticks_replay(const struct haptable_scene* scene, void* state, int in, int out);

/* The same of a tool, whose path has the handle's position and the vector part of its turn, of less than half; a record
 * has, in words, what a finger's has and torque_n_m[3]. */
void haptable_ticks_replay_tool(const struct haptable_scene* scene, void* state, int in, int out);

#endif
