// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/dense/dense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace haptable {

using Eigen::MatrixXd;
using Eigen::VectorXd;

SymmetricEigen symmetric_eigen(const MatrixXd& a) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
    return {eigen.eigenvalues(), eigen.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const MatrixXd& a) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixXd orthonormal(const MatrixXd& a) {
    return Eigen::HouseholderQR<MatrixXd>(a).householderQ() * MatrixXd::Identity(a.rows(), a.cols());
}

VectorXd solve_spd(const MatrixXd& a, const VectorXd& b) { return a.llt().solve(b); }

VectorXd least_squares(const MatrixXd& a, const VectorXd& b) { return a.colPivHouseholderQr().solve(b); }

MatrixXd product(const MatrixXd& a, const MatrixXd& b) { return a * b; }

}  // namespace haptable
