// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/corrected_inverse.hpp"

#include <utility>

namespace haptable {

namespace {

/// The other's columns, each block corrected on its way into the sink.
class CorrectedColumns : public Columns {
public:
    CorrectedColumns(const CorrectedInverse& inverse, std::unique_ptr<Columns> whole,
                     std::span<const std::int32_t> node, std::span<const std::int32_t> row)
        : inverse_(inverse), whole_(std::move(whole)), node_(node.begin(), node.end()), row_(row.begin(), row.end()) {}

    std::size_t group_count() const override { return whole_->group_count(); }
    void for_each_block(std::size_t group, const Visit& visit) const override { whole_->for_each_block(group, visit); }
    ColumnFacts compute(Progress& progress, const Sink& sink) const override {
        Sink corrected = sink;
        corrected.take = [&](std::size_t c, std::size_t k, const Eigen::Matrix3f& block) {
            sink.take(c, k, (block.cast<double>() + inverse_.correction(row_[k], node_[c])).cast<float>());
        };
        return whole_->compute(progress, corrected);
    }

private:
    const CorrectedInverse& inverse_;
    std::unique_ptr<Columns> whole_;
    std::vector<std::int32_t> node_, row_;
};

}  // namespace

MemoryNeed CorrectedInverse::analyse(const Stiffness& k, const InverseRequest& request) {
    return whole_.analyse(k, request);
}

Blocks CorrectedInverse::blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) {
    Blocks found = whole_.blocks(wanted, precision, progress);
    for (std::size_t k = 0; k < wanted.size(); ++k) found.l_ij[k] += correction(wanted[k].row, wanted[k].column);
    return found;
}

std::unique_ptr<Columns> CorrectedInverse::columns(std::span<const std::int32_t> node,
                                                   std::span<const std::int32_t> row, Precision precision) {
    return std::make_unique<CorrectedColumns>(*this, whole_.columns(node, row, precision), node, row);
}

}  // namespace haptable
