// SPDX-License-Identifier: GPL-2.0-or-later
// Axis-aligned boxes around the patches of a surface: what the proxies search.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace haptable {

class PatchTree {
public:
    using Patch = std::array<std::int32_t, 3>;
    /// A patch with what does not change.
    struct Triangle {
        std::array<Eigen::Vector3d, 3> corner;  ///< m
        Eigen::Vector3d normal;
    };

    /// [v] points in m and [p] patches, counter-clockwise from outside.
    PatchTree(const std::vector<Eigen::Vector3d>& point_m, const std::vector<Patch>& patch);

    /// Calls visit(triangle) for each patch whose box overlaps that of what a sphere sweeps from a to b, m.
    template <typename Visit>
    void visit(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius_m, const Visit& visit) const {
        const Eigen::Vector3d low = a.cwiseMin(b).array() - radius_m, high = a.cwiseMax(b).array() + radius_m;
        for (std::size_t i = 0; i < box_.size();) {
            const Box& box = box_[i];
            if ((box.low.array() > high.array()).any() || (box.high.array() < low.array()).any()) {
                i = box.skip;
                continue;
            }
            if (box.patch >= 0) visit(triangle_[static_cast<std::size_t>(box.patch)]);
            ++i;
        }
    }

private:
    struct Box {
        Eigen::Vector3d low, high;  ///< of the patches, m
        std::uint32_t skip;         ///< the first box after this one's subtree
        std::int32_t patch;         ///< of a leaf, which has one; -1: inner box
    };

    void build(std::vector<std::int32_t>& patch, std::size_t begin, std::size_t end);

    std::vector<Triangle> triangle_;
    std::vector<Box> box_;
};

}  // namespace haptable
