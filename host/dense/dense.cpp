// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/dense/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace haptable {

using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
    return {eigen.eigenvalues(), eigen.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& a) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd symmetric_eigenvalues(const MatrixXd& a, const MatrixXd& b) {
    return symmetric_eigenvalues(over_cholesky(over_cholesky(a, b).transpose(), b));
}

MatrixXd orthonormal(const MatrixXd& a) {
    return Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.cols());
}

VectorXd solve_spd(const MatrixXd& a, const VectorXd& b) { return a.llt().solve(b); }

MatrixXd inverse_spd(const MatrixXd& a) { return a.llt().solve(MatrixXd::Identity(a.rows(), a.cols())); }

MatrixXd over_cholesky(const MatrixXd& b, const MatrixXd& a) {
    return a.llt().matrixL().solve(b.transpose()).transpose();
}

VectorXd least_squares(const MatrixXd& a, const VectorXd& b) { return a.colPivHouseholderQr().solve(b); }

MatrixXd product(const Ref<const MatrixXd>& a, const Ref<const MatrixXd>& b) { return a * b; }

MatrixXd transposed_product(const Ref<const MatrixXd>& a, const Ref<const MatrixXd>& b) { return a.transpose() * b; }

}  // namespace haptable
