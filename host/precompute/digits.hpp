// SPDX-License-Identifier: GPL-2.0-or-later
// Where the digits of the force go: to the condition of K in double, and to the servo's float32.
#pragma once

#include <string>
#include <vector>

#include "host/precompute/summary.hpp"

namespace haptable {

/// Relative errors of the force.
struct Digits {
    /// Error of S = (L_ii)^-1: double rounding x condition of K, scaled to a diagonal of 1, x that of L_ii;
    /// where blocks were found in float, at least the tolerance that was asked for.
    double inverse = 0.0;
    ServoError servo;  ///< of the servo's float32, measured
};
Digits digits_of(const Summary& summary);

/// "  digits of the force ...": two lines for people.
std::string describe(const Digits& digits, const Summary& summary);

/// "SCENE: float32 loses ...": where either is above kMostServoError, with the number, its cause and what helps.
std::vector<std::string> digit_warnings(const Scene& scene, const Summary& summary);

}  // namespace haptable
