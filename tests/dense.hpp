// SPDX-License-Identifier: GPL-2.0-or-later
// Dense references by Eigen, compiled once: what one of these instantiates costs a file 1 to 7 s.
#pragma once

#include <Eigen/Core>

#include "host/dense/dense.hpp"

namespace haptable::dense {

/// A^-1 and A^-1 B of any regular A, by LU with full pivoting.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

inline SymmetricEigen eigen(const Eigen::MatrixXd& a) { return symmetric_eigen(a); }
inline Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a) { return symmetric_eigenvalues(a); }
using haptable::inverse_spd;
using haptable::product;

}  // namespace haptable::dense
