// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/dense.hpp"

#include <Eigen/Dense>

namespace haptable::dense {

using Eigen::MatrixXd;

MatrixXd inverse(const MatrixXd& a) { return a.fullPivLu().inverse(); }
MatrixXd solve(const MatrixXd& a, const MatrixXd& b) { return a.fullPivLu().solve(b); }

}  // namespace haptable::dense
