// SPDX-License-Identifier: GPL-2.0-or-later
// Equation 8 against a plain sum in double precision.
#include "host/view/deformation.hpp"

#include <gtest/gtest.h>
#include <malloc.h>

#include <Eigen/LU>
#include <algorithm>
#include <random>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

class ViewDeformation : public ::testing::Test {
protected:
    ViewDeformation() {
        write_cube_tables(folder_.path());
        tables_ = read_tables(folder_.path());
    }

    Vector3d position(std::int32_t node) const {
        return Vector3d(tables_.position[static_cast<std::size_t>(node)].data());
    }

    bool is_fixed(std::int32_t node) const {
        return std::find(tables_.node_id.begin(), tables_.node_id.end(), node) == tables_.node_id.end();
    }

    /// u_r = sum L_ri F_i, straight from the compliance that the tables were made of.
    Vector3d expected(std::int32_t row, const std::vector<NodalForce>& loads) const {
        Vector3d u = Vector3d::Zero();
        for (const NodalForce& load : loads)
            if (!is_fixed(load.node))
                u += cube_compliance(position(row), position(load.node)) *
                     Vector3d(load.force_n[0], load.force_n[1], load.force_n[2]);
        return u;
    }

    void expect_equation_8(Deformation& deformation, const std::vector<NodalForce>& loads) const {
        const std::span<const float> u = deformation.displace(loads);
        ASSERT_EQ(u.size(), 3 * tables_.row_id.size());
        double added = 0.0, error = 0.0;
        for (std::size_t r = 0; r < tables_.row_id.size(); ++r) {
            const Vector3d reference = expected(tables_.row_id[r], loads);
            double terms = 0.0;
            for (const NodalForce& load : loads) terms += expected(tables_.row_id[r], {load}).norm();
            added = std::max(added, terms);
            error = std::max(error, (reference - Vector3d(u[3 * r], u[3 * r + 1], u[3 * r + 2])).norm());
        }
        // Three products a load and row, of a rounded column and a rounded force; terms may cancel.
        const double products = 3.0 * static_cast<double>(loads.size());
        EXPECT_WITHIN(error, .count = 8.0 * std::sqrt(products), .epsilon = kFloat, .size = added)
            << loads.size() << " loads";
    }

    TemporaryFolder folder_;
    Tables tables_;
};

TEST_F(ViewDeformation, IsTheSumOfEquation8ForAnyNumberOfLoads) {
    Deformation deformation(tables_, folder_.path());
    std::mt19937 random(1);
    std::uniform_int_distribution<std::int32_t> node(0, static_cast<std::int32_t>(tables_.position.size()) - 1);
    std::uniform_real_distribution<float> force(-1.0F, 1.0F);
    // 73 columns do not fit the slots at once: panels are pushed out and filled again.
    for (int trial = 0; trial < 400; ++trial) {
        std::vector<NodalForce> loads(static_cast<std::size_t>(trial % 9));
        for (NodalForce& load : loads) load = {node(random), {force(random), force(random), force(random)}};
        expect_equation_8(deformation, loads);
    }
}

TEST_F(ViewDeformation, TakesManyLoadsAtOnce) {
    Deformation deformation(tables_, folder_.path());
    std::vector<NodalForce> loads;
    for (int repeat = 0; repeat < 3; ++repeat)
        for (const std::int32_t node : tables_.node_id) loads.push_back({node, {0.01F, -0.02F, 0.03F}});
    expect_equation_8(deformation, loads);
}

TEST_F(ViewDeformation, MovesALoadedNodeAsItsStiffnessSays) {
    Deformation deformation(tables_, folder_.path());
    const Vector3d u(0.001, -0.002, -0.004);
    for (std::size_t i = 0; i < tables_.node_id.size(); ++i) {
        const Eigen::Map<const Eigen::Matrix3d> stiffness(tables_.stiffness[i].data());
        const Eigen::Vector3f force = (stiffness * u).cast<float>();
        const NodalForce load{tables_.node_id[i], {force.x(), force.y(), force.z()}};
        const std::span<const float> moved = deformation.displace({&load, 1});
        const auto row = static_cast<std::size_t>(std::find(tables_.row_id.begin(), tables_.row_id.end(), load.node) -
                                                  tables_.row_id.begin());
        const double condition = stiffness.norm() * stiffness.inverse().norm();
        for (int c = 0; c < 3; ++c)
            EXPECT_WITHIN(std::abs(moved[3 * row + static_cast<std::size_t>(c)] - u[c]), .count = 8, .epsilon = kFloat,
                          .condition = condition, .size = u.norm());
    }
}

TEST_F(ViewDeformation, AFixedNodeMovesNothing) {
    Deformation deformation(tables_, folder_.path());
    ASSERT_TRUE(is_fixed(7));
    const NodalForce load{7, {1.0F, 2.0F, 3.0F}};
    for (const float u : deformation.displace({&load, 1})) EXPECT_EQ(u, 0.0F);
}

TEST_F(ViewDeformation, NoLoadsMoveNothingAfterLoadsDid) {
    Deformation deformation(tables_, folder_.path());
    const NodalForce load{112, {1.0F, 2.0F, 3.0F}};
    deformation.displace({&load, 1});
    for (const float u : deformation.displace({})) EXPECT_EQ(u, 0.0F);
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

TEST(ViewDeformationErrors, SaysHowToGetColumns) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path(), {.columns = "none"});
    const Tables tables = read_tables(folder.path());
    const std::string said = error_of([&] { const Deformation deformation(tables, folder.path()); });
    EXPECT_NE(said.find("columns = \"surface\""), std::string::npos) << said;
}

TEST(ViewDeformationErrors, RefusesColumnsOfOtherTables) {
    const TemporaryFolder folder, other;
    write_cube_tables(folder.path());
    write_cube_tables(other.path(), {.nodes_per_side = 4});
    const Tables tables = read_tables(folder.path());
    EXPECT_THROW(Deformation(tables, other.path()), Error);
}

}  // namespace
}  // namespace haptable::test
