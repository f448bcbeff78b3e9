// SPDX-License-Identifier: GPL-2.0-or-later
// The spatial index: a tree of bounding boxes on a 16-bit grid, halved at the median of the longest side.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

namespace {

constexpr double kGridSteps = 65520.0;  // the longest side of the surface; the rest of 65536 is margin
constexpr double kMargin = 8.0;         // grid steps before the lowest corner
constexpr double kSlack = 2.0;          // grid steps that a box is larger than its patches: covers the servo's rounding

using Point = std::array<double, 3>;

struct Bounds {
    Point low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    Point high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void add(const Point& x) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], x[axis]);
            high[axis] = std::max(high[axis], x[axis]);
        }
    }
    void add(const Bounds& other) {
        add(other.low);
        add(other.high);
    }
    double extent(std::size_t axis) const { return high[axis] - low[axis]; }
    std::size_t longest_axis() const {
        std::size_t axis = extent(1) > extent(0) ? 1 : 0;
        return extent(2) > extent(axis) ? 2 : axis;
    }
};

class Builder {
public:
    Builder(const std::vector<std::array<float, 3>>& vertex_m, const std::vector<std::array<std::uint16_t, 3>>& patch) {
        Bounds all;
        for (const auto& corners : patch) {
            Bounds box;
            for (std::uint16_t v : corners)
                box.add(Point{static_cast<double>(vertex_m[v][0]), static_cast<double>(vertex_m[v][1]),
                              static_cast<double>(vertex_m[v][2])});
            all.add(box);
            patches_.push_back(box);
        }
        lay_grid(all);
        index_.order.resize(patch.size());
        std::iota(index_.order.begin(), index_.order.end(), std::size_t{0});
    }

    SpatialIndex build() {
        if (!index_.order.empty()) divide(index_.order, 0);
        return std::move(index_);
    }

private:
    void lay_grid(const Bounds& all) {
        const double longest = patches_.empty() ? 1.0 : all.extent(all.longest_axis());
        index_.per_m = static_cast<float>(kGridSteps / longest);
        for (std::size_t axis = 0; axis < 3 && !patches_.empty(); ++axis)
            index_.origin_m[axis] = static_cast<float>(all.low[axis] - kMargin * longest / kGridSteps);
    }

    /// Lays down the box over `part` and, after it, those of its halves. `first` is part's place in the leaf order.
    void divide(std::span<std::size_t> part, std::size_t first) {
        const std::size_t here = index_.boxes.size();
        Bounds bounds;
        for (std::size_t p : part) bounds.add(patches_[p]);
        index_.boxes.push_back(on_grid(bounds));
        if (part.size() <= HAPTABLE_LEAF) {
            std::sort(part.begin(), part.end());
            index_.boxes[here].patch = static_cast<std::uint16_t>(first);
        } else {
            const std::size_t half = split(part, bounds);
            divide(part.first(half), first);
            divide(part.subspan(half), first + half);
        }
        index_.boxes[here].skip = static_cast<std::uint16_t>(index_.boxes.size());
    }

    /// Sorts `part` along its longest side and returns where to cut: in full leaves, so that only the last is short.
    std::size_t split(std::span<std::size_t> part, const Bounds& bounds) const {
        const std::size_t axis = bounds.longest_axis();
        const auto middle = [&](std::size_t p) { return patches_[p].low[axis] + patches_[p].high[axis]; };
        std::sort(part.begin(), part.end(),
                  [&](std::size_t a, std::size_t b) { return middle(a) != middle(b) ? middle(a) < middle(b) : a < b; });
        const std::size_t leaves = (part.size() + HAPTABLE_LEAF - 1) / HAPTABLE_LEAF;
        return (leaves + 1) / 2 * HAPTABLE_LEAF;
    }

    haptable_box on_grid(const Bounds& bounds) const {
        haptable_box box{{}, {}, 0, HAPTABLE_NONE};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto steps = [&](double x) {
                return (x - static_cast<double>(index_.origin_m[axis])) * static_cast<double>(index_.per_m);
            };
            box.low[axis] = static_cast<std::uint16_t>(std::floor(steps(bounds.low[axis]) - kSlack));
            box.high[axis] = static_cast<std::uint16_t>(std::ceil(steps(bounds.high[axis]) + kSlack));
        }
        return box;
    }

    std::vector<Bounds> patches_;
    SpatialIndex index_;
};

}  // namespace

SpatialIndex build_index(const std::vector<std::array<float, 3>>& vertex_m,
                         const std::vector<std::array<std::uint16_t, 3>>& patch) {
    return Builder(vertex_m, patch).build();
}

}  // namespace haptable
