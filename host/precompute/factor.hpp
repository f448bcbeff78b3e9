// SPDX-License-Identifier: GPL-2.0-or-later
// The Cholesky factor of a stiffness matrix. The rest of precompute meets a solver only through size() and solve().
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>

namespace haptable {

/// P K P^T = L L^T by CHOLMOD, supernodal, fill-reducing ordering by METIS or AMD, whichever fills less.
/// One BLAS thread: the number of threads changes the rounding, and two runs shall give the same bytes.
class Factor {
public:
    /// k: symmetric, its lower triangle is read. Throws Error where CHOLMOD runs out of memory or of its integers.
    /// A k that is not positive definite makes a factor whose weakest_pivot() says so and that cannot solve.
    explicit Factor(const Eigen::SparseMatrix<double>& k);
    ~Factor();
    Factor(const Factor&) = delete;
    Factor& operator=(const Factor&) = delete;

    Eigen::Index size() const;
    /// x = K^-1 b for many right-hand sides at once: b and x [size(), m]. Needs weakest_pivot().ratio > 0.
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const;

    /// The least pivot l_jj^2, as a share of k_jj; 0 where the factorisation stopped at that row.
    struct Pivot {
        Eigen::Index row = 0;  ///< of k
        double ratio = 0.0;
    };
    Pivot weakest_pivot() const;

    const std::string& ordering() const;  ///< "METIS" or "AMD"
    double fill() const;                  ///< nonzeros of L
    double flops() const;                 ///< of the factorisation

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haptable
