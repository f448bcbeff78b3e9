// SPDX-License-Identifier: GPL-2.0-or-later
// What somebody should know who left [contact] out.
#pragma once

#include <string>

namespace haptable {

/// Lines for people, of a scene in the paper's own mode (interpolated, nearest): why its finger is not the body's, and
/// what to write for one with a size.
///   radius_m  of a finger that fits the body
std::string finger_advice(double radius_m = 0.005);

}  // namespace haptable
