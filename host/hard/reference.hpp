// SPDX-License-Identifier: GPL-2.0-or-later
// L = K^-1 in long double, dense, from the mesh and the elements' energies: what the product is held against.
#pragma once

#include <Eigen/Core>

#include "host/body/body.hpp"

namespace haptable {

struct Reference {
    /// L over the free nodes, m/N, [3 n, 3 n] in the order of body.free_node; rounded to double last.
    Eigen::MatrixXd compliance;
    /// Largest over least eigenvalue of K scaled to a diagonal of 1; within a hundredth.
    double scaled_condition = 0.0;
};

/// Takes n^3 operations of the x87: some hundred nodes at most.
Reference solve_densely(const Scene& scene, const Body& body);

}  // namespace haptable
