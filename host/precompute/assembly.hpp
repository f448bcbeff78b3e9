// SPDX-License-Identifier: GPL-2.0-or-later
// K of a scene's body.
#pragma once

#include <Eigen/SparseCore>

#include "host/precompute/body.hpp"

namespace haptable {

/// K of the body's free nodes, N/m: three rows a node in the order of body.free_node, both triangles stored.
Eigen::SparseMatrix<double> assemble_free(const Scene& scene, const Body& body);

}  // namespace haptable
