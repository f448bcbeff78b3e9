// SPDX-License-Identifier: GPL-2.0-or-later
// A finger as the body meets it: a pressure over a round part of its surface, and how far the body gives under it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "host/inverse/inverse.hpp"

namespace haptable {

/// A pressure's form over q = (r / radius)^2 in 0..1; its size does not matter.
using Profile = double (*)(double q);
double smooth_profile(double q);   ///< (1 - q)^2, the mask's
double uniform_profile(double q);  ///< 1: a disc that presses evenly
double hertz_profile(double q);    ///< sqrt(1 - q): a sphere in Hertz's contact

struct Footprint {
    Eigen::Vector3d centre_m;
    double radius_m;
    Profile profile = smooth_profile;
    /// At a point of the surface: 0 outside.
    double pressure(const Eigen::Vector3d& x_m) const;
};

/// Share of the load that each node takes; their sum is 1.
using LoadShares = std::map<std::int32_t, double>;

/// Area coordinates of the middles of pieces^2 equal triangles that a triangle is cut into.
void for_each_piece(int pieces, const std::function<void(const Eigen::Vector3d& alpha)>& visit);

/// Makes their sum 1. Throws Error where there is none: the footprint is not on the surface.
LoadShares normed(LoadShares shares);

/// Integrates a footprint's pressure over triangles against their linear shape functions.
LoadShares shares_on(std::span<const Eigen::Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> triangle,
                     const Footprint& footprint);

/// C = w^T K^-1 w of each load, m/N: the mean displacement, weighted by the pressure, under a force of 1 N.
///   unknown  place of a node among the unknowns of the solver, -1: it is held and adds nothing
std::vector<Eigen::Matrix3d> compliances(const LinearSolver& solver, std::span<const LoadShares> loads,
                                         std::span<const std::int32_t> unknown);

}  // namespace haptable
