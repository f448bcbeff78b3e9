// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/free_inverse.hpp"

#include "host/dense/dense.hpp"

namespace haptable {

FreeInverse::FreeInverse(Inverse& held, const Eigen::MatrixXd& r, const Eigen::MatrixXd& mr) : CorrectedInverse(held) {
    // R^T M R = G G^T: R G^-T is orthonormal in M.
    const Eigen::MatrixXd gram = transposed_product(r, mr);
    r_ = over_cholesky(r, gram);
    mr_ = over_cholesky(mr, gram);
}

FactorFacts FreeInverse::factorize(const Stiffness& k_c, Progress& progress) {
    FactorFacts facts = whole().factorize(k_c, progress);
    if (facts.weakest && !(facts.weakest->ratio > 0.0)) return facts;
    Eigen::MatrixXd y;
    whole().solve(mr_, y);
    u_ = y - 0.5 * product(r_, transposed_product(mr_, y));
    return facts;
}

void FreeInverse::balance(Eigen::MatrixXd& b) const { b -= product(mr_, transposed_product(r_, b)); }

void FreeInverse::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    Eigen::MatrixXd balanced = b;
    balance(balanced);
    whole().solve(balanced, x);
    x -= product(r_, transposed_product(mr_, x));
}

Eigen::Matrix3d FreeInverse::correction(std::int32_t i, std::int32_t j) const {
    const Eigen::Index a = Eigen::Index{3} * i, b = Eigen::Index{3} * j;
    return -(r_.middleRows<3>(a).lazyProduct(u_.middleRows<3>(b).transpose()) +
             u_.middleRows<3>(a).lazyProduct(r_.middleRows<3>(b).transpose()));
}

}  // namespace haptable
