// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/natural_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <arpack/arpack.hpp>
#include <array>
#include <cmath>

#include "host/base/error.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The residual of a mode: || omega^2 L M phi - phi ||, both of length 1 in M. What is left of it is rounding.
constexpr double kLargestResidual = 1e-7;
constexpr int kMostRestarts = 300;
// Frequencies that a body's symmetry makes one differ by rounding, 1e-14 of themselves.
constexpr double kSameFrequency = 1.0 + 1e-9;

/// ARPACK's reverse communication, in its shift-invert mode with the shift 0: where L or M is wanted, it asks.
class Lanczos {
public:
    Lanczos(const LinearSolver& l, const Eigen::SparseMatrix<double>& mass, int count)
        : l_(l),
          mass_(mass),
          count_(count),
          size_(static_cast<int>(mass.rows())),
          basis_(std::min(size_, std::max(2 * count + 8, 20))),
          vectors_(size_, basis_),
          start_(size_),
          work_(Index{3} * size_),
          lapack_(Index{basis_} * (basis_ + 8)) {
        for (int i = 0; i < size_; ++i) start_[i] = std::sin(1.0 + 7.0 * i);  // no symmetry
    }

    void iterate() {
        int asks = 0, info = 1;  // start_ is given
        for (;;) {
            arpack::saupd(asks, arpack::bmat::generalized, size_, arpack::which::largest_magnitude, count_, 0.0,
                          start_.data(), basis_, vectors_.data(), size_, parameter_.data(), place_.data(), work_.data(),
                          lapack_.data(), static_cast<int>(lapack_.size()), info);
            if (asks == 99) break;
            answer(asks);
        }
        if (info == 0) return;
        throw Error(
            fmt::format("body.modes: {} of {} modes converged in {} restarts (ARPACK's status {}): ask for "
                        "fewer, or mend slivers in the mesh",
                        parameter_[4], count_, kMostRestarts, info));
    }

    /// omega^2 and phi, in ARPACK's order.
    std::pair<VectorXd, MatrixXd> modes() {
        VectorXd omega2(count_);
        MatrixXd shape(size_, count_);
        std::vector<int> select(static_cast<std::size_t>(basis_));
        int info = 0;
        arpack::seupd(1, arpack::howmny::ritz_vectors, select.data(), omega2.data(), shape.data(), size_, 0.0,
                      arpack::bmat::generalized, size_, arpack::which::largest_magnitude, count_, 0.0, start_.data(),
                      basis_, vectors_.data(), size_, parameter_.data(), place_.data(), work_.data(), lapack_.data(),
                      static_cast<int>(lapack_.size()), info);
        if (info != 0) throw Error(fmt::format("body.modes: ARPACK's status is {}", info));
        return {omega2, shape};
    }

private:
    Eigen::Ref<VectorXd> part(std::size_t which) { return work_.segment(place_[which] - 1, size_); }

    /// Y = L M X, where 1 says that M X is in the third place; or Y = M X.
    void answer(int asks) {
        if (asks == 2) {
            part(1) = mass_ * part(0);
            return;
        }
        MatrixXd b = asks == 1 ? MatrixXd(part(2)) : MatrixXd(mass_ * part(0)), x;
        l_.solve(b, x);
        part(1) = x.col(0);
    }

    const LinearSolver& l_;
    const Eigen::SparseMatrix<double>& mass_;
    int count_, size_, basis_;
    MatrixXd vectors_;
    VectorXd start_, work_, lapack_;
    std::array<int, 11> parameter_{1, 0, kMostRestarts, 1, 0, 0, 3};
    std::array<int, 14> place_{};
};

/// Length 1 in M.
void normalize(const Eigen::SparseMatrix<double>& mass, Eigen::Ref<VectorXd> phi) {
    phi /= std::sqrt(phi.dot(mass * phi));
}

/// Modes of one frequency: of all their mixtures, and of both signs, those that no rounding chooses. Phi Q, where
/// Phi^T M T = Q R of fixed vectors T and R has a positive diagonal.
void choose_shapes(const Eigen::SparseMatrix<double>& mass, Eigen::Ref<MatrixXd> phi) {
    MatrixXd fixed(phi.rows(), phi.cols());
    for (Index k = 0; k < fixed.cols(); ++k)
        for (Index i = 0; i < fixed.rows(); ++i)
            fixed(i, k) = std::sin(1.0 + static_cast<double>((7 + k) * i));  // no symmetry
    const MatrixXd along = transposed_product(phi, mass * fixed);
    MatrixXd q = orthonormal(along);
    for (Index k = 0; k < q.cols(); ++k)
        if (q.col(k).dot(along.col(k)) < 0.0) q.col(k) = -q.col(k);
    phi = product(phi, q);
    for (Index k = 0; k < phi.cols(); ++k) normalize(mass, phi.col(k));
}

void require_modes(const LinearSolver& l, const Eigen::SparseMatrix<double>& mass, const NaturalModes& modes) {
    MatrixXd image;
    l.solve(mass * modes.shape, image);
    for (Index k = 0; k < image.cols(); ++k) {
        const double omega = modes.omega_rad_per_s[k];
        const VectorXd off = omega * omega * image.col(k) - modes.shape.col(k);
        const double residual = std::sqrt(std::abs(off.dot(mass * off)));
        if (!(residual <= kLargestResidual))
            throw Error(
                fmt::format("body.modes: mode {} has the residual {:.1e}, where {:.0e} is rounding: K is not definite "
                            "beyond it; mend slivers in the mesh, or lower a Poisson's ratio near 0.5",
                            k + 1, residual, kLargestResidual));
    }
}

}  // namespace

NaturalModes find_modes(const LinearSolver& l, const Eigen::SparseMatrix<double>& mass, int count) {
    if (count < 1 || count > most_modes(mass.rows()))
        throw Error(fmt::format("body.modes: {} of a body that has {} unknowns", count, mass.rows()));
    Lanczos lanczos(l, mass, count);
    lanczos.iterate();
    auto [omega2, shape] = lanczos.modes();
    std::vector<Index> order(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Index>(k);
    std::sort(order.begin(), order.end(), [&values = omega2](Index a, Index b) { return values[a] < values[b]; });
    NaturalModes modes{VectorXd(count), MatrixXd(mass.rows(), count)};
    for (Index k = 0; k < count; ++k) {
        const Index from = order[static_cast<std::size_t>(k)];
        modes.omega_rad_per_s[k] = std::sqrt(omega2[from]);
        modes.shape.col(k) = shape.col(from);
        normalize(mass, modes.shape.col(k));
    }
    for (Index first = 0, next = 1; first < count; first = next++) {
        while (next < count && modes.omega_rad_per_s[next] <= kSameFrequency * modes.omega_rad_per_s[next - 1]) ++next;
        choose_shapes(mass, modes.shape.middleCols(first, next - first));
    }
    require_modes(l, mass, modes);
    return modes;
}

}  // namespace haptable
