// SPDX-License-Identifier: GPL-2.0-or-later
// The command line of build/<name>/servo.
#pragma once

#include "host/session/scene.hpp"

namespace haptable {

/// Runs the servo of one scene: --replay or --lcm. Returns the exit status.
int servo_main(int argc, char** argv, const ServoScene& scene);

}  // namespace haptable
