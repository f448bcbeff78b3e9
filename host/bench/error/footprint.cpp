// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/footprint.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;
constexpr int kPieces = 12;  // a triangle's side in the integration

}  // namespace

double smooth_profile(double q) { return (1.0 - q) * (1.0 - q); }
double uniform_profile(double /*q*/) { return 1.0; }
double hertz_profile(double q) { return std::sqrt(1.0 - q); }

double Footprint::pressure(const Vector3d& x_m) const {
    const double q = (x_m - centre_m).squaredNorm() / (radius_m * radius_m);
    return q < 1.0 ? profile(q) : 0.0;
}

void for_each_piece(int pieces, const std::function<void(const Vector3d& alpha)>& visit) {
    const double third = 1.0 / (3.0 * pieces);
    for (int i = 0; i < pieces; ++i)
        for (int j = 0; i + j < pieces; ++j) {
            visit({1.0 - third * (3 * (i + j) + 2), third * (3 * i + 1), third * (3 * j + 1)});
            if (i + j + 1 < pieces) visit({1.0 - third * (3 * (i + j) + 4), third * (3 * i + 2), third * (3 * j + 2)});
        }
}

LoadShares normed(LoadShares shares) {
    double sum = 0.0;
    for (const auto& [node, share] : shares) sum += share;
    if (!(sum > 0.0)) throw Error("the bench's finger is not on the surface: no node is under it");
    for (auto& [node, share] : shares) share /= sum;
    return shares;
}

LoadShares shares_on(std::span<const Vector3d> position_m, std::span<const std::array<std::int32_t, 3>> triangle,
                     const Footprint& footprint) {
    LoadShares shares;
    for (const auto& corner : triangle) {
        std::array<Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c) x[c] = position_m[static_cast<std::size_t>(corner[c])];
        const double longest = std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
        if ((x[0] - footprint.centre_m).norm() > footprint.radius_m + longest) continue;
        const double area = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
        for_each_piece(kPieces, [&](const Vector3d& alpha) {
            const double p = footprint.pressure(alpha[0] * x[0] + alpha[1] * x[1] + alpha[2] * x[2]);
            for (std::size_t c = 0; p > 0.0 && c < 3; ++c)
                shares[corner[c]] += p * area * alpha[static_cast<Eigen::Index>(c)];
        });
    }
    return normed(shares);
}

std::vector<Eigen::Matrix3d> compliances(const LinearSolver& solver, std::span<const LoadShares> loads,
                                         std::span<const std::int32_t> unknown) {
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(solver.size(), static_cast<Eigen::Index>(3 * loads.size())), x;
    for (std::size_t k = 0; k < loads.size(); ++k)
        for (const auto& [node, share] : loads[k])
            if (const std::int32_t i = unknown[static_cast<std::size_t>(node)]; i >= 0)
                b.block<3, 3>(Eigen::Index{3} * i, static_cast<Eigen::Index>(3 * k)) +=
                    share * Eigen::Matrix3d::Identity();
    solver.solve(b, x);
    std::vector<Eigen::Matrix3d> c;
    for (Eigen::Index k = 0; k < b.cols(); k += 3) c.emplace_back(b.middleCols<3>(k).transpose() * x.middleCols<3>(k));
    return c;
}

}  // namespace haptable
