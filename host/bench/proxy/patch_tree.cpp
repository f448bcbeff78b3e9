// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/proxy/patch_tree.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace haptable {

using Eigen::Vector3d;

PatchTree::PatchTree(const std::vector<Vector3d>& point_m, const std::vector<Patch>& patch) {
    for (const Patch& p : patch) {
        Triangle t;
        for (std::size_t c = 0; c < 3; ++c) t.corner[c] = point_m[static_cast<std::size_t>(p[c])];
        t.normal = (t.corner[1] - t.corner[0]).cross(t.corner[2] - t.corner[0]).normalized();
        triangle_.push_back(t);
    }
    std::vector<std::int32_t> order(patch.size());
    std::iota(order.begin(), order.end(), 0);
    build(order, 0, order.size());
}

/// Halves of as many patches, by their middle along the longest axis.
void PatchTree::build(std::vector<std::int32_t>& patch, std::size_t begin, std::size_t end) {
    const auto of = [&](std::int32_t p) -> const Triangle& { return triangle_[static_cast<std::size_t>(p)]; };
    Eigen::AlignedBox3d bounds;
    for (std::size_t i = begin; i < end; ++i)
        for (const Vector3d& corner : of(patch[i]).corner) bounds.extend(corner);
    const std::size_t index = box_.size();
    box_.push_back({bounds.min(), bounds.max(), 0, end - begin == 1 ? patch[begin] : -1});
    if (end - begin > 1) {
        Eigen::Index axis = 0;
        bounds.sizes().maxCoeff(&axis);
        const std::size_t middle = begin + (end - begin) / 2;
        const auto place = [&](std::int32_t p) {
            return of(p).corner[0][axis] + of(p).corner[1][axis] + of(p).corner[2][axis];
        };
        const auto first = patch.begin();
        std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                         first + static_cast<std::ptrdiff_t>(end),
                         [&](std::int32_t a, std::int32_t b) { return place(a) < place(b); });
        build(patch, begin, middle);
        build(patch, middle, end);
    }
    box_[index].skip = static_cast<std::uint32_t>(box_.size());
}

}  // namespace haptable
