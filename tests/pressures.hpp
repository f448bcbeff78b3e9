// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffnesses with pressures, for the tests of their factor.
#pragma once

#include <random>

#include "host/body/body.hpp"
#include "host/inverse/stiffness.hpp"

namespace haptable::test {

/// A body of tetrahedra that share lambda at their corners: lambda_e = 0, theta_a = sum_e V_e / 4 div u / V_a. Its
/// pressures are those of all nodes, fixed ones among them. Below z = 15 mm it is `ratio` times as stiff; where the two
/// materials meet, a node has a pressure of each.
Stiffness pressure_stiffness(const Body& body, double poisson, double ratio = 1.0);
/// Of the paper's cube, its bottom fixed.
Stiffness pressure_cube(int nodes_per_side, double poisson, double ratio = 1.0);

/// A and G at random: `nodes` unknown nodes, one pressure for each but every fifth, which has two, and three pressures
/// of no unknown node. G is `weight` times as large as A's square root: K / A goes with its square.
Stiffness random_stiffness(Eigen::Index nodes, double weight, std::mt19937& random);

}  // namespace haptable::test
