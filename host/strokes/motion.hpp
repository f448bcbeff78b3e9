// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene's step has of fingers and of a body that moves, in double: what the laws of physics speak of.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "codegen/model.hpp"
#include "host/session/scene_state.hpp"

namespace haptable {

/// A tick, s.
constexpr double kTick_s = 1e-6 * HAPTABLE_TICK_US;

inline Eigen::Vector3d to_vector(const float x[3]) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

/// A rigid body as the servo's tables have it; SI, body axes and origin.
struct Rigid {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();
};
Rigid rigid_of(const haptable_body& body);

/// Where a free body is and how it moves.
struct Motion {
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< world
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();       ///< kg m/s, world axes
    Eigen::Vector3d spin_momentum = Eigen::Vector3d::Zero();  ///< kg m^2/s about the centre, world axes
};
Motion motion_of(const haptable_body_state& state, const Rigid& rigid);

/// What a finger has in a tick.
struct Felt {
    bool touches = false;
    Eigen::Vector3d at_m = Eigen::Vector3d::Zero();     ///< the finger, world, as the servo took it
    Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< on the hand, world axes
    /// What a release adds to that force, N: it only brakes the motion that it comes with. Where it is asked for.
    Eigen::Vector3d released_n = Eigen::Vector3d::Zero();
    Eigen::Vector3d load_n = Eigen::Vector3d::Zero();    ///< on the surface, body axes: the sum of the nodal forces
    Eigen::Vector3d god_m = Eigen::Vector3d::Zero();     ///< body coordinates, rest shape
    Eigen::Vector3d inside_m = Eigen::Vector3d::Zero();  ///< the finger as the contact has it: less what modes moved
};
Felt felt_of(const SceneState& scene, std::size_t finger, const haptable_input& in, const haptable_output& out);

/// 1/2 (q'^2 + omega^2 q^2) of all modes; 0 where there are none.
double modes_j(const SceneState& scene);

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// An account of energy that nobody can talk into anything: of the body's motion, its modes and its contacts, and what
/// the hands were given. What there is and what the hands were given never rises, from any moment on at which nothing
/// touches, by more than a wall of the body's stiffness makes of the same hands: k/2 times a tick's way, in the world
/// or in the body's frame, squared, while a finger touches (Colgate and Schenkel 1997). Two that press are two springs
/// that are coupled, K of C^-1: where C is nearly singular, as on a body that bends under either, K is far above k, and
/// the wall makes 1/2 w^T K w of both ways w at once.
class Ledger {
public:
    /// rigid: null where the body is held; it must outlive the ledger. is_relative: the way of a surface that modes
    /// swing under the finger counts too, as for a wall on a moving base: of forces that have no energy, which the
    /// servo takes back a tick after they made it.
    Ledger(double stiffness_n_per_m, const Rigid* rigid, bool is_relative = false)
        : stiffness_n_per_m_(stiffness_n_per_m), rigid_(rigid), is_relative_(is_relative) {}

    /// One tick; stored_j: in contacts and modes. before, after: of a free body, around the step. together: N/m, body
    /// axes, of two that press both; zero otherwise.
    void note(const Felt felt[], std::size_t fingers, double stored_j, const Motion& before, const Motion& after,
              const Matrix6d& together = Matrix6d::Zero());

    double risen_j() const { return risen_j_; }      ///< the most, beyond what a wall makes
    double largest_j() const { return largest_j_; }  ///< that there was at once
    /// What float forces and places make of the work, J: a rounding of each a tick, all of one sign.
    double rounded_j() const { return rounded_j_; }

private:
    std::array<double, 2> motion_of(const Motion& before, const Motion& after) const;

    double stiffness_n_per_m_;
    const Rigid* rigid_;
    bool is_relative_;
    std::array<Felt, 2> last_;
    std::array<Eigen::Vector3d, 2> inside_;
    Matrix6d together_ = Matrix6d::Zero();  ///< of the last tick
    double given_j_ = 0.0, wall_j_ = 0.0, lowest_ = HUGE_VAL, risen_j_ = 0.0, largest_j_ = 0.0, rounded_j_ = 0.0;
    int ticks_ = 0;
};

}  // namespace haptable
