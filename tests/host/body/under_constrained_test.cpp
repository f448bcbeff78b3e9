// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/under_constrained.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <random>

#include "host/fem/stiffness.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/cube.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/pressures.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Nodes = std::vector<std::int32_t>;

Body body_of(const TetMesh& mesh, const Nodes& fixed) {
    Body body;
    body.mesh = mesh;
    body.surface = find_surface(mesh.tet);
    for (std::int32_t i = 0; i < std::int32_t(mesh.position_m.size()); ++i) {
        const bool is_fixed = std::find(fixed.begin(), fixed.end(), i) != fixed.end();
        body.unknown.push_back(is_fixed ? -1 : std::int32_t(body.free_node.size()));
        if (!is_fixed) body.free_node.push_back(i);
    }
    return body;
}

Eigen::SparseMatrix<double> stiffness(const Body& body) {
    const std::vector<Lame> material(body.mesh.tet.size(), Lame::from_young(1e4, 0.3));
    return assemble_stiffness({Element::kLinear, body.mesh.position_m, body.mesh.tet, material}, body.unknown,
                              std::int32_t(body.free_node.size()))
        .a;
}

/// The same from K itself, densely: nodes that move in its null space.
Nodes by_eigenvectors(const Body& body) {
    Nodes moving;
    if (body.free_node.empty()) return moving;
    const auto eigen = dense::eigen(stiffness(body));
    const double largest = eigen.values.maxCoeff();
    for (std::size_t k = 0; k < body.free_node.size(); ++k) {
        double speed = 0.0;
        for (Eigen::Index m = 0; m < eigen.values.size(); ++m)
            if (eigen.values[m] < 1e-11 * largest) speed += eigen.vectors.block<3, 1>(3 * Eigen::Index(k), m).norm();
        if (speed > 1e-6) moving.push_back(body.free_node[k]);
    }
    return moving;
}

TetMesh tets_of(const std::vector<Eigen::Vector3d>& position_m, const std::vector<Tet>& tets) {
    TetMesh mesh;
    mesh.position_m = position_m;
    mesh.tet = tets;
    for (Tet& tet : mesh.tet)
        if (six_volumes(position_m, tet) < 0.0) std::swap(tet[2], tet[3]);
    return mesh;
}

/// Two tetrahedra that share an edge (nodes 0, 1).
TetMesh edge_hinge() {
    return tets_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.3, 1}, {0.1, -1, 0.1}, {0.3, -0.2, -1}},
                   {{0, 1, 2, 3}, {0, 1, 4, 5}});
}

/// Two tetrahedra that share a node (node 0).
TetMesh node_hinge() {
    return tets_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.3, 1}, {-1, 0, 0.1}, {0.1, -1, 0}, {-0.3, -0.2, -1}},
                   {{0, 1, 2, 3}, {0, 4, 5, 6}});
}

/// Tetrahedra in a row, each hinged to the next by an edge: the edges are 0-1, 2-3, 4-5, ...
TetMesh chain(int links) {
    TetMesh mesh;
    std::vector<Tet> tets;
    for (int k = 0; k <= links; ++k)
        for (int s : {-1, 1})
            mesh.position_m.push_back(k % 2 == 0 ? Eigen::Vector3d(k, 0.5 * s, 0) : Eigen::Vector3d(k, 0, 0.5 * s));
    for (int k = 0; k < links; ++k) tets.push_back({2 * k, 2 * k + 1, 2 * k + 2, 2 * k + 3});
    return tets_of(mesh.position_m, tets);
}

TEST(UnderConstrained, AgreeWithTheNullSpaceOfKForRandomSupports) {
    std::mt19937 random(3);
    int fixed_cases = 0, moving_cases = 0;
    for (const TetMesh& mesh :
         {make_cube(2, 0.03), make_cube(3, 0.03), edge_hinge(), node_hinge(), test::two_cubes(2, 1.0), chain(4)})
        for (int trial = 0; trial < 60; ++trial) {
            Nodes fixed(random() % 7);
            for (std::int32_t& node : fixed) node = std::int32_t(random() % mesh.position_m.size());
            const Body body = body_of(mesh, fixed);
            const Nodes moving = find_under_constrained(body);
            ASSERT_EQ(moving, by_eigenvectors(body)) << mesh.tet.size() << " tets, trial " << trial;
            ++(moving.empty() ? fixed_cases : moving_cases);
        }
    EXPECT_GT(fixed_cases, 30);
    EXPECT_GT(moving_cases, 30);
}

TEST(UnderConstrained, AreDescribedByNumberAndPlace) {
    const Body body = body_of(edge_hinge(), {0, 1, 2, 3});
    const std::string text = describe_under_constrained(find_under_constrained(body), body);
    EXPECT_EQ(
        text.rfind("2 of 6 nodes are under-constrained (mesh nodes 4, 5, in the box [0.1, -1, -1, 0.3, -0.2, 0.1] m)",
                   0),
        0U)
        << text;
    EXPECT_TRUE(test::says(text, "fix at least three"));
}

constexpr double kZeroPivot = 1e-13;  // below it precompute takes a pivot for zero

TEST(UnderConstrained, PivotsTellWhereTheMeshHasTooManyParts) {
    const Body body = body_of(chain(80), {0, 1, 2, 3});
    ASSERT_TRUE(find_under_constrained(body).empty()) << "80 parts are more than the mesh test takes";
    for (const Stiffness& k : {Stiffness(stiffness(body)), test::pressure_stiffness(body, 0.49)}) {
        const Pivot weakest = Factor(k).weakest_pivot();
        EXPECT_WITHIN(weakest.ratio, .epsilon = kZeroPivot);
        EXPECT_LT(weakest.row, k.size()) << "a row of K, whose node is named";
        const Nodes softest = find_softest_nodes(k);
        EXPECT_FALSE(softest.empty());
        for (std::int32_t node : softest) EXPECT_LT(node, 158);
    }
}

TEST(UnderConstrained, ThePivotsOfAConstrainedBodyAreFarFromZero) {
    Body body = body_of(make_cube(5, 0.03), {});
    EXPECT_WITHIN(Factor(stiffness(body)).weakest_pivot().ratio, .epsilon = kZeroPivot) << "the free cube";
    Nodes bottom(25);
    for (std::int32_t i = 0; i < 25; ++i) bottom[std::size_t(i)] = i;
    body = body_of(make_cube(5, 0.03), bottom);
    EXPECT_GT(Factor(stiffness(body)).weakest_pivot().ratio, 1e-3);
    const Nodes softest = find_softest_nodes(stiffness(body));
    EXPECT_FALSE(softest.empty());
}

}  // namespace
}  // namespace haptable
