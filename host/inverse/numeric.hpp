// SPDX-License-Identifier: GPL-2.0-or-later
// The numbers of the Cholesky factor, in the supernodes that the analysis found.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/inverse/factor.hpp"

namespace haptable {

inline constexpr int kThreadColumns = 128;  ///< columns that a thread takes at a time
inline constexpr int kThreadRows = 512;     ///< rows that a thread takes at a time

/// Fills `value` (laid out as `pattern` says) with L of P M P^T = L S L^T.
///   m  symmetric with both triangles stored
/// Returns the first column of L whose pivot has not the sign of S, or -1. What is computed, down to the last bit, does
/// not depend on the number of workers. The workspace is that of one supernode a worker. Tells progress; stops on
/// Ctrl-C.
std::int32_t factorize(const Supernodes& pattern, const Eigen::SparseMatrix<double>& m, double* value, Workers& workers,
                       Progress& progress);

/// Bytes of that workspace.
double factorize_bytes(const Supernodes& pattern, int workers);

/// Supernodes that are too small to share among threads, by whole subtrees: root[s] is the subtree's topmost
/// supernode, or -1 where s is shared. A subtree holds at most a share of 1 / (8 workers) of the sum of `cost`.
std::vector<std::int32_t> find_subtrees(const std::vector<std::int32_t>& parent, const std::vector<double>& cost,
                                        int workers);

}  // namespace haptable
