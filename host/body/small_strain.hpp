// SPDX-License-Identifier: GPL-2.0-or-later
// F / F_linear = 1 + a t + b t^2 + ...   at a depth t:  how far a scene's linear body goes
//
// The tables are those of small strains. The next two terms of the force need the linear field alone, and one solve
// more (2n + 1 theorem): with phi the displacements for a depth of 1, f_2 and f_3 the forces that its second and third
// order ask for (host/fem/neo_hooke.hpp), v what f_2 gives where the finger holds still,
//   S = phi . K phi,   a = phi . f_2 / S,   b = (phi . f_3 + 2 v . f_2) / S
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/body/body.hpp"
#include "host/body/mask.hpp"
#include "host/fem/neo_hooke.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// How the force of a body begins to leave the linear one, for one finger and one way.
struct Departure {
    double a_per_m = 0.0, b_per_m2 = 0.0;

    /// Least depth, m, at which the linear force is off by this share. Infinite where it never is.
    double depth_m(double share) const;
};

/// A finger: how nodes share its load, and which way is out of the body.
struct FingerLoad {
    NodeWeights load;
    Eigen::Vector3d outward;
    std::int32_t node = -1;  ///< of the mesh, where it is at one
};

/// A finger at a touchable node, or with the mask there. masks: of the touchable surface, or none.
FingerLoad finger_at(const Body& body, const Masks& masks, std::int32_t node);
/// A few of a body's touchable nodes, or their masks.
std::vector<FingerLoad> fingers_on(const Body& body, const Masks& masks);

/// C^-1, N/m: of the linear body under that load.
Eigen::Matrix3d stiffness_under(const NodeWeights& load, const LinearSolver& solver,
                                std::span<const std::int32_t> unknown);

/// Ways that a finger moves: into the body, out of it with the surface held, and along it (the worst of four).
enum class Way { kPressing, kPulling, kSideways };
using Departures = std::array<std::vector<Departure>, 3>;  ///< by way: [fingers], sideways [4 fingers]

/// Departures of each finger. The solver's K is the mesh's, of its unknown nodes.
///   unknown  [N] place of a node among them, or -1
Departures departures(const NeoHooke& body, const LinearSolver& solver, std::span<const std::int32_t> unknown,
                      std::span<const FingerLoad> fingers);

/// What a scene tells of it.
struct SmallStrain {
    static constexpr double kShare = 0.1;  ///< of the force, that the depths are for
    double finger_radius_m = 0.0;          ///< of the mask; 0: a node is pressed
    std::size_t places = 0;                ///< that were tried
    /// Medians over the places, m: where the linear force is 10 % off.
    double pressing_m = 0.0, pulling_m = 0.0, sideways_m = 0.0;

    /// The one to keep to: pressing; with friction sideways too.
    double depth_m(bool friction) const { return friction ? std::min(pressing_m, sideways_m) : pressing_m; }
};

/// Departures of a few touchable nodes or their masks. None where one of the three depths is infinite, and of
/// materials that are not isotropic, with membranes or with prestress.
///   masks  of the scene; unused without a mask
std::optional<SmallStrain> find_small_strain(const Scene& scene, const Body& body, const Masks& masks,
                                             const LinearSolver& solver);

}  // namespace haptable
