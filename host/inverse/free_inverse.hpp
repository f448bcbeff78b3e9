// SPDX-License-Identifier: GPL-2.0-or-later
//   L = P^T K_c^-1 P,   P = I - M R (R^T M R)^-1 R^T
//
// The elastic part of a body that nothing holds: inertia relief (Rixen 2004, Geradin and Rixen 2015, 2.8). Loads less
// the inertia forces of the rigid motion that they cause are in equilibrium; the displacement under them is taken
// without its rigid part. K_c = K held in six directions that no load in equilibrium meets a reaction in
// (rigid_body.hpp): however stiff they are held, L is the same.
#pragma once

#include "host/inverse/corrected_inverse.hpp"

namespace haptable {

/// An Inverse of K_c as one of the body that is not held. With R orthonormal in M, and Y = K_c^-1 M R, Z = R^T M Y,
/// U = Y - R Z / 2:  L_ab = (K_c^-1)_ab - R_a U_b^T - U_a R_b^T. So blocks and columns stay those of K_c's inverse, and
/// each costs a product of rank 12 more.
class FreeInverse : public CorrectedInverse {
public:
    /// held: must outlive it; asked for K_c. r, mr: [3n, 6] rigid motions of the unknown nodes, and M times these.
    FreeInverse(Inverse& held, const Eigen::MatrixXd& r, const Eigen::MatrixXd& mr);

    FactorFacts factorize(const Stiffness& k_c, Progress& progress) override;
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;
    /// b -> P b: the body moves by the rest.
    void balance(Eigen::MatrixXd& b) const override;
    Eigen::Matrix3d correction(std::int32_t i, std::int32_t j) const override;

private:
    Eigen::MatrixXd r_, mr_, u_;  ///< [3n, 6]
};

}  // namespace haptable
