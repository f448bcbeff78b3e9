// SPDX-License-Identifier: GPL-2.0-or-later
// By how much K magnifies roundings: |dL_ij| / sqrt(L_ii L_jj) <= sqrt(n) u condition of K scaled to a unit diagonal.
#pragma once

#include <Eigen/SparseCore>

#include "tests/tolerance.hpp"

namespace haptable::test {

/// Largest over least eigenvalue of D^-1/2 K D^-1/2, D the diagonal of K; for what is scaled by the user's units,
/// elements of different sizes or stiffnesses, costs no digits (van der Sluis 1969).
double scaled_condition(const Eigen::SparseMatrix<double>& k);

/// What an entry of L = K^-1 may err by, as a share of sqrt(L_ii L_jj): a Cholesky factor is that of K + dK with
/// |dk_ij| <= (a few) sqrt(n) u sqrt(k_ii k_jj) (Demmel 1989), and dL = -L dK L. Both sides of a comparison do, and
/// the assembly rounds each k_ij: hence 8.
Bound inverse_bound(const Eigen::SparseMatrix<double>& k);

}  // namespace haptable::test
