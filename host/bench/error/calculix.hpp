// SPDX-License-Identifier: GPL-2.0-or-later
// Displacements by CalculiX (ccx), another program, on the same nodes and elements under the same nodal forces.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "host/scene/scene.hpp"

namespace haptable {

using NodalForces = std::map<std::int32_t, Eigen::Vector3d>;  ///< node -> N
using Displacements = std::vector<Eigen::Vector3d>;           ///< [N] m

/// A body as CalculiX is told of it.
struct Deck {
    std::span<const Eigen::Vector3d> position_m;
    std::vector<std::vector<std::int32_t>> element;  ///< 4 (C3D4) or 10 (C3D10) nodes each
    std::vector<std::int32_t> held;
    Material material;
    bool large_strain = false;  ///< neo-Hookean, geometry as it deforms
    /// CalculiX's own cards, in mm, N and MPa: in place of the material and its section, and for each load besides it.
    std::string sections = {}, loads = {};
    double density_kg_per_m3 = 0.0;  ///< 0: none is given
};

/// The nodes whose place among the unknowns is -1.
std::vector<std::int32_t> held_of(std::span<const std::int32_t> unknown);

template <typename Elements>
std::vector<std::vector<std::int32_t>> lists_of(const Elements& elements) {
    std::vector<std::vector<std::int32_t>> lists;
    for (const auto& nodes : elements) lists.emplace_back(nodes.begin(), nodes.end());
    return lists;
}

/// Displacements after each load, one after the other; runs `ccx` in `folder`. Throws Error where it is missing or ends
/// without a result. At large strain it may end before the last load: there are fewer results then.
std::vector<Displacements> run_calculix(const Deck& deck, std::span<const NodalForces> loads,
                                        const std::filesystem::path& folder);

/// The lowest `count` frequencies, Hz, ascending; of a body that nothing holds its six rigid motions are among them.
/// Throws Error as run_calculix.
std::vector<double> calculix_frequencies(const Deck& deck, int count, const std::filesystem::path& folder);

}  // namespace haptable
