// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/stiffness.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace haptable {

namespace {

using Sparse = Stiffness::Sparse;
using ByRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Writes the columns of M one after another: rows ascend.
class ColumnWriter {
public:
    ColumnWriter(Sparse& m, Eigen::Index size, Eigen::Index entries) : m_(m) {
        m_.resize(size, size);
        m_.resizeNonZeros(entries);
    }
    void add(Eigen::Index row, double value) {
        m_.innerIndexPtr()[next_] = static_cast<int>(row);
        m_.valuePtr()[next_++] = value;
    }
    void end_column() { m_.outerIndexPtr()[++column_] = next_; }

private:
    Sparse& m_;
    int next_ = 0;
    Eigen::Index column_ = 0;
};

/// M x. Eight columns side by side fill one cache line a row: that costs a third of what column after column does.
Eigen::MatrixXd multiply(const Sparse& m, const Eigen::Ref<const Eigen::MatrixXd>& x) {
    constexpr int kColumnsAtOnce = 8;
    using Panel = Eigen::Matrix<double, Eigen::Dynamic, kColumnsAtOnce, Eigen::RowMajor>;
    Eigen::MatrixXd product(x.rows(), x.cols());
    Panel from = Panel::Zero(x.rows(), kColumnsAtOnce), to(x.rows(), kColumnsAtOnce);
    for (Eigen::Index first = 0; first < x.cols(); first += kColumnsAtOnce) {
        const Eigen::Index count = std::min<Eigen::Index>(kColumnsAtOnce, x.cols() - first);
        from.leftCols(count) = x.middleCols(first, count);
        to.noalias() = m.transpose() * from;  // M is symmetric, and its transpose reads by rows
        product.middleCols(first, count) = to.leftCols(count);
    }
    return product;
}

}  // namespace

Stiffness::Stiffness(Sparse k) {
    matrix_.swap(k);  // Eigen's would be copied by a move
    matrix_.makeCompressed();
}

Stiffness::Stiffness(const Sparse& a, const ByRows& g, std::vector<std::int32_t> node) : node_(std::move(node)) {
    const Sparse by_columns = g;
    const Eigen::Index n = a.rows();
    ColumnWriter column(matrix_, n + pressures(), a.nonZeros() + 2 * g.nonZeros() + pressures());
    for (Eigen::Index j = 0; j < n; ++j) {
        for (Sparse::InnerIterator entry(a, j); entry; ++entry) column.add(entry.row(), entry.value());
        for (Sparse::InnerIterator entry(by_columns, j); entry; ++entry) column.add(n + entry.row(), entry.value());
        column.end_column();
    }
    for (Eigen::Index p = 0; p < pressures(); ++p) {
        for (ByRows::InnerIterator entry(g, p); entry; ++entry) column.add(entry.col(), entry.value());
        column.add(n + p, -1.0);
        column.end_column();
    }
}

Stiffness::Bundles Stiffness::bundles() const {
    const auto nodes = static_cast<std::int32_t>(size() / 3);
    std::vector<std::int32_t> bundle_of;
    for (std::int32_t row = 0; row < 3 * nodes; ++row) bundle_of.push_back(row / 3);
    std::int32_t count = nodes;
    for (std::int32_t node : node_) bundle_of.push_back(node >= 0 ? node : count++);
    Bundles bundles{std::vector<std::int32_t>(static_cast<std::size_t>(count) + 1, 0),
                    std::vector<std::int32_t>(bundle_of.size())};
    for (std::int32_t b : bundle_of) ++bundles.begin[static_cast<std::size_t>(b) + 1];
    std::partial_sum(bundles.begin.begin(), bundles.begin.end(), bundles.begin.begin());
    std::vector<std::int32_t> next = bundles.begin;
    for (std::size_t row = 0; row < bundle_of.size(); ++row)
        bundles.row[static_cast<std::size_t>(next[static_cast<std::size_t>(bundle_of[row])]++)] =
            static_cast<std::int32_t>(row);
    return bundles;
}

Eigen::Index Stiffness::row_of_k(Eigen::Index row) const {
    return row < size() ? row : Sparse::InnerIterator(matrix_, row).row();
}

Eigen::MatrixXd Stiffness::operator*(const Eigen::Ref<const Eigen::MatrixXd>& u) const {
    if (pressures() == 0) return multiply(matrix_, u);
    // M (u, 0) = (A u, G u),   M (u, G u) = (K u, 0)
    Eigen::MatrixXd x = Eigen::MatrixXd::Zero(matrix_.rows(), u.cols());
    x.topRows(size()) = u;
    x.bottomRows(pressures()) = multiply(matrix_, x).bottomRows(pressures());
    return multiply(matrix_, x).topRows(size());
}

Eigen::VectorXd Stiffness::diagonal() const {
    Eigen::VectorXd diagonal = matrix_.diagonal().head(size());
    for (Eigen::Index p = size(); p < matrix_.cols(); ++p)
        for (Sparse::InnerIterator entry(matrix_, p); entry.row() < size(); ++entry)
            diagonal[entry.row()] += entry.value() * entry.value();
    return diagonal;
}

Stiffness Stiffness::shifted(double share) const {
    Stiffness k = *this;
    const Eigen::VectorXd d = diagonal();
    for (Eigen::Index j = 0; j < size(); ++j) k.matrix_.coeffRef(j, j) += share * d[j];
    return k;
}

double Stiffness::bytes() const { return static_cast<double>(matrix_.nonZeros()) * (sizeof(double) + sizeof(int)); }

}  // namespace haptable
