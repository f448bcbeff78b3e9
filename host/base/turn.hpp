// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Geometry>

namespace haptable {

/// The shortest turn from z to `direction`. Eigen's FromTwoVectors instantiates a singular value decomposition for the
/// one direction that leaves it open, -z: half of the time that a file took to compile.
template <typename Scalar>
Eigen::Quaternion<Scalar> turn_from_z(const Eigen::Matrix<Scalar, 3, 1>& direction) {
    const Eigen::Matrix<Scalar, 3, 1> to = direction.normalized();
    constexpr Scalar kOpposite = Scalar(1e-6) - 1;
    if (to.z() < kOpposite) return {0, 1, 0, 0};
    return Eigen::Quaternion<Scalar>(1 + to.z(), -to.y(), to.x(), 0).normalized();
}

}  // namespace haptable
