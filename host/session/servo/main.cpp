// SPDX-License-Identifier: GPL-2.0-or-later
// The servo program of one scene: model.h, which codegen wrote, says which.
#include "host/session/servo/servo.hpp"
#include "model.h"

int main(int argc, char** argv) {
    const haptable_scene& scene = HAPTABLE_MODEL_SCENE;
    return haptable::servo_main(argc, argv,
                                {scene.model, HAPTABLE_MODEL_NODE, HAPTABLE_MODEL_NAME, scene.pair, scene.modes,
                                 scene.body, HAPTABLE_MODEL_TOOL});
}
