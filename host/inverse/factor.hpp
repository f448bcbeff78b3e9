// SPDX-License-Identifier: GPL-2.0-or-later
// The factor of a stiffness matrix. What only solves meets it as a LinearSolver.
#pragma once

#include <memory>

#include "host/base/workers.hpp"
#include "host/inverse/inverse.hpp"

namespace haptable {

/// P M P^T = L S L^T, supernodal, M the stiffness' matrix and S = -1 at its pressures: analysed and solved with by
/// CHOLMOD, factorised by factorize() (numeric.hpp), which can be watched, stopped and shared by threads. METIS orders
/// the graph of the nodes, so that the rows of a node stay together and the ordering costs half of what it costs on the
/// graph of the rows. One BLAS thread: the number of BLAS threads changes the rounding, that of workers does not.
///
/// Such an M can be factorised in any order without pivoting (Vanderbei 1995): no pivot is nearer to 0 than in K.
class Factor : public LinearSolver {
public:
    enum PatternOnly { kPattern };
    /// The pattern; factorize() fills it.
    /// Throws Error where CHOLMOD runs out of memory or of its integers.
    Factor(const Stiffness& k, PatternOnly);
    /// Both at once, on this thread.
    explicit Factor(const Stiffness& k);
    ~Factor() override;

    /// A k that is not positive definite makes a factor whose weakest_pivot() says so and that cannot solve.
    void factorize(const Stiffness& k, Workers& workers, Progress& progress);

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
