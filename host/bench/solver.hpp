// SPDX-License-Identifier: GPL-2.0-or-later
// The tables' competitor and reference: one sparse solve for every load.
#pragma once

#include <Eigen/SparseCore>
#include <filesystem>
#include <memory>
#include <vector>

#include "host/body/body.hpp"
#include "host/inverse/factor.hpp"
#include "host/view/deformation.hpp"

namespace haptable {

/// K of a scene with its factor kept.
class Solver {
public:
    explicit Solver(const std::filesystem::path& scene_file);

    /// Displacements of all free nodes, m, under the loads; valid until the next call.
    const Eigen::MatrixXd& solve(const std::vector<NodalForce>& loads);
    /// Displacement of one mesh node in the last solution, m.
    Eigen::Vector3d displacement(std::int32_t node) const;

private:
    Body body_;
    std::unique_ptr<Factor> factor_;
    Eigen::MatrixXd force_;  // [3 unknowns, 1]
    Eigen::MatrixXd moved_;  // [3 unknowns, 1]
};

/// Unit forces, not along any axis, on the three nodes of a patch.
std::vector<NodalForce> three_loads(const Tables& tables, std::size_t patch);

/// Largest difference between equation 8 (float32 columns) and a solve in double, as a share of the largest
/// displacement, over `patches` patches spread over the surface.
double displacement_error(Deformation& deformation, Solver& solver, const Tables& tables, std::size_t patches);

}  // namespace haptable
