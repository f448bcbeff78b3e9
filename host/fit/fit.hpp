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

/// A press that was slow, or of a body that does not relax, and stiffens: F = k d Psi', s = d / the deepest.
struct DentFit {
    double stiffness_n_per_m = 0.0;
    StiffeningCurve curve;
    double misfit_n = 0.0;  ///< root of the mean squared difference
};

/// Least squares over k and the curve, of fewer terms where the tangent would not stay positive. Throws Error where the
/// record has too few depths.
DentFit fit_dent(const ForceRecord& record);

/// The lines of a scene that such a fit gives.
std::string scene_lines(const Scene& scene, double factor, const DentFit& fit);

/// The lines of a scene that the fit gives: young where the body is of one isotropic material, and its relaxation.
std::string scene_lines(const Scene& scene, double factor, const PronyFit& fit);

/// Force, fit and their difference against time, as SVG by gnuplot. Throws Error where gnuplot is missing or fails.
void plot_fit(const ForceRecord& record, const PronyFit& fit, const std::filesystem::path& svg);

}  // namespace haptable
