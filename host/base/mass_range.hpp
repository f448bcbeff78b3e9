// SPDX-License-Identifier: GPL-2.0-or-later
// What a body that moves may have, so that its tick is one of numbers in float: tests move bodies at the ends.
#pragma once

namespace haptable {

constexpr double kLeastMass_kg = 1e-6, kMostMass_kg = 1e6;
/// Principal moments about the centre: of a milligram of 0.3 mm, and of a thousand tonnes of 60 m.
constexpr double kLeastInertia_kg_m2 = 1e-14, kMostInertia_kg_m2 = 1e9;
/// Least frequency of its slowest mode; the fastest is below half of 1 kHz.
constexpr double kLeastMode_hz = 0.01;

}  // namespace haptable
