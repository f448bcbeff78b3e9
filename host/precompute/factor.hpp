// SPDX-License-Identifier: GPL-2.0-or-later
// The Cholesky factor of a stiffness matrix. The rest of precompute meets a solver only through size() and solve().
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

namespace haptable {

/// The factor as CHOLMOD stores it. A supernode is a run of columns of L with the same rows below; it is one dense
/// matrix, column-major, with a row for each of its `rows()`: first its own columns (the lower triangle counts), then
/// the rows below. Supernodes are numbered in postorder: children before parents. A view: the Factor must live on.
struct Supernodes {
    std::span<const int> first_column;  ///< [s + 1]
    std::span<const int> row_begin;     ///< [s + 1]
    std::span<const int> value_begin;   ///< [s + 1]
    std::span<const int> row;           ///< [row_begin[s]] ascending within a supernode
    std::span<const int> permutation;   ///< [n] row of K that became row p of L
    const double* value = nullptr;      ///< null before the factorisation

    std::int32_t count() const { return static_cast<std::int32_t>(first_column.size()) - 1; }
    int column_count(std::int32_t s) const { return first_column[at(s) + 1] - first_column[at(s)]; }
    std::span<const int> rows(std::int32_t s) const {
        return row.subspan(at(row_begin[at(s)]), at(row_begin[at(s) + 1] - row_begin[at(s)]));
    }
    const double* values(std::int32_t s) const { return value + value_begin[at(s)]; }
    /// [n] row of L that a row of K became.
    std::vector<std::int32_t> places() const;
    /// [n] supernode that holds a column of L.
    std::vector<std::int32_t> owners() const;
    /// [s] supernode that holds the first row below, or -1.
    std::vector<std::int32_t> parents() const;

private:
    static std::size_t at(std::int32_t s) { return static_cast<std::size_t>(s); }
};

/// P K P^T = L L^T, supernodal: analysed and solved with by CHOLMOD, factorised by factorize() (numeric.hpp), which can
/// be watched, stopped and shared by threads. METIS orders the graph of the nodes, so that the three rows of a node
/// stay together and the ordering costs half of what it costs on the graph of the rows. One BLAS thread: the number of
/// BLAS threads changes the rounding, that of workers does not.
class Factor {
public:
    /// k: symmetric with both triangles stored, three rows a node. Throws Error where CHOLMOD runs out of memory or of
    /// its integers. A k that is not positive definite makes a factor whose weakest_pivot() says so and that cannot
    /// solve. `before` is called between the analysis, which finds the pattern, and the factorisation, which fills it.
    /// With `workers` they share the factorisation, and `progress` is told the share that is done.
    explicit Factor(const Eigen::SparseMatrix<double>& k, const std::function<void(const Factor&)>& before = {},
                    Workers* workers = nullptr, Progress* progress = nullptr);
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
