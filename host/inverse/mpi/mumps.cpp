// SPDX-License-Identifier: GPL-2.0-or-later
// Control parameters are numbered as in the MUMPS 5.5 user's guide.
#include "host/inverse/mpi/mumps.hpp"

#include <cblas.h>
#include <fmt/format.h>

#include <numeric>

#include "host/base/error.hpp"

namespace haptable {

namespace {

constexpr int kInit = -1, kEnd = -2, kAnalyse = 1, kFactorise = 2, kSolve = 3;
constexpr int kTooLittleWorkspace[] = {-8, -9};
// Right-hand sides of one pass: narrower ones leave BLAS short of work; 1024 take more memory and no less time.
constexpr int kColumnsAtOnce = 192;

}  // namespace

Mumps::Mumps(MPI_Comm communicator) : communicator_(communicator) {
    openblas_set_num_threads(1);  // processes share the processors
    begin(pressures_);
}

/// MUMPS is told at its beginning what kind of matrix will come.
void Mumps::begin(int pressures) {
    id_ = {};
    id_.comm_fortran = static_cast<MUMPS_INT>(MPI_Comm_c2f(communicator_));
    id_.par = 1;                       // the root works too
    id_.sym = pressures == 0 ? 1 : 2;  // positive definite, or any symmetric
    run(kInit);
    for (int stream = 1; stream <= 3; ++stream) control(stream) = -1;  // silent
    control(4) = 0;
    if (pressures == 0) return;
    // M has a factor in any order: rows stay where METIS puts them, and no pivot is put off.
    control(6) = 0;
    control(12) = 1;
    id_.cntl[0] = 0.0;
    control(13) = 1;  // no dense root: it does not count negative pivots
}

Mumps::~Mumps() { run(kEnd); }

void Mumps::run(int job) {
    id_.job = job;
    dmumps_c(&id_);
}

void Mumps::require(const char* what) const {
    const int status = id_.infog[0];
    // Without its dense root MUMPS does not stop at a pivot that is not positive, but counts it. A pressure has one.
    const bool wrong_signs = id_.job == kFactorise && id_.infog[11] != pressures_;
    if (status >= 0 && !wrong_signs) return;
    if ((status >= 0 && wrong_signs) || status == -40 || status == -10)
        throw Error(
            fmt::format("{}: K is not positive definite to rounding: hold the body still, mend slivers in the "
                        "mesh, or lower a Poisson's ratio near 0.5",
                        what));
    if (status == -13 || status == -9 || status == -8 || status == -19)
        throw Error(fmt::format("{}: a process has too little memory: use more machines or a coarser mesh", what));
    throw Error(
        fmt::format("{}: MUMPS failed with status {}, {}; please report this mesh", what, status, id_.infog[1]));
}

void Mumps::analyse(const Stiffness& k) {
    auto pressures = static_cast<int>(k.pressures());
    MPI_Bcast(&pressures, 1, MPI_INT, 0, communicator_);
    if ((pressures == 0) != (pressures_ == 0)) {
        run(kEnd);
        begin(pressures);
    }
    pressures_ = pressures;
    give_matrix(k.matrix());
    Stiffness::Bundles bundles;
    if (pressures > 0) bundles = k.bundles();
    for (std::vector<std::int32_t>* list : {&bundles.begin, &bundles.row})
        for (std::int32_t& i : *list) ++i;  // 1-based
    id_.nblk = static_cast<MUMPS_INT>(bundles.begin.size()) - 1;
    id_.blkptr = bundles.begin.data();
    id_.blkvar = bundles.row.data();
    control(7) = 5;                         // METIS
    control(15) = pressures == 0 ? -3 : 1;  // on the graph of the nodes: three rows each, or those of the bundles
    control(28) = 1;                        // the ordering runs on the root
    run(kAnalyse);
    id_.blkptr = id_.blkvar = nullptr;
    require("analysis of K");
}

/// The lower triangle.
void Mumps::give_matrix(const Eigen::SparseMatrix<double>& m) {
    id_.n = static_cast<MUMPS_INT>(m.rows());
    row_ = column_ = {};
    value_ = {};
    const auto most = static_cast<std::size_t>((m.nonZeros() + m.rows()) / 2);
    row_.reserve(most);
    column_.reserve(most);
    value_.reserve(most);
    for (Eigen::Index j = 0; j < m.outerSize(); ++j)
        for (Eigen::SparseMatrix<double>::InnerIterator e(m, j); e; ++e) {
            if (e.row() < j) continue;
            row_.push_back(static_cast<std::int32_t>(e.row()) + 1);
            column_.push_back(static_cast<std::int32_t>(j) + 1);
            value_.push_back(e.value());
        }
    id_.nnz = static_cast<MUMPS_INT8>(value_.size());
    id_.irn = row_.data();
    id_.jcn = column_.data();
    id_.a = value_.data();
}

void Mumps::factorise() {
    control(14) = 30;  // more workspace than foreseen, per cent
    const auto wants_more = [&] {
        const int status = id_.infog[0];
        return status == kTooLittleWorkspace[0] || status == kTooLittleWorkspace[1];
    };
    for (run(kFactorise); wants_more() && control(14) < 400; run(kFactorise)) control(14) *= 2;
    require("factorisation of K");
    row_ = column_ = {};
    value_ = {};
}

/// Sparse right-hand sides, or wanted entries: the root's alone. MUMPS takes another rank's as its own where they are
/// given.
void Mumps::give_sparse(std::vector<MUMPS_INT>& begin, std::vector<MUMPS_INT>& row, std::vector<double>& value) {
    id_.nrhs = static_cast<MUMPS_INT>(begin.size()) - 1;
    id_.nz_rhs = static_cast<MUMPS_INT>(row.size());
    id_.irhs_ptr = row.empty() ? nullptr : begin.data();
    id_.irhs_sparse = row.empty() ? nullptr : row.data();
    id_.rhs_sparse = row.empty() ? nullptr : value.data();
}

void Mumps::solve(Eigen::MatrixXd& x) {
    control(20) = control(21) = control(30) = 0;  // dense, on the root
    control(27) = kColumnsAtOnce;
    id_.rhs = x.data();
    id_.nrhs = static_cast<MUMPS_INT>(x.cols());
    id_.lrhs = static_cast<MUMPS_INT>(x.rows());
    run(kSolve);
    require("solve");
}

void Mumps::invert(Entries& entries) {
    std::vector<MUMPS_INT> begin(static_cast<std::size_t>(id_.n) + 1, 0), row;
    for (std::int32_t column : entries.column) ++begin[static_cast<std::size_t>(column) + 1];
    begin[0] = 1;
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (std::int32_t r : entries.row) row.push_back(r + 1);
    entries.value.assign(row.size(), 0.0);
    control(20) = control(21) = 0;
    control(30) = 1;  // entries of the inverse
    control(27) = kColumnsAtOnce;
    give_sparse(begin, row, entries.value);
    run(kSolve);
    control(30) = 0;
    require("entries of the inverse");
}

void Mumps::solve_units(std::span<const std::int32_t> column, int count) {
    std::vector<MUMPS_INT> begin(static_cast<std::size_t>(count) + 1), row;
    std::iota(begin.begin(), begin.end(), 1);
    for (std::int32_t c : column) row.push_back(c + 1);
    std::vector<double> one(row.size(), 1.0);
    local_row_.resize(static_cast<std::size_t>(std::max(1, id_.info[22])));
    local_.resize(static_cast<Eigen::Index>(local_row_.size()), count);
    control(20) = 3;  // sparse right-hand sides: only the subtrees above them
    control(21) = 1;  // the solution stays where it is found
    control(27) = kColumnsAtOnce;
    control(30) = 0;
    give_sparse(begin, row, one);
    id_.isol_loc = local_row_.data();
    id_.sol_loc = local_.data();
    id_.lsol_loc = static_cast<MUMPS_INT>(local_row_.size());
    run(kSolve);
    require("solve");
    local_row_.resize(static_cast<std::size_t>(id_.info[22]));
}

double Mumps::fill() const {
    const double count = id_.infog[28];
    return count < 0.0 ? -1e6 * count : count;
}

}  // namespace haptable
