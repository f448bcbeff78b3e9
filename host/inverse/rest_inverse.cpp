// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/rest_inverse.hpp"

#include "host/dense/dense.hpp"

namespace haptable {

RestInverse::RestInverse(Inverse& whole, const Eigen::SparseMatrix<double>& mass, int count)
    : CorrectedInverse(whole), mass_(mass), count_(count) {}

FactorFacts RestInverse::factorize(const Stiffness& k, Progress& progress) {
    FactorFacts facts = whole().factorize(k, progress);
    if (facts.weakest && !(facts.weakest->ratio > 0.0)) return facts;
    modes_ = find_modes(whole(), mass_, count_);
    part_ = modes_.shape * modes_.omega_rad_per_s.cwiseInverse().asDiagonal();
    return facts;
}

void RestInverse::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    whole().solve(b, x);
    x -= product(part_, transposed_product(part_, b));
}

void RestInverse::balance(Eigen::MatrixXd& b) const {
    const Eigen::MatrixXd moves = mass_ * product(modes_.shape, transposed_product(modes_.shape, b));
    whole().balance(b);
    b -= moves;
}

Eigen::Matrix3d RestInverse::correction(std::int32_t i, std::int32_t j) const {
    const Eigen::Index a = Eigen::Index{3} * i, b = Eigen::Index{3} * j;
    return -product(part_.middleRows<3>(a), part_.middleRows<3>(b).transpose());
}

}  // namespace haptable
