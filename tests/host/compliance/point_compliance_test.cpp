// SPDX-License-Identifier: GPL-2.0-or-later
// Which blocks of L the masks ask for. That their compliance is w^T L w, tests/firmware/compliance_test.cpp shows.
#include "host/compliance/point_compliance.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

TEST(MaskPairs, AreThoseUnderOnePatchEachOnceAndAscending) {
    const Shape shape = box_shape(6, Eigen::Vector3d(0.03, 0.03, 0.03));  // its bottom is held
    std::vector<std::int32_t> unknown(shape.point.size(), -1);
    std::int32_t free = 0;
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (shape.point[i].z() > 1e-9) unknown[i] = free++;
    Workers workers(1);
    Progress quiet(true);
    const Masks masks = make_masks(shape.point, shape.patch, 0.008, workers, quiet);
    const std::vector<NodePair> pairs = mask_pairs(masks, unknown, workers);
    std::set<std::pair<int, int>> expected, found;
    for (const auto& controls : masks.control)
        for (std::size_t j : controls)
            for (std::size_t k : controls)
                for (std::int32_t a : masks.weights(j).node)
                    for (std::int32_t b : masks.weights(k).node)
                        if (const auto [low, high] = std::minmax(unknown[std::size_t(a)], unknown[std::size_t(b)]);
                            low >= 0)
                            expected.insert({low, high});
    for (const NodePair& p : pairs) EXPECT_TRUE(found.insert({p.row, p.column}).second);
    EXPECT_EQ(found, expected);
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end(), [](const NodePair& a, const NodePair& b) {
        return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    }));
}

}  // namespace
}  // namespace haptable::test
