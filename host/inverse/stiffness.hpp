// SPDX-License-Identifier: GPL-2.0-or-later
//      [ A   G^T ]
//  M = [         ],   K = A + G^T G   is what eliminating the last rows of M leaves
//      [ G   -I  ]
//
// K of elements that average the change of volume over all elements at a node couples nodes that share no element; M
// does not. So M is what is factorised, at a fifth of the cost. A row of G is a pressure.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

namespace haptable {

/// The stiffness K (N/m) of n nodes, three rows each: symmetric; positive definite where the body is held still.
class Stiffness {
public:
    using Sparse = Eigen::SparseMatrix<double>;

    Stiffness() = default;
    /// K as it is, both triangles stored.
    Stiffness(Sparse k);  // NOLINT(google-explicit-constructor): a matrix is a stiffness
    /// K = A + G^T G.
    ///   a     [3n, 3n] both triangles stored; positive definite where K is
    ///   g     [m, 3n] (N/m)^1/2
    ///   node  [m] the unknown node that a row of G belongs to, or -1: the ordering keeps it with its node's rows
    Stiffness(const Sparse& a, const Eigen::SparseMatrix<double, Eigen::RowMajor>& g, std::vector<std::int32_t> node);

    Eigen::Index size() const { return matrix_.rows() - pressures(); }                  ///< 3n: rows of K
    Eigen::Index pressures() const { return static_cast<Eigen::Index>(node_.size()); }  ///< m
    /// M [3n + m, 3n + m], both triangles; K itself where m is 0.
    const Sparse& matrix() const { return matrix_; }
    /// The rows of M in bundles that an ordering keeps together: those of bundle b are row[begin[b]] .. row[begin[b +
    /// 1]
    /// - 1]. First the nodes, three rows and their pressures each; then pressures of no unknown node, one by one.
    struct Bundles {
        std::vector<std::int32_t> begin, row;
    };
    Bundles bundles() const;
    /// The row of K that a row of M is tied to; itself where it is one.
    Eigen::Index row_of_k(Eigen::Index row) const;

    /// K u for many columns: u [3n, k].
    Eigen::MatrixXd operator*(const Eigen::Ref<const Eigen::MatrixXd>& u) const;
    Eigen::VectorXd diagonal() const;  ///< of K
    /// K + share * (diagonal of K).
    Stiffness shifted(double share) const;
    double bytes() const;

private:
    Sparse matrix_;
    std::vector<std::int32_t> node_;
};

}  // namespace haptable
