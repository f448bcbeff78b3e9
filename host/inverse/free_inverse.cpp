// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/free_inverse.hpp"

#include <Eigen/Cholesky>

namespace haptable {

FreeInverse::FreeInverse(Inverse& held, const Eigen::MatrixXd& r, const Eigen::MatrixXd& mr) : CorrectedInverse(held) {
    // R^T M R = G G^T: R G^-T is orthonormal in M.
    const Eigen::MatrixXd g = Eigen::MatrixXd(r.transpose() * mr).llt().matrixL();
    const auto solve = g.triangularView<Eigen::Lower>();
    r_ = solve.solve(r.transpose()).transpose();
    mr_ = solve.solve(mr.transpose()).transpose();
}

FactorFacts FreeInverse::factorize(const Stiffness& k_c, Progress& progress) {
    FactorFacts facts = whole().factorize(k_c, progress);
    if (facts.weakest && !(facts.weakest->ratio > 0.0)) return facts;
    Eigen::MatrixXd y;
    whole().solve(mr_, y);
    u_ = y - 0.5 * r_ * (mr_.transpose() * y);
    return facts;
}

void FreeInverse::balance(Eigen::MatrixXd& b) const { b -= mr_ * (r_.transpose() * b).eval(); }

void FreeInverse::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    Eigen::MatrixXd balanced = b;
    balance(balanced);
    whole().solve(balanced, x);
    x -= r_ * (mr_.transpose() * x).eval();
}

Eigen::Matrix3d FreeInverse::correction(std::int32_t i, std::int32_t j) const {
    const Eigen::Index a = Eigen::Index{3} * i, b = Eigen::Index{3} * j;
    return -(r_.middleRows<3>(a) * u_.middleRows<3>(b).transpose() +
             u_.middleRows<3>(a) * r_.middleRows<3>(b).transpose());
}

}  // namespace haptable
