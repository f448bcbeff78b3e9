// SPDX-License-Identifier: GPL-2.0-or-later
// A cube that is not held, and its energy in double.
#pragma once

#include <Eigen/Geometry>

#include "firmware/haptable_body.h"
#include "tests/finger.hpp"

namespace haptable::test {

/// Side and mass of the test's cube; its corner lies at the origin.
constexpr double kSide_m = 0.03, kMass_kg = 0.027;

/// Nothing suspends it, nothing pulls it, and there is no floor.
haptable_body cube_body();
/// The floor below it, at z = height; 8 corners may rest on it.
void add_floor(haptable_body& body, double height_m, double friction);
void add_gravity(haptable_body& body, const Eigen::Vector3d& g = {0.0, 0.0, -9.81});

inline Eigen::Quaterniond turn_of(const haptable_body_state& s) {
    return {double(s.turn[0]), double(s.turn[1]), double(s.turn[2]), double(s.turn[3])};
}
inline Eigen::Vector3d position_of(const haptable_body_state& s) {
    return to_vector(s.position_m) - to_vector(s.position_low_m);
}

/// J: of motion, gravity, suspension, and the floor's springs.
double energy_of(const haptable_body& body, const haptable_body_state& state);

}  // namespace haptable::test
