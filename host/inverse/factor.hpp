// SPDX-License-Identifier: GPL-2.0-or-later
// The Cholesky factor of a stiffness matrix. What only solves meets it as a LinearSolver.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/base/progress.hpp"
#include "host/base/workers.hpp"
#include "host/inverse/inverse.hpp"
#include "host/solve/supernodes.hpp"

namespace haptable {

/// P K P^T = L L^T, supernodal: analysed and solved with by CHOLMOD, factorised by factorize() (numeric.hpp), which can
/// be watched, stopped and shared by threads. METIS orders the graph of the nodes, so that the three rows of a node
/// stay together and the ordering costs half of what it costs on the graph of the rows. One BLAS thread: the number of
/// BLAS threads changes the rounding, that of workers does not.
class Factor : public LinearSolver {
public:
    /// k: symmetric with both triangles stored, three rows a node. Throws Error where CHOLMOD runs out of memory or of
    /// its integers. A k that is not positive definite makes a factor whose weakest_pivot() says so and that cannot
    /// solve. `before` is called between the analysis, which finds the pattern, and the factorisation, which fills it.
    /// With `workers` they share the factorisation, and `progress` is told the share that is done.
    explicit Factor(const Eigen::SparseMatrix<double>& k, const std::function<void(const Factor&)>& before = {},
                    Workers* workers = nullptr, Progress* progress = nullptr);
    ~Factor() override;

    Eigen::Index size() const override;
    /// Needs weakest_pivot().ratio > 0.
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override;

    /// Gives back the memory that solve() keeps from call to call.
    void release_workspace() const;

    /// The least pivot l_jj^2, as a share of k_jj; 0 where the factorisation stopped at that row.
    struct Pivot {
        Eigen::Index row = 0;  ///< of k
        double ratio = 0.0;
    };
    Pivot weakest_pivot() const;

    Supernodes supernodes() const;
    const std::string& ordering() const;  ///< "METIS"
    double fill() const;                  ///< nonzeros of L
    double flops() const;                 ///< of the factorisation
    double bytes() const;                 ///< of the factor

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haptable
