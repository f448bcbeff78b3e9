// SPDX-License-Identifier: GPL-2.0-or-later
// The Cholesky factor of a stiffness matrix. What only solves meets it as a LinearSolver.
#pragma once

#include <memory>

#include "host/base/workers.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// P K P^T = L L^T, supernodal: analysed and solved with by CHOLMOD, factorised by factorize() (numeric.hpp), which can
/// be watched, stopped and shared by threads. METIS orders the graph of the nodes, so that the three rows of a node
/// stay together and the ordering costs half of what it costs on the graph of the rows. One BLAS thread: the number of
/// BLAS threads changes the rounding, that of workers does not.
class Factor : public LinearSolver {
public:
    enum PatternOnly { kPattern };
    /// The pattern; factorize() fills it.
    ///   k  symmetric with both triangles stored, three rows a node
    /// Throws Error where CHOLMOD runs out of memory or of its integers.
    Factor(const Eigen::SparseMatrix<double>& k, PatternOnly);
    /// Both at once, on this thread.
    explicit Factor(const Eigen::SparseMatrix<double>& k);
    ~Factor() override;

    /// A k that is not positive definite makes a factor whose weakest_pivot() says so and that cannot solve.
    void factorize(const Eigen::SparseMatrix<double>& k, Workers& workers, Progress& progress);

    Eigen::Index size() const override;
    /// Needs weakest_pivot().ratio > 0.
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;

    /// Gives back the memory that solve() keeps from call to call.
    void release_workspace() const;

    Pivot weakest_pivot() const;

    Supernodes supernodes() const;
    double fill() const;   ///< nonzeros of L
    double flops() const;  ///< of the factorisation
    double bytes() const;  ///< of the factor

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haptable
