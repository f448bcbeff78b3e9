// SPDX-License-Identifier: GPL-2.0-or-later
// L of another inverse with a product of low rank added to every block.
#pragma once

#include "host/inverse/inverse.hpp"

namespace haptable {

/// Blocks and columns stay as fast as the other's: each costs that product more.
class CorrectedInverse : public Inverse {
public:
    MemoryNeed analyse(const Stiffness& k, const InverseRequest& request) override;
    Eigen::Index size() const override { return whole_.size(); }
    Blocks blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) override;
    std::unique_ptr<Columns> columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                     Precision precision) override;
    bool is_distributed() const override { return whole_.is_distributed(); }
    std::vector<ProcessCost> processes() const override { return whole_.processes(); }

    /// L_ij less the other's, m/N. After factorize().
    virtual Eigen::Matrix3d correction(std::int32_t i, std::int32_t j) const = 0;

protected:
    /// whole: must outlive it; asked for what it is asked for.
    explicit CorrectedInverse(Inverse& whole) : whole_(whole) {}
    Inverse& whole() const { return whole_; }

private:
    Inverse& whole_;
};

}  // namespace haptable
