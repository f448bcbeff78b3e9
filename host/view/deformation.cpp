// SPDX-License-Identifier: GPL-2.0-or-later
// u_r = sum over the loaded nodes i of L_ri F_i   (equation 8)
#include "host/view/deformation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "host/base/error.hpp"

// gcc 12 takes 32-byte vectors even where there are 64-byte ones; here those are 1.2 to 1.4 times as fast.
#ifdef __AVX512F__
#pragma GCC target("prefer-vector-width=512")
#endif

namespace haptable {

namespace {

constexpr std::size_t kLane = 16;          // floats of one vector, the widest there is: 64 bytes
constexpr std::size_t kBlock = 3 * kLane;  // coefficients of a block: one lane for each force component
constexpr std::size_t kAlign = kLane * sizeof(float);

float* aligned_floats(std::size_t count) {
    void* memory = std::aligned_alloc(kAlign, count * sizeof(float));  // count is a multiple of kLane
    if (memory == nullptr) throw std::bad_alloc();
    float* floats = static_cast<float*>(memory);
    std::fill_n(floats, count, 0.0F);
    return floats;
}

/// One sweep: u += (or =) L_a F_a + L_b F_b + L_c F_c. 18 operations and 9 loads for each component of u: the sweep is
/// as fast as the cache can bring the panels.
template <bool add>
void sweep(std::size_t blocks, const float* __restrict a, const float* __restrict b, const float* __restrict c,
           const float (&force)[9], float* __restrict u) noexcept {
    a = std::assume_aligned<kAlign>(a);
    b = std::assume_aligned<kAlign>(b);
    c = std::assume_aligned<kAlign>(c);
    u = std::assume_aligned<kAlign>(u);
    const auto [ax, ay, az, bx, by, bz, cx, cy, cz] = force;
    for (std::size_t k = 0; k < blocks; ++k, a += kBlock, b += kBlock, c += kBlock, u += kLane)
        for (std::size_t l = 0; l < kLane; ++l) {
            const float sum = a[l] * ax + a[kLane + l] * ay + a[2 * kLane + l] * az +  //
                              b[l] * bx + b[kLane + l] * by + b[2 * kLane + l] * bz +  //
                              c[l] * cx + c[kLane + l] * cy + c[2 * kLane + l] * cz;
            u[l] = add ? u[l] + sum : sum;
        }
}

}  // namespace

void Deformation::Free::operator()(float* memory) const { std::free(memory); }

Deformation::Deformation(const Tables& tables, const TablesFolder& folder)
    : rows_(tables.row_id.size()),
      blocks_((3 * rows_ + kLane - 1) / kLane),
      column_of_(tables.position.size(), -1),
      slot_of_(tables.node_id.size(), -1) {
    if (!tables.has_columns && !tables.has_factor)
        throw Error(folder.text() +
                    ": has no columns to draw a deformation from: set columns = \"surface\" "
                    "under [tables] of the scene and make the tables again");
    if (tables.has_factor) {
        open_factor(tables, folder);
        return;
    }
    columns_.emplace(tables, folder);
    for (std::size_t i = 0; i < tables.node_id.size(); ++i)
        column_of_[static_cast<std::size_t>(tables.node_id[i])] = static_cast<std::int32_t>(i);
    held_.fill(-1);
    panels_.reset(aligned_floats(kSlots * blocks_ * kBlock));
    displacement_.reset(aligned_floats(blocks_ * kLane));
}

void Deformation::open_factor(const Tables& tables, const TablesFolder& folder) {
    factor_.emplace(folder);
    unknown_of_.assign(tables.position.size(), -1);
    const auto fail = [&folder](std::int32_t node) {
        folder.fail("factor_unknown_node.npy", fmt::format("does not fit the tables at node {}", node));
    };
    for (std::size_t u = 0; u < factor_->unknown_node().size(); ++u) {
        const std::int32_t node = factor_->unknown_node()[u];
        if (node < 0 || static_cast<std::size_t>(node) >= unknown_of_.size()) fail(node);
        unknown_of_[static_cast<std::size_t>(node)] = static_cast<std::int32_t>(u);
    }
    std::vector<std::int32_t> row;
    for (std::int32_t node : tables.row_id) {
        row.push_back(unknown_of_[static_cast<std::size_t>(node)]);
        if (row.back() < 0) fail(node);
    }
    solver_.emplace(factor_->supernodes(), factor_->value().data(), row);
}

/// Rearranges a stored column, [r,3,3], into a panel: component 3 r + a of the displacement is lane (3 r + a) mod 16.
void Deformation::fill(std::int32_t column, float* panel) const noexcept {
    const std::size_t components = 3 * rows_;
    const std::size_t first = static_cast<std::size_t>(column) * components * 3;
    for (std::size_t k = 0; k < components; ++k)
        for (std::size_t b = 0; b < 3; ++b)
            panel[k / kLane * kBlock + b * kLane + k % kLane] = columns_->at(first + 3 * k + b);
}

float* Deformation::slot(std::size_t index) const noexcept { return panels_.get() + index * blocks_ * kBlock; }

/// The panel of a column; where it is not held it is filled into the oldest slot that this sweep does not use.
const float* Deformation::panel(std::int32_t column, const Group& in_use) noexcept {
    static_assert(kSlots > kGroup, "there must be a slot that the sweep does not use");
    std::int32_t& index = slot_of_[static_cast<std::size_t>(column)];
    if (index < 0) {
        while (std::find(in_use.begin(), in_use.end(), slot(next_slot_)) != in_use.end())
            next_slot_ = (next_slot_ + 1) % kSlots;
        if (held_[next_slot_] >= 0) slot_of_[static_cast<std::size_t>(held_[next_slot_])] = -1;
        held_[next_slot_] = column;
        index = static_cast<std::int32_t>(next_slot_);
        next_slot_ = (next_slot_ + 1) % kSlots;
        fill(column, slot(static_cast<std::size_t>(index)));
    }
    return slot(static_cast<std::size_t>(index));
}

std::span<const float> Deformation::displace(std::span<const NodalForce> loads) {
    return solver_ ? solve(loads) : multiply(loads);
}

std::span<const float> Deformation::solve(std::span<const NodalForce> loads) {
    std::vector<FrameSolver::Load> free;
    for (const NodalForce& load : loads) {
        const auto node = static_cast<std::size_t>(load.node);
        const std::int32_t unknown = node < unknown_of_.size() ? unknown_of_[node] : -1;
        if (unknown >= 0) free.push_back({unknown, {load.force_n[0], load.force_n[1], load.force_n[2]}});
    }
    return solver_->displace(free);
}

std::span<const float> Deformation::multiply(std::span<const NodalForce> loads) noexcept {
    bool first = true;
    std::size_t next = 0;
    do {
        Group group{};
        float force[3 * kGroup] = {};
        for (std::size_t g = 0; g < kGroup && next < loads.size(); ++next) {
            const auto node = static_cast<std::size_t>(loads[next].node);
            const std::int32_t column = node < column_of_.size() ? column_of_[node] : -1;
            if (column < 0) continue;
            group[g] = panel(column, group);
            std::copy_n(loads[next].force_n.data(), 3, force + 3 * g++);
        }
        // A group that is not full is filled up with forces of zero on some panel.
        std::replace(group.begin(), group.end(), static_cast<const float*>(nullptr),
                     static_cast<const float*>(panels_.get()));
        (first ? sweep<false> : sweep<true>)(blocks_, group[0], group[1], group[2], force, displacement_.get());
        first = false;
    } while (next < loads.size());
    return {displacement_.get(), 3 * rows_};
}

}  // namespace haptable
