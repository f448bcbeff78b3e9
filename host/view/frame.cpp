// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/frame.hpp"

#include <cmath>

namespace haptable {

std::optional<Eigen::Isometry3d> pose_of(const Eigen::Vector3d& rest_centre_m, const Eigen::Vector3d& centre_m,
                                         const std::array<double, 4>& turn) {
    const Eigen::Quaterniond q(turn[0], turn[1], turn[2], turn[3]);
    if (!(q.norm() > 0.5) || !std::isfinite(q.norm()) || !rest_centre_m.allFinite() || !centre_m.allFinite()) return {};
    return Eigen::Translation3d(centre_m) * q.normalized() * Eigen::Translation3d(-rest_centre_m);
}

}  // namespace haptable
