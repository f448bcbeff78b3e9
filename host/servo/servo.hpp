// SPDX-License-Identifier: GPL-2.0-or-later
// The command line of build/<name>/servo.
#pragma once

#include "firmware/haptable_body.h"
#include "host/session/scene.hpp"

namespace haptable {

/// Runs the servo of one scene: --replay or --lcm. Returns the exit status. body: of one that nothing
/// holds.
int servo_main(int argc, char** argv, const ServoScene& scene, const haptable_body* body = nullptr);

}  // namespace haptable
