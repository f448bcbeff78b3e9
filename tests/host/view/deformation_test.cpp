// SPDX-License-Identifier: GPL-2.0-or-later
// Equation 8 against a plain sum of a dense inverse.
#include "host/view/deformation.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <random>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

class ViewDeformation : public WithCube {
protected:
    /// L_ri F_i; held and inner nodes have none.
    Vector3d expected(std::int32_t row, const NodalForce& load) const {
        const auto& touchable = tables_.node_id;
        if (std::find(touchable.begin(), touchable.end(), load.node) == touchable.end()) return Vector3d::Zero();
        const auto at = [&](std::int32_t node) { return 3 * body_.unknown[std::size_t(node)]; };
        return inverse_.l.block<3, 3>(at(row), at(load.node)) * Eigen::Vector3f(load.force_n.data()).cast<double>();
    }

    void expect_equation_8(Deformation& deformation, const std::vector<NodalForce>& loads) const {
        const std::span<const float> u = deformation.displace(loads);
        ASSERT_EQ(u.size(), 3 * tables_.row_id.size());
        double added = 0.0, error = 0.0;
        for (std::size_t r = 0; r < tables_.row_id.size(); ++r) {
            Vector3d sum = Vector3d::Zero();
            double terms = 0.0;
            for (const NodalForce& load : loads) {
                const Vector3d moved = expected(tables_.row_id[r], load);
                sum += moved;
                terms += moved.norm();
            }
            added = std::max(added, terms);
            error = std::max(error, (sum - Vector3d(u[3 * r], u[3 * r + 1], u[3 * r + 2])).norm());
        }
        // Three products a load and row, of a rounded column and a rounded force; terms may cancel.
        EXPECT_WITHIN(error, .count = 8.0 * std::sqrt(3.0 * double(loads.size())), .epsilon = kFloat, .size = added)
            << loads.size() << " loads";
    }

    const Scene scene_ = cube_with({});
    const Body body_ = make_body(scene_, make_mesh(scene_.mesh));
    const DenseInverse inverse_{scene_, body_};
};

TEST_F(ViewDeformation, IsTheSumOfEquation8ForAnyNumberOfLoads) {
    Deformation deformation(tables_, folder_.path());
    std::mt19937 random(1);
    std::uniform_int_distribution<std::int32_t> node(0, std::int32_t(tables_.position.size()) - 1);
    std::uniform_real_distribution<float> force(-1.0F, 1.0F);
    // 73 columns do not fit the slots at once: panels are pushed out and filled again.
    for (int trial = 0; trial < 400; ++trial) {
        std::vector<NodalForce> loads(std::size_t(trial % 9));
        for (NodalForce& load : loads) load = {node(random), {force(random), force(random), force(random)}};
        expect_equation_8(deformation, loads);
    }
    std::vector<NodalForce> all;  // thrice every node at once
    for (int repeat = 0; repeat < 3; ++repeat)
        for (const std::int32_t i : tables_.node_id) all.push_back({i, {0.01F, -0.02F, 0.03F}});
    expect_equation_8(deformation, all);
    for (const float u : deformation.displace({})) EXPECT_EQ(u, 0.0F);
    const NodalForce fixed{7, {1.0F, 2.0F, 3.0F}};
    for (const float u : deformation.displace({&fixed, 1})) EXPECT_EQ(u, 0.0F);
}

TEST_F(ViewDeformation, UsesNoHeap) {
    Deformation deformation(tables_, folder_.path());
    std::vector<NodalForce> loads;
    for (const std::int32_t node : tables_.node_id) loads.push_back({node, {1.0F, 1.0F, 1.0F}});
    const auto before = mallinfo2();
    deformation.displace(loads);
    const auto after = mallinfo2();
    EXPECT_EQ(before.uordblks, after.uordblks);
    EXPECT_EQ(before.fordblks, after.fordblks);
}

TEST(ViewDeformationErrors, SaysHowToGetColumnsAndRefusesThoseOfOtherTables) {
    const TemporaryFolder without, whole, other;
    write_cube_tables(without.path(), {.columns = ColumnRows::kNone});
    write_cube_tables(whole.path());
    write_cube_tables(other.path(), {.nodes_per_side = 4});
    EXPECT_TRUE(fails_with([&] { Deformation(read_tables(without.path()), without.path()); }, "columns = \"surface\""));
    EXPECT_THROW(Deformation(read_tables(whole.path()), other.path()), Error);
}

}  // namespace
}  // namespace haptable::test
