// SPDX-License-Identifier: GPL-2.0-or-later
// A session's curves against time, drawn by gnuplot as SVG.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/run/timeline.hpp"

namespace haptable {

struct Plot {
    std::string title, svg;
};

/// Values against time, for a plot as wide as `columns`: of each column's values the least and the greatest, in their
/// order, so that no peak is lost. NaN is left out; [.][2], s and the value.
std::vector<std::array<double, 2>> thinned(const std::vector<std::array<double, 2>>& points, std::size_t columns);

/// Force, depth, energies, latency and faults. `scratch` is a folder for gnuplot's files. Throws Error where gnuplot is
/// missing or fails.
std::vector<Plot> draw_plots(const Timeline& timeline, const std::filesystem::path& scratch);

}  // namespace haptable
