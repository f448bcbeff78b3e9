// SPDX-License-Identifier: GPL-2.0-or-later
// Where a mesh is weak: which elements, which hinges.
#include "host/mesh/audit.hpp"
#include "host/base/json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Two tetrahedra on both sides of the edge 0 1, which alone holds them together; the second one is flat.
TetMesh hinged() {
    TetMesh mesh;
    mesh.position_m = {{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0},  {1.0, 0.0, 0.5},
                       {0.5, 1.0, 0.5}, {-1.0, 0.0, 0.5}, {-1.0, -0.05, 0.5}};
    mesh.tet = {{0, 2, 3, 1}, {0, 4, 5, 1}};
    mesh.tet_number = {11, 12};
    for (Tet& tet : mesh.tet)
        if (six_volumes(mesh.position_m, tet) < 0.0) std::swap(tet[0], tet[1]);
    return mesh;
}

TEST(Audit, NamesTheWorstElementsFirstAndHinges) {
    const Audit audit = audit_mesh(hinged());
    ASSERT_EQ(audit.worst.size(), 2U);
    EXPECT_EQ(audit.worst[0].number, 12U);
    EXPECT_EQ(audit.worst[0].tet, 1);
    EXPECT_EQ(audit.worst[0].node, hinged().tet[1]);
    EXPECT_EQ(audit.worst[0].ratio, audit.worst_ratio);
    EXPECT_LT(audit.worst[0].ratio, audit.worst[1].ratio);
    EXPECT_EQ(audit.hinge_edges, 1U);
    EXPECT_EQ(audit.hinge_edge, (std::vector<std::array<std::int32_t, 2>>{{0, 1}}));
    const nlohmann::ordered_json json = to_json(audit);
    EXPECT_EQ(json_text(json["hinge_edges_at"]), "[[0,1]]");
    EXPECT_EQ(json["worst_elements"][0]["tetrahedron"], 12);
}

// Of many only the worst are listed, in order.
TEST(Audit, TheListIsShort) {
    TetMesh mesh;
    for (int k = 0; k < 12; ++k) {
        const double x = 10.0 * k, height = 0.1 + 0.05 * ((5 * k) % 12);
        const auto n = std::int32_t(mesh.position_m.size());
        mesh.position_m.insert(mesh.position_m.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}, {x, 0, height}});
        mesh.tet.push_back({n, n + 1, n + 2, n + 3});
    }
    const Audit audit = audit_mesh(mesh);
    ASSERT_EQ(audit.worst.size(), kListed);
    for (std::size_t k = 0; k < kListed; ++k)
        EXPECT_EQ((5 * audit.worst[k].tet) % 12, std::int32_t(k)) << "the k-th flattest";
}

}  // namespace
}  // namespace haptable::test
