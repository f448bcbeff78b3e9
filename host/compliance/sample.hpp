// SPDX-License-Identifier: GPL-2.0-or-later
// The guard of a run: plain solves of a sample of nodes. They share nothing with blocks() and columns() of an inverse
// but its factor, and their residual checks that.
#pragma once

#include "host/compliance/compliance.hpp"

namespace haptable {

struct Sample {
    std::vector<std::size_t> place;       ///< in the table
    std::vector<std::int32_t> node;       ///< unknowns
    Eigen::MatrixXd l;                    ///< [3 m, 3 m] among themselves, m/N
    std::vector<Eigen::MatrixXd> column;  ///< [3 r, 3] at the rows of columns.npy; empty without it
    double largest_residual = 0.0;        ///< ||K x - b|| / ||b||
};

/// Nodes of the table, spread evenly: at most 32, of a large body 16.
///   node, row  [n], [r] unknown nodes of the table and of the rows of columns.npy
Sample solve_sample(const LinearSolver& solver, const Stiffness& k, std::span<const std::int32_t> node,
                    std::span<const std::int32_t> row, Progress& progress);

/// Largest ||L_ii - solved|| / ||solved|| of the sample. l_ii: [n]
double largest_difference(const Sample& sample, std::span<const Eigen::Matrix3d> l_ii);

/// The sample's columns once more, in float: largest ||float - double|| / ||double|| of a column.
double float_column_error(Inverse& inverse, std::span<const std::int32_t> row, const Sample& sample,
                          Progress& progress);

}  // namespace haptable
