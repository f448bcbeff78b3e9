// SPDX-License-Identifier: GPL-2.0-or-later
// F = Psi'(e) F_linear,   e = 1/2 d . C^-1 d:  one curve for all dents of a body that stiffens
//
// The dents of a few fingers (host/body/indentation.hpp) are what the curve is fitted to, by least squares of relative
// errors; where the tangent would not stay positive, a curve of fewer terms is.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "host/base/progress.hpp"
#include "host/base/stiffening.hpp"
#include "host/body/small_strain.hpp"

namespace haptable {

/// Ways of a dent: into the body, between that and along the surface, along it, and out of the body.
inline constexpr std::array<std::string_view, 4> kDentWays{"pressing", "oblique", "sideways", "pulling"};

/// One dent, of the stiffening body and of the linear one.
struct Dent {
    std::size_t place = 0, way = 0;
    double depth_m = 0.0;
    double linear_j = 0.0;  ///< e
    double factor = 0.0;    ///< of the force along the linear one, over that
    double across = 0.0;    ///< what the force has across it, over the linear one

    /// |p F_linear - F| / |F|
    double error(double p) const;
};

/// How far a force is off over some dents, as a part of the body's.
struct DentErrors {
    std::size_t dents = 0;
    double rms = 0.0, worst = 0.0;
    double linear_rms = 0.0;  ///< of the linear force
    double depth_m = 0.0;     ///< the deepest of them
};

/// A record's press beside the scene's linear body.
struct PressedPlace {
    std::int32_t node = -1;        ///< of the mesh: nearest to where the record says
    double stiffness_n_per_m = 0;  ///< of the linear body there
};

struct StiffeningFit {
    StiffeningCurve curve;
    std::array<bool, 4> is_fitted{};      ///< ways that the scene's finger can go; the others are only compared
    std::array<DentErrors, 4> by_way;     ///< of all dents
    DentErrors fitted;                    ///< of all dents of those ways
    std::vector<DentErrors> by_place;     ///< the same at each place
    std::vector<double> good_m;           ///< how deep the force is there within the share, whichever of those ways
    std::vector<std::int32_t> node;       ///< of the mesh: the places
    std::vector<double> pressed_n_per_m;  ///< what the linear body answers there when pressed
    SmallStrain good;  ///< how deep the force is within its share of the body's, in place of the linear one's
    std::optional<PressedPlace> pressed;  ///< of a record; then there are no dents
};

/// The curve of those dents of ways that are to be fitted. Throws Error where there is none.
StiffeningCurve fit_curve(const std::vector<Dent>& dents, const std::array<bool, 4>& is_fitted);

/// Presses a few touchable nodes, or their masks, to 30 % of the body's least extent; where the body is stiffer, to the
/// linear force that this takes at the median place; and no farther than the device's force goes, or a rest is found.
/// The scene's material has a stiffening and is isotropic.
///   masks   of the scene; unused without a mask
///   solver  of its K
StiffeningFit fit_stiffening(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver,
                             Progress& progress);

/// The curve of the scene's record, with the energy that the scene's linear body has at the record's depth, pressed
/// along its normal. Throws Error where the place is not on the touchable surface.
///   masks  of the record's radius, or of the scene; unused without either
StiffeningFit fit_press(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver);

}  // namespace haptable
