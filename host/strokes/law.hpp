// SPDX-License-Identifier: GPL-2.0-or-later
// f = Psi'(e) S(g) u, e = 1/2 u . S u, in double, from the tables in double: what a contact's force must be.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <vector>

#include "codegen/model.hpp"
#include "firmware/haptable_pair.h"

namespace haptable {

/// A point of the servo's surface.
struct SurfacePoint {
    std::size_t patch = 0;
    Eigen::Vector3d alpha = Eigen::Vector3d::Zero();
};

Eigen::Vector3d corner_of(const ServoModel& servo, std::size_t patch, std::size_t corner);
Eigen::Vector3d point_of(const ServoModel& servo, const SurfacePoint& g);

/// The three forces of [contact] (docs/CONTACT.md) as polynomials of alpha on every patch.
class Law {
public:
    /// servo: built from the tables; its numbering of patches and corners is used, none of its blocks. It must outlive
    /// this object.
    Law(const Tables& tables, const ServoModel& servo);

    /// S(g), N/m: sum alpha_a S_a, or C(alpha)^-1, lifted where vertices are fixed.
    Eigen::Matrix3d stiffness(const SurfacePoint& g) const;
    /// How a dent stiffens: Psi.
    const StiffeningCurve& curve() const { return curve_; }
    /// What dents the linear body by u: a corner's force a column, N. s: stiffness(g).
    Eigen::Matrix3d nodal_forces(const SurfacePoint& g, const Eigen::Matrix3d& s, const Eigen::Vector3d& u) const;
    /// C^-1 of two places that are both pressed, C = [C_1 C_12; C_12^T C_2], N/m: C_12 from the pair's tables, less
    /// where they meet or where the two are as good as one (docs/SPEC.md).
    Eigen::Matrix<double, 6, 6> stiffness_of_two(const haptable_pair_model& pair,
                                                 const std::array<SurfacePoint, 2>& g) const;
    /// C of places that are all pressed, [3 n, 3 n], m/N: C_i of each, between two what the pair's tables have.
    Eigen::MatrixXd compliance(const haptable_pair_model& pair, const std::vector<SurfacePoint>& g) const;
    /// True where the surface drawn with a contact's forces must meet the finger: force = "consistent", not lifted.
    bool draws(const SurfacePoint& g) const;
    /// By how much nodal forces on the patch move the point, m: sum alpha_a L_ab F_b. before: draws(g).
    Eigen::Vector3d drawn(const SurfacePoint& g, const Eigen::Matrix3d& nodal_n) const;

private:
    using Block = Eigen::Matrix3d;
    Block vertex_compliance(const Tables& tables, std::uint16_t vertex) const;
    Block control(const Tables& tables, std::size_t patch, const std::array<int, 3>& exponent) const;
    Block edge_compliance(const Tables& tables, std::size_t a, std::size_t b, int from_a) const;
    Block polynomial(const SurfacePoint& g) const;
    Block coupling(const haptable_pair_model& pair, const SurfacePoint& one, const SurfacePoint& other) const;
    double lift(const SurfacePoint& g, const Block& c) const;

    const ServoModel& servo_;
    int degree_;  ///< 1: S itself; 2, 4: C
    double rigid_n_per_m_;
    StiffeningCurve curve_;
    struct Term {
        std::array<int, 3> exponent;  ///< of alpha
        double multinomial;
    };
    std::vector<Term> term_;                                   ///< [controls]
    std::vector<Block> control_;                               ///< [p controls]
    std::vector<std::array<Block, 9>> pair_;                   ///< [p] L_ab, row by row; consistent only
    std::map<std::array<std::int32_t, 2>, std::size_t> edge_;  ///< places in the tables
};

}  // namespace haptable
