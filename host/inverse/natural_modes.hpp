// SPDX-License-Identifier: GPL-2.0-or-later
//   K phi = omega^2 M phi
#pragma once

#include <Eigen/SparseCore>

#include "host/inverse/inverse.hpp"

namespace haptable {

/// The lowest modes of 3n unknowns, m of them.
struct NaturalModes {
    Eigen::VectorXd omega_rad_per_s;  ///< [m] ascending
    Eigen::MatrixXd shape;            ///< phi [3n, m], 1/sqrt(kg): phi^T M phi = I; its largest entry is positive
};

/// How many of them can be found in a body of so many unknowns.
constexpr int most_modes(Eigen::Index unknowns) { return static_cast<int>(unknowns / 4); }

/// By ARPACK's implicitly restarted Lanczos process on L M in the product of M (Lehoucq, Sorensen and Yang 1998): the
/// largest 1 / omega^2. Of a body that nothing holds L is inertia relief's, in which rigid motions have 0.
///   l      factorised, its L symmetric
///   count  1 to most_modes()
/// Throws Error where they do not converge, or are no modes: L is not that of a definite K.
NaturalModes find_modes(const LinearSolver& l, const Eigen::SparseMatrix<double>& mass, int count);

}  // namespace haptable
