// SPDX-License-Identifier: GPL-2.0-or-later
// By how much K magnifies roundings: |dL_ij| / sqrt(L_ii L_jj) <= sqrt(n) u condition of K scaled to a unit diagonal.
#pragma once

#include <Eigen/SparseCore>

#include "host/inverse/stiffness.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {

/// K itself, of a Stiffness that may have pressures.
Eigen::SparseMatrix<double> assembled(const Stiffness& k);

/// Largest over least eigenvalue of D^-1/2 K D^-1/2, D the diagonal of K; for what is scaled by the user's units,
/// elements of different sizes or stiffnesses, costs no digits (van der Sluis 1969).
double scaled_condition(const Eigen::SparseMatrix<double>& k);

/// What an entry of L = K^-1 may err by, as a share of sqrt(L_ii L_jj): a Cholesky factor is that of K + dK with
/// |dk_ij| <= (a few) sqrt(n) u sqrt(k_ii k_jj) (Demmel 1989), and dL = -L dK L. Both sides of a comparison do, and
/// the assembly rounds each k_ij: hence 8.
///
/// With pressures the factor L S L^T of M is that of M + dM with |dm_ij| <= (a few) sqrt(n) u sqrt(d_i d_j), where d is
/// the diagonal of K and of I + G A^-1 G^T (Golub and Van Loan 1979; Gill, Saunders and Shinnerl 1996). A column of
/// M^-1 at a row of K is L and G L, so dL is at most lambda_max(L (D_K + G^T D_p G)) of that.
Bound inverse_bound(const Stiffness& k);

}  // namespace haptable::test
