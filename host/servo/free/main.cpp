// SPDX-License-Identifier: GPL-2.0-or-later
// The servo program of a scene whose body is not held.
#include "host/servo/servo.hpp"
#include "model.h"

int main(int argc, char** argv) {
    return haptable::servo_main(
        argc, argv,
        {&HAPTABLE_MODEL, HAPTABLE_MODEL_NODE, HAPTABLE_MODEL_NAME, HAPTABLE_MODEL_PAIR, HAPTABLE_MODEL_MODES},
        &HAPTABLE_MODEL_BODY);
}
