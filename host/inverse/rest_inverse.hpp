// SPDX-License-Identifier: GPL-2.0-or-later
//   L_rest = L - sum phi_k phi_k^T / omega_k^2
//
// What of a body gives way at once where its lowest modes have a motion of their own: under a load that is held the
// modes come to phi_k^T f / omega_k^2, and both together to L f (mode acceleration: Geradin and Rixen 2015, 2.9).
#pragma once

#include "host/inverse/corrected_inverse.hpp"
#include "host/inverse/natural_modes.hpp"

namespace haptable {

/// An Inverse without its lowest modes, which factorize() finds.
class RestInverse : public CorrectedInverse {
public:
    /// whole: must outlive it. mass: of the same unknowns. count: modes.
    RestInverse(Inverse& whole, const Eigen::SparseMatrix<double>& mass, int count);

    FactorFacts factorize(const Stiffness& k, Progress& progress) override;
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;
    /// b -> b - sum M phi phi^T b, of what the other has of it.
    void balance(Eigen::MatrixXd& b) const override;
    Eigen::Matrix3d correction(std::int32_t i, std::int32_t j) const override;

    /// After factorize().
    const NaturalModes& modes() const { return modes_; }

private:
    Eigen::SparseMatrix<double> mass_;
    int count_;
    NaturalModes modes_;
    Eigen::MatrixXd part_;  ///< phi_k / omega_k
};

}  // namespace haptable
