// SPDX-License-Identifier: GPL-2.0-or-later
// A measured press beside the scene's own body: by how much that is softer or stiffer, and how it relaxes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "host/fit/prony.hpp"
#include "host/scene/scene.hpp"
#include "host/session/servo/poke.hpp"
#include "host/tables/modes.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// F / depth of the scene's body at once, N/m, pressed at `where` as servo --poke does, without the servo's limits;
/// where it rings, once its modes are at rest. place: X,Y,Z or top. Throws Error where it is not met.
double stiffness_at_once(Tables tables, const std::optional<ModeTables>& body_modes, const std::string& place,
                         Poke where);

/// The lines of a scene that such a fit gives.
std::string scene_lines(const Scene& scene, double factor, const DentFit& fit);

/// The lines of a scene that the fit gives: young where the body is of one isotropic material, and its relaxation.
std::string scene_lines(const Scene& scene, double factor, const PronyFit& fit);

/// Force, fit and their difference against time, as SVG by gnuplot. Throws Error where gnuplot is missing or fails.
void plot_fit(const ForceRecord& record, const PronyFit& fit, const std::filesystem::path& svg);

}  // namespace haptable
