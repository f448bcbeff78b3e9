// SPDX-License-Identifier: GPL-2.0-or-later
// Eigen's decompositions of dense matrices, compiled once: each costs a file that instantiates it 2 to 6 s.
#pragma once

#include <Eigen/Core>

namespace haptable {

/// A symmetric matrix [n, n]: eigenvalues ascending, eigenvectors of length 1 as columns.
struct SymmetricEigen {
    Eigen::VectorXd values;
    Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// The lambda of A x = lambda B x, ascending; A symmetric, B symmetric positive definite.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Q [n, k] of A = Q R by Householder's reflections, n >= k.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& a);

/// A^-1 b, and A^-1, of a symmetric positive definite A, by Cholesky.
Eigen::VectorXd solve_spd(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);
Eigen::MatrixXd inverse_spd(const Eigen::MatrixXd& a);

/// B G^-T, where A = G G^T is symmetric positive definite, by Cholesky.
Eigen::MatrixXd over_cholesky(const Eigen::MatrixXd& b, const Eigen::MatrixXd& a);

/// The x [k] of least |A x - b|, A [n, k], by Householder's reflections with pivots.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// A B, and A^T B.
Eigen::MatrixXd product(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b);
Eigen::MatrixXd transposed_product(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                   const Eigen::Ref<const Eigen::MatrixXd>& b);

}  // namespace haptable
