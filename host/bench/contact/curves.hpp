// SPDX-License-Identifier: GPL-2.0-or-later
// What is felt, as curves for plots: text with a line a point.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace haptable {

/// Normal stiffness while sliding 7 mm over the top of cubes of several mesh sizes, 1 mm deep, nu = 0.3.
struct StiffnessLine {
    std::vector<int> nodes_per_side{9, 13, 17, 25};
    std::vector<double> at_m;                  ///< along the line
    std::vector<std::vector<double>> n_per_m;  ///< three for a mesh: interpolated, consistent, mask of 5 mm
    std::string text() const;                  ///< mm, then the columns
};
StiffnessLine stiffness_along_a_line(const std::filesystem::path& build);

/// Energy that a closed loop has given to the user so far, uJ: in at the centre, 5 mm deep to (5, 6) mm aside, out,
/// over the surface back. A column a mode.
std::string energy_around_a_loop(const std::filesystem::path& build);

/// |F| while sliding out over the cube's convex edge, 2 mm deep at 50 mm/s: the paper's force, the same with a release
/// of 0.01 N/ms, and with the least-energy god-object, which has that by default.
std::string force_over_an_edge(const std::filesystem::path& build);

}  // namespace haptable
