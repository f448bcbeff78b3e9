// SPDX-License-Identifier: GPL-2.0-or-later
// What of a scene's modes the servo and the viewer read.
#pragma once

#include <string>

#include "host/compliance/pair_coupling.hpp"
#include "host/inverse/rest_inverse.hpp"
#include "host/tables/modes.hpp"

namespace haptable {

struct ModeFacts {
    std::vector<double> frequency_hz;
    double damping_ratio = 0.0;
    double share = 0.0;  ///< of the touchable nodes' compliance that the modes carry, trace by trace
};

/// Throws Error where a mode swings faster than ticks of a millisecond can show: the scene's line, and how many do not.
void require_rendered(const Scene& scene, const NaturalModes& modes);

/// row: the unknown nodes of the drawn rows.
ModeTables mode_tables(const Scene& scene, const Body& body, const NaturalModes& modes, const PairControls& controls,
                       std::span<const std::int32_t> row);

/// node: the unknown nodes that may be touched; l_ii: their blocks without the modes.
ModeFacts mode_facts(const Scene& scene, const RestInverse& rest, std::span<const std::int32_t> node,
                     std::span<const Eigen::Matrix3d> l_ii);

/// One line for people.
std::string describe(const ModeFacts& facts);

}  // namespace haptable
