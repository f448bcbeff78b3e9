// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/cholmod_inverse.hpp"

#include <algorithm>
#include <thread>

#include "host/base/hash.hpp"
#include "host/inverse/column_solver.hpp"
#include "host/inverse/numeric.hpp"
#include "host/inverse/pairs.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/inverse/solve/blas_core.hpp"

namespace haptable {

namespace {

/// All processors, unless a number is wanted.
int all_threads(int wanted) {
    return wanted > 0 ? wanted : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// Below about ten thousand nodes the supernodes are too small to share.
int threads_for(int wanted, Eigen::Index nodes) {
    constexpr Eigen::Index kSmall = 10000;
    return wanted == 0 && nodes < kSmall ? 1 : all_threads(wanted);
}

std::uint64_t hash_of(const Stiffness& k) {
    const Stiffness::Sparse& m = k.matrix();
    const auto entries = static_cast<std::size_t>(m.nonZeros());
    const Stiffness::Bundles bundles = k.bundles();
    Hash hash;
    hash.add(std::span(m.outerIndexPtr(), static_cast<std::size_t>(m.cols()) + 1));
    hash.add(std::span(m.innerIndexPtr(), entries));
    hash.add(std::span(m.valuePtr(), entries));
    hash.add(std::span<const std::int32_t>(bundles.begin));
    hash.add(std::span<const std::int32_t>(bundles.row));
    return hash.digest();
}

}  // namespace

bool CholmodInverse::in_pattern(std::span<const NodePair> wanted) const {
    const std::vector<char> inside = find_in_pattern(factor_->supernodes(), wanted);
    return std::count(inside.begin(), inside.end(), 0) == 0;
}

MemoryNeed CholmodInverse::analyse(const Stiffness& k, const InverseRequest& request) {
    if (const std::uint64_t hash = hash_of(k); !factor_ || hash != of_) {
        is_factorized_ = false;
        workers_.emplace(threads_for(threads_, k.size() / 3));
        reserve_blas(workers_->count());
        factor_.emplace(k, Factor::kPattern);
        of_ = hash;
    }
    const Supernodes pattern = factor_->supernodes();
    const int threads = workers_->count();
    MemoryNeed need;
    need.stiffness = k.bytes();
    if (!is_factorized_) need.factor = factor_->bytes() + factorize_bytes(pattern, threads);
    for (const std::span<const NodePair> wanted : request.blocks)
        if (in_pattern(wanted))  // in double: after a trial in float it may have to be done again
            need.fronts = std::max(
                need.fronts,
                sizeof(double) * static_cast<double>(SelectedInversion(pattern, wanted).stack_entries(threads)));
        else
            need.pairs = std::max(need.pairs, CompliancePairs(pattern, wanted).bytes(all_threads(threads_)) +
                                                  2.0 * static_cast<double>(wanted.size()) * sizeof(Eigen::Matrix3d));
    for (const Precision precision : {Precision::kDouble, Precision::kFloat})
        if (!request.node.empty() && (precision == Precision::kDouble || request.float_columns))
            need.columns =
                std::max(need.columns, ColumnSolver(pattern, request.node, request.row, precision).bytes(threads));
    need.solves = 4.0 * static_cast<double>(k.matrix().rows()) * request.right_sides * sizeof(double);
    need.available = available_memory();
    return need;
}

FactorFacts CholmodInverse::factorize(const Stiffness& k, Progress& progress) {
    if (!is_factorized_) factor_->factorize(k, *workers_, progress);
    is_factorized_ = true;
    return {"METIS", factor_->fill(), factor_->flops(), workers_->count(), factor_->weakest_pivot()};
}

Blocks CholmodInverse::blocks(std::span<const NodePair> wanted, Precision precision, Progress& progress) {
    factor_->release_workspace();
    if (!in_pattern(wanted)) {
        const CompliancePairs pairs(factor_->supernodes(), wanted);
        reserve_blas(all_threads(threads_));
        Workers all(all_threads(threads_));  // groups of nodes are worth sharing in a body of any size
        return {pairs.compute(progress, &all), {pairs.method(), Precision::kDouble, pairs.flops()}};
    }
    const SelectedInversion inversion(factor_->supernodes(), wanted);
    const BlockFacts facts{"selected inversion", precision, inversion.flops()};
    if (precision == Precision::kFloat) return {inversion.compute<float>(progress, &*workers_), facts};
    return {inversion.compute<double>(progress, &*workers_), facts};
}

std::unique_ptr<Columns> CholmodInverse::columns(std::span<const std::int32_t> node, std::span<const std::int32_t> row,
                                                 Precision precision) {
    return std::make_unique<ColumnSolver>(factor_->supernodes(), node, row, precision, &*workers_);
}

}  // namespace haptable
