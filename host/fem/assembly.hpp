// SPDX-License-Identifier: GPL-2.0-or-later
// K = sum of small dense matrices, each at the rows of its nodes
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <functional>
#include <span>

#include "host/fem/lists.hpp"

namespace haptable {

/// Fills in small matrix i: three rows for each node of its list, symmetric.
using FillMatrix = std::function<void(std::size_t i, Eigen::MatrixXd& matrix)>;

/// K (N/m), both triangles stored, symmetric to the last bit where the small matrices are.
///   nodes          lists of mesh nodes, one a small matrix
///   unknown        [N] place of a node among the unknowns, or -1 to leave its rows and columns out
///   unknown_count  nodes in K: it has three rows each
Eigen::SparseMatrix<double> assemble(const Lists& nodes, const FillMatrix& fill, std::span<const std::int32_t> unknown,
                                     std::int32_t unknown_count);

}  // namespace haptable
