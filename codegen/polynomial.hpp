// SPDX-License-Identifier: GPL-2.0-or-later
// C(alpha) = sum_n degree! / (n_0! n_1! n_2!) alpha^n B_n on a patch, in double: what the firmware evaluates in float.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "codegen/model.hpp"

namespace haptable {

/// Bernstein's polynomials of a degree at a point of any patch.
struct BernsteinPoint {
    BernsteinPoint(int degree, const std::array<double, 3>& alpha);
    std::array<double, 3> alpha;
    std::vector<double> weight;  ///< in the order of control_blocks()
};

/// The blocks of a patch's control points, as numbers among haptable_model.packed: all vertices' blocks, then those of
/// edges, then those of patches.
std::vector<std::size_t> control_blocks(const ServoModel& model, std::size_t patch);

/// All blocks of the model's compliance in that order.
std::vector<std::array<float, 6>> compliance_blocks(const ServoModel& model);

/// C(alpha) of a patch with these control blocks; fixed vertices lift it as the firmware does.
Eigen::Matrix3d compliance_at(const ServoModel& model, std::size_t patch, const std::vector<Eigen::Matrix3d>& control,
                              const BernsteinPoint& point);

/// A block's six numbers as a matrix.
Eigen::Matrix3d symmetric(const std::array<float, 6>& block);

}  // namespace haptable
