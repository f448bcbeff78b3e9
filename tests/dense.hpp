// SPDX-License-Identifier: GPL-2.0-or-later
// Dense references by Eigen, compiled once: what one of these instantiates costs a file 1 to 7 s.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace haptable::dense {

/// A^-1 of a symmetric positive definite A, by Cholesky.
Eigen::MatrixXd inverse_spd(const Eigen::MatrixXd& a);
/// A^-1 and A^-1 B of any regular A, by LU with full pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of a symmetric A, eigenvalues ascending.
Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(const Eigen::MatrixXd& a);
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a);

Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace haptable::dense
