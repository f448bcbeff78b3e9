// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/free_inverse.hpp"

#include <Eigen/Cholesky>
#include <utility>

namespace haptable {

namespace {

/// The held body's columns, each block relieved on its way into the sink.
class FreeColumns : public Columns {
public:
    FreeColumns(const FreeInverse& inverse, std::unique_ptr<Columns> held, std::span<const std::int32_t> node,
                std::span<const std::int32_t> row)
        : inverse_(inverse), held_(std::move(held)), node_(node.begin(), node.end()), row_(row.begin(), row.end()) {}

    std::size_t group_count() const override { return held_->group_count(); }
    void for_each_block(std::size_t group, const Visit& visit) const override { held_->for_each_block(group, visit); }
    ColumnFacts compute(Progress& progress, const Sink& sink) const override {
        Sink relieved = sink;
        relieved.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& block) {
            sink.take(c, k, (block.cast<double>() + inverse_.relief(row_[k], node_[c])).cast<float>());
        };
        return held_->compute(progress, relieved);
    }

private:
    const FreeInverse& inverse_;
    std::unique_ptr<Columns> held_;
    std::vector<std::int32_t> node_, row_;
};

}  // namespace

FreeInverse::FreeInverse(Inverse& held, const Eigen::MatrixXd& r, const Eigen::MatrixXd& mr) : held_(held) {
    // R^T M R = G G^T: R G^-T is orthonormal in M.
    const Eigen::MatrixXd g = Eigen::MatrixXd(r.transpose() * mr).llt().matrixL();
    const auto solve = g.triangularView<Eigen::Lower>();
    r_ = solve.solve(r.transpose()).transpose();
    mr_ = solve.solve(mr.transpose()).transpose();
}

MemoryNeed FreeInverse::analyse(const Stiffness& k_c, const InverseRequest& request) {
    return held_.analyse(k_c, request);
}

FactorFacts FreeInverse::factorize(const Stiffness& k_c, Progress& progress) {
    FactorFacts facts = held_.factorize(k_c, progress);
    if (facts.weakest && !(facts.weakest->ratio > 0.0)) return facts;
    Eigen::MatrixXd y;
    held_.solve(mr_, y);
    u_ = y - 0.5 * r_ * (mr_.transpose() * y);
    return facts;
}

void FreeInverse::balance(Eigen::MatrixXd& b) const { b -= mr_ * (r_.transpose() * b).eval(); }

void FreeInverse::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    Eigen::MatrixXd balanced = b;
    balance(balanced);
    held_.solve(balanced, x);
    x -= r_ * (mr_.transpose() * x).eval();
}

Eigen::Matrix3d FreeInverse::relief(std::int32_t i, std::int32_t j) const {
    const Eigen::Index a = Eigen::Index{3} * i, b = Eigen::Index{3} * j;
    return -(r_.middleRows<3>(a) * u_.middleRows<3>(b).transpose() +
             u_.middleRows<3>(a) * r_.middleRows<3>(b).transpose());
}

Blocks FreeInverse::blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) {
    Blocks found = held_.blocks(wanted, precision, progress);
    for (std::size_t k = 0; k < wanted.size(); ++k) found.l_ij[k] += relief(wanted[k].row, wanted[k].column);
    return found;
}

std::unique_ptr<Columns> FreeInverse::columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                              Precision precision) {
    return std::make_unique<FreeColumns>(*this, held_.columns(node, row, precision), node, row);
}

}  // namespace haptable
