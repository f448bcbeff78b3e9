// SPDX-License-Identifier: GPL-2.0-or-later
// M = L D L^T over the processes of a communicator, by MUMPS; M is that of stiffness.hpp.
#pragma once

#include <dmumps_c.h>
#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "host/inverse/stiffness.hpp"

namespace haptable {

/// Every process calls every function, with the same arguments where nothing else is said. "Root" is rank 0: what is
/// said to be the root's is not looked at elsewhere. Errors of MUMPS are thrown by all processes alike, as Error.
class Mumps {
public:
    explicit Mumps(MPI_Comm communicator);
    ~Mumps();
    Mumps(const Mumps&) = delete;
    Mumps& operator=(const Mumps&) = delete;

    /// k: the root's. Orders its nodes by METIS.
    void analyse(const Stiffness& k);
    /// After analyse(). Takes more workspace where MUMPS asks for it.
    void factorise();
    /// The root's x, [size, m]: b in, M^-1 b out.
    void solve(Eigen::MatrixXd& x);

    /// Chosen entries of M^-1 by columns, ascending and then by rows, each once.
    struct Entries {
        std::vector<std::int32_t> column, row;
        std::vector<double> value;  ///< m/N, found
    };
    /// The root's.
    void invert(Entries& entries);

    /// M^-1 e_c for columns c, the root's; each process gets the rows that it holds.
    void solve_units(std::span<const std::int32_t> column, int count);
    std::span<const std::int32_t> local_row() const { return local_row_; }  ///< 1-based; after solve_units()
    const Eigen::MatrixXd& local_solution() const { return local_; }        ///< [local rows, count]

    std::int32_t size() const { return id_.n; }  ///< rows of M
    /// Place of each row in the order of elimination; the root's, after analyse().
    std::span<const std::int32_t> order() const { return {id_.sym_perm, static_cast<std::size_t>(id_.n)}; }
    double fill() const;                            ///< nonzeros of the factor
    double flops() const { return id_.rinfog[2]; }  ///< of the factorisation
    /// Of this process, after analyse(): MUMPS tells whole megabytes, rounded down.
    double foreseen_bytes() const { return 1e6 * (id_.info[14] + 1.0); }

private:
    int& control(int number) { return id_.icntl[number - 1]; }  // as the user's guide numbers them
    void begin(int pressures);
    void give_matrix(const Eigen::SparseMatrix<double>& m);
    void give_sparse(std::vector<MUMPS_INT>& begin, std::vector<MUMPS_INT>& row, std::vector<double>& value);
    void run(int job);
    void require(const char* what) const;

    MPI_Comm communicator_;
    DMUMPS_STRUC_C id_{};
    int pressures_ = 0;
    std::vector<std::int32_t> row_, column_, local_row_;  // of M, 1-based, lower triangle; of the local solution
    std::vector<double> value_;
    Eigen::MatrixXd local_;
};

}  // namespace haptable
