// SPDX-License-Identifier: GPL-2.0-or-later
// One poke, without a CSV: what a finger feels that is pushed straight into the body.
#pragma once

#include <Eigen/Core>
#include <string>

#include "host/session/scene.hpp"

namespace haptable {

struct Poke {
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< where the surface is touched
    Eigen::Vector3d direction{0.0, 0.0, -1.0};       ///< into the body; any length but zero
    double depth_m = 0.005;                          ///< of the finger beyond `at`
};

/// At its end, the finger at rest.
struct Poked {
    Eigen::Vector3d finger_m, god_object_m, force_n;
    std::array<std::int32_t, 3> node{};  ///< mesh nodes of the patch that is touched
    double depth_m = 0.0;                ///< from god-object to finger
};

/// "X,Y,Z" in metres, or "top": the touchable surface over or nearest to the middle of its box, at its highest.
/// Throws Error for anything else.
Eigen::Vector3d place_of(const std::string& text, const haptable_model& model);

/// Pushes the finger in at 20 mm/s from a centimetre outside, and holds it for 0.1 s, for 5 s where the body rings.
/// Throws Error, which says where the body is, where it never met it.
Poked poke(const ServoScene& scene, const Poke& poke);

/// "the touchable surface lies in (x y z) to (x y z) m".
std::string where_it_is(const haptable_model& model);

}  // namespace haptable
