// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/quadratic_tet.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/index.hpp"

namespace haptable {

namespace {

using Eigen::Index;

/// dN/dt_i - dN/dt_0, i = 1, 2, 3: the derivatives along the edges from corner 0.
Eigen::Matrix<double, 10, 3> derivatives(const Eigen::Vector4d& t) {
    Eigen::Matrix<double, 10, 4> by_t = Eigen::Matrix<double, 10, 4>::Zero();
    for (Index c = 0; c < 4; ++c) by_t(c, c) = 4.0 * t[c] - 1.0;
    for (std::size_t e = 0; e < 6; ++e) {
        const auto [a, b] = kTetEdges[e];
        const auto row = 4 + static_cast<Index>(e);
        by_t(row, static_cast<Index>(a)) = 4.0 * t[static_cast<Index>(b)];
        by_t(row, static_cast<Index>(b)) = 4.0 * t[static_cast<Index>(a)];
    }
    return by_t.rightCols<3>().colwise() - by_t.col(0);
}

}  // namespace

TenNodes ten_nodes(std::span<const Eigen::Vector3d> position_m, const std::array<std::int32_t, 4>& corner,
                   const std::array<std::int32_t, 6>& middle) {
    TenNodes node_m;
    for (Index c = 0; c < 4; ++c) node_m.col(c) = position_m[at(corner[at(c)])];
    for (Index e = 0; e < 6; ++e) node_m.col(4 + e) = position_m[at(middle[at(e)])];
    return node_m;
}

Eigen::Vector<double, 10> ten_values(const Eigen::Vector4d& t) {
    Eigen::Vector<double, 10> value;
    for (Index c = 0; c < 4; ++c) value[c] = t[c] * (2.0 * t[c] - 1.0);
    for (std::size_t e = 0; e < 6; ++e)
        value[4 + static_cast<Index>(e)] =
            4.0 * t[static_cast<Index>(kTetEdges[e][0])] * t[static_cast<Index>(kTetEdges[e][1])];
    return value;
}

TetPoint tet_point(const TenNodes& node_m, const Eigen::Vector4d& t) {
    const Eigen::Matrix<double, 10, 3> along = derivatives(t);
    // Differences first: a body far from the origin keeps its digits.
    const Eigen::Matrix3d jacobian = (node_m.colwise() - node_m.col(0).eval()) * along;
    return {jacobian.determinant(), jacobian.inverse().transpose() * along.transpose()};
}

std::array<Eigen::Vector4d, 4> tet_points() {
    const double far = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0, near = (5.0 - std::sqrt(5.0)) / 20.0;
    std::array<Eigen::Vector4d, 4> points;
    for (std::size_t q = 0; q < 4; ++q) {
        points[q].setConstant(near);
        points[q][static_cast<Index>(q)] = far;
    }
    return points;
}

DetRange det_range(const TenNodes& node_m) {
    DetRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const Eigen::Vector4d& t : tet_points()) {
        const double det = tet_point(node_m, t).det_m3;
        range.least_m3 = std::min(range.least_m3, det);
        range.greatest_m3 = std::max(range.greatest_m3, det);
    }
    return range;
}

}  // namespace haptable
