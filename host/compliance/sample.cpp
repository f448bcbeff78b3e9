// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/compliance/sample.hpp"

#include <algorithm>
#include <cmath>

#include "host/base/index.hpp"

namespace haptable {

namespace {

/// A large body's solves are long.
std::size_t size_of_sample(std::size_t nodes, std::size_t unknown_nodes) {
    constexpr std::size_t kLarge = 20000;
    return std::min(nodes, (unknown_nodes < kLarge ? 2 : 1) * kNodesPerBlock);
}

}  // namespace

Sample solve_sample(const LinearSolver& solver, const Stiffness& k, std::span<const std::int32_t> node,
                    std::span<const std::int32_t> row, Progress& progress) {
    Sample sample;
    const std::size_t count = size_of_sample(node.size(), static_cast<std::size_t>(k.size()) / 3);
    for (std::size_t c = 0; c < count; ++c) {
        sample.place.push_back(c * node.size() / count);
        sample.node.push_back(node[sample.place.back()]);
    }
    sample.l.resize(dof(count), dof(count));
    const auto take = [&](std::size_t first, const Eigen::MatrixXd& x) {
        for (std::size_t j = 0; j < count; ++j)
            sample.l.block(dof(j), dof(first), 3, x.cols()) = x.middleRows<3>(dof(sample.node[j]));
        for (std::size_t c = 0; c < static_cast<std::size_t>(x.cols()) / 3; ++c) {
            Eigen::MatrixXd& column = sample.column.emplace_back(dof(row.size()), 3);
            for (std::size_t r = 0; r < row.size(); ++r)
                column.middleRows<3>(dof(r)) = x.block<3, 3>(dof(row[r]), dof(c));
        }
    };
    sample.largest_residual = solve_columns(solver, k, sample.node, progress, take);
    return sample;
}

double largest_difference(const Sample& sample, std::span<const Eigen::Matrix3d> l_ii) {
    double largest = 0.0;
    for (std::size_t c = 0; c < sample.place.size(); ++c) {
        const Eigen::Matrix3d solved = sample.l.block<3, 3>(dof(c), dof(c));
        largest = std::max(largest, (l_ii[sample.place[c]] - solved).norm() / solved.norm());
    }
    return largest;
}

double float_column_error(Inverse& inverse, std::span<const std::int32_t> row, const Sample& sample,
                          Progress& progress) {
    Eigen::ArrayXXd squared(static_cast<Eigen::Index>(row.size()), static_cast<Eigen::Index>(sample.node.size()));
    Columns::Sink sink;
    sink.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& l_ri) {
        squared(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) =
            (l_ri.cast<double>() - sample.column[c].middleRows<3>(dof(k))).squaredNorm();
    };
    inverse.columns(sample.node, row, Precision::kFloat)->compute(progress, sink);
    double largest = 0.0;
    for (std::size_t c = 0; c < sample.node.size(); ++c) {
        const double error = std::sqrt(squared.col(static_cast<Eigen::Index>(c)).sum()) / sample.column[c].norm();
        largest = std::max(largest, error < 1.0 ? error : 1.0);  // a NaN is no digit either
    }
    return largest;
}

}  // namespace haptable
