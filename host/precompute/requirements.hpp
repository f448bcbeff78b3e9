// SPDX-License-Identifier: GPL-2.0-or-later
// What a body must have for tables to be made of it. Each throws Error with the scene's name and what to do.
#pragma once

#include "host/base/error.hpp"
#include "host/body/under_constrained.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// What work finds wrong with tables is told of the scene that they are of.
template <typename Work>
auto in_scene(const Scene& scene, Work work) try {
    return work();
} catch (const Error& error) {
    throw Error(scene.file.string() + ": " + error.what());
}

/// No node is under-constrained; a body that is not held hangs together. Returns what fixes each body.
std::vector<Support> require_constrained(const Scene& scene, const Body& body);

/// The servo's indices and the flash budget, before any work is done for an object that is too large. What a force
/// needs besides the paper's tables is counted when they are written.
void require_servo(const Scene& scene, const Body& body);

/// What else of a scene its mesh decides: nodes of display_rows have columns, modes are few enough.
void require_rows_and_modes(const Scene& scene, const Body& body);

/// No pivot is zero to rounding: what the mesh could not tell. Returns the least as a fraction of K's diagonal; where
/// the solver does not tell it, a bound from below.
double require_pivots(const Scene& scene, const Body& body, const Stiffness& k, const LinearSolver& solver,
                      const FactorFacts& facts);

/// The solves' residual cannot be seen in float32 tables.
void require_residual(const Scene& scene, double residual);

}  // namespace haptable
