// SPDX-License-Identifier: GPL-2.0-or-later
// Nodes in the middle of edges: of files, each format in its own order, and made.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "host/base/file.hpp"
#include "host/body/body.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/read_mesh.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Two curved tetrahedra that share a face, of five corners and nine middles; places in files begin with 1.
struct Curved {
    std::vector<Vector3d> point{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    std::vector<std::array<int, 10>> tet{{0, 1, 2, 3}, {1, 2, 3, 4}};  // the middles in VTK's order

    Curved() {
        std::map<std::pair<int, int>, int> seen;
        for (auto& nodes : tet)
            for (std::size_t e = 0; e < 6; ++e) {
                const auto edge = std::minmax(nodes[kTetEdges[e][0]], nodes[kTetEdges[e][1]]);
                const auto [found, is_new] = seen.try_emplace(edge, int(point.size()));
                if (is_new) point.push_back(middle(edge.first, edge.second));
                nodes[4 + e] = found->second;
            }
    }
    /// Off the straight line, by edge.
    Vector3d middle(int a, int b) const {
        return 0.5 * (point[std::size_t(a)] + point[std::size_t(b)]) + 0.02 * Vector3d(a + 1, b - 2, 3 - a - b);
    }
    /// The nodes as a format orders them. order: the place of each among ours, from 0.
    std::string nodes(std::size_t t, const std::array<std::size_t, 10>& order, int first) const {
        std::string text;
        for (std::size_t k : order) text += fmt::format(" {}", tet[t][k] + first);
        return text;
    }
    std::string points(const std::function<std::string(std::size_t)>& label) const {
        std::string text;
        for (std::size_t i = 0; i < point.size(); ++i)
            text += fmt::format("{}{} {} {}\n", label(i), point[i].x(), point[i].y(), point[i].z());
        return text;
    }
};

std::string numbered(std::size_t i) { return fmt::format("{} ", i + 1); }
std::string bare(std::size_t) { return ""; }

constexpr std::array<std::size_t, 10> kVtk{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
constexpr std::array<std::size_t, 10> kGmsh{0, 1, 2, 3, 4, 5, 6, 7, 9, 8};    // MSH: 23 before 13
constexpr std::array<std::size_t, 10> kTetGen{0, 1, 2, 3, 9, 7, 4, 5, 8, 6};  // 23 03 01 12 13 20

std::string msh(const Curved& c, const std::array<std::size_t, 10>& order = kGmsh) {
    return fmt::format(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n{}$EndNodes\n$Elements\n2\n1 11 2 1 1{}\n2 11 2 1 "
        "1{}\n$EndElements\n",
        c.point.size(), c.points(numbered), c.nodes(0, order, 1), c.nodes(1, order, 1));
}

std::string vtk(const Curved& c) {
    return fmt::format(
        "# vtk DataFile Version 2.0\nc\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n{}CELLS 2 "
        "22\n10{}\n10{}\nCELL_TYPES 2\n24\n24\n",
        c.point.size(), c.points(bare), c.nodes(0, kVtk, 0), c.nodes(1, kVtk, 0));
}

std::string vtu(const Curved& c) {
    const auto array = [](const char* name, const std::string& text) {
        return fmt::format(
            "<DataArray type=\"Float64\" Name=\"{}\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray>", name,
            text);
    };
    return fmt::format(
        "<?xml version=\"1.0\"?><VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"{}\" "
        "NumberOfCells=\"2\"><Points>{}</Points><Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        c.point.size(), array("p", c.points(bare)), array("connectivity", c.nodes(0, kVtk, 0) + c.nodes(1, kVtk, 0)),
        array("offsets", "10 20"), array("types", "24 24"));
}

std::string abaqus(const Curved& c) {
    std::string text = "*NODE\n";
    for (std::size_t i = 0; i < c.point.size(); ++i)
        text += fmt::format("{}, {}, {}, {}\n", i + 1, c.point[i].x(), c.point[i].y(), c.point[i].z());
    text += "*ELEMENT, TYPE=C3D10, ELSET=ALL\n";
    for (std::size_t t = 0; t < 2; ++t) {
        text += fmt::format("{}", t + 1);
        for (int node : c.tet[t]) text += fmt::format(", {}", node + 1);
        text += "\n";
    }
    return text;
}

class SecondOrder : public testing::Test {
protected:
    TetMesh read(const std::string& name, const std::string& text, bool quadratic = true, bool linearize = false) {
        write_file(folder_.path() / name, text);
        ReadOptions options;
        options.quadratic = quadratic;
        options.linearize = linearize;
        return read_mesh(folder_.path() / name, options);
    }
    /// Every middle lies where that edge's does.
    static void expect_as_given(const TetMesh& mesh, const Curved& given) {
        ASSERT_EQ(mesh.position_m.size(), given.point.size());
        ASSERT_EQ(mesh.middle.size(), 2U);
        for (std::size_t t = 0; t < 2; ++t) {
            EXPECT_GT(six_volumes(mesh.position_m, mesh.tet[t]), 0.0);
            for (std::size_t e = 0; e < 6; ++e) {
                const auto [a, b] = std::minmax(mesh.tet[t][kTetEdges[e][0]], mesh.tet[t][kTetEdges[e][1]]);
                EXPECT_WITHIN((mesh.position_m[std::size_t(mesh.middle[t][e])] - given.middle(a, b)).norm(), .count = 8)
                    << t << ' ' << e;
            }
        }
    }
    void expect_error(const std::string& text, const std::string& part, bool quadratic = true) {
        const std::string said = error_of([&] { read("m.msh", text, quadratic); });
        EXPECT_TRUE(says(said, part));
        EXPECT_TRUE(says(said, "m.msh: "));
    }

    const TemporaryFolder folder_;
};

TEST_F(SecondOrder, EachFormatsOrderOfNodesIsKnown) {
    const Curved curved;
    for (const auto& [name, text] :
         {std::pair{"a.msh", msh(curved)}, {"a.vtk", vtk(curved)}, {"a.vtu", vtu(curved)}, {"a.inp", abaqus(curved)}}) {
        SCOPED_TRACE(name);
        for (const char* mark : {"", "\xEF\xBB\xBF"}) {  // of UTF-8, which is skipped
            const TetMesh mesh = read(name, mark + text);
            EXPECT_TRUE(mesh.notes.empty() || mesh.turned > 0) << mesh.notes.front();
            expect_as_given(mesh, curved);
        }
    }
    write_file(folder_.path() / "b.ele",
               fmt::format("2 10 0\n1{}\n2{}\n", curved.nodes(0, kTetGen, 1), curved.nodes(1, kTetGen, 1)));
    SCOPED_TRACE("TetGen");
    expect_as_given(read("b.node", fmt::format("{} 3 0 0\n{}", curved.point.size(), curved.points(numbered))), curved);
}

TEST_F(SecondOrder, ATurnedTetrahedronKeepsItsMiddles) {
    const Curved curved;
    // Corners 2 and 3 swapped, and with them the middles.
    const TetMesh mesh = read("t.vtu", [&] {
        Curved turned = curved;
        for (auto& n : turned.tet) n = {n[0], n[1], n[3], n[2], n[4], n[8], n[7], n[6], n[5], n[9]};
        return vtu(turned);
    }());
    EXPECT_GT(mesh.turned, 0U);
    expect_as_given(mesh, curved);
}

TEST_F(SecondOrder, CornersAloneAreTakenWhereTheSceneSaysSo) {
    const Curved curved;
    const TetMesh linear = read("a.msh", msh(curved), false, true);
    EXPECT_TRUE(linear.middle.empty());
    EXPECT_EQ(linear.position_m.size(), 5U);
    const TetMesh straight = read("a.msh", msh(curved), true, true);
    EXPECT_EQ(straight.position_m.size(), 14U);
    EXPECT_EQ(audit_mesh(straight).curved, 0U);
    EXPECT_EQ(audit_mesh(read("a.msh", msh(curved))).curved, 2U);
    expect_error(msh(curved), "has 2 second-order tetrahedra (element 1 is the first); set element = \"quadratic\"",
                 false);
}

TEST_F(SecondOrder, WhatDoesNotFitTogetherIsAnErrorThatNamesItsElement) {
    using Tets = std::vector<std::array<int, 10>>;
    const std::pair<void (*)(Tets&), const char*> mistakes[] = {
        // 12 and 23 of the shared face
        {[](Tets& tet) { std::swap(tet[1][4], tet[1][5]); }, "elements 1 and 2: their common edge"},
        {[](Tets& tet) { tet[1][7] = 0; }, "element 2: node 1 in the middle of its edge 2-5 is a corner"},
        {[](Tets& tet) { tet[1][7] = tet[0][4]; }, "is in the middle of two edges"},
        {[](Tets& tet) { tet[0][5] = tet[0][4]; }, "element 1 names node"}};
    for (const auto& [make, part] : mistakes) {
        Curved other;
        make(other.tet);
        expect_error(msh(other), part);
    }
    std::string mixed = vtu(Curved());
    mixed.replace(mixed.find("10 20<"), 5, "10 14");
    mixed.replace(mixed.find("24 24"), 5, "24 10");
    expect_error(mixed, "has 1 linear tetrahedra beside 1 second-order ones (element 0 is the first");
}

TEST_F(SecondOrder, AFoldedTetrahedronIsAnErrorThatNamesItsElement) {
    Curved curved;
    curved.point[std::size_t(curved.tet[1][7])] = Vector3d(-1.5, -1.5, -1.5);  // between corners 1 and 4 of the second
    write_file(folder_.path() / "m.msh", msh(curved));
    Scene scene;
    scene.file = "s.toml";
    scene.mesh.file = folder_.path() / "m.msh";
    scene.mesh.element = Element::kQuadratic;
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 0.1, 1, 1}, "", 1});
    EXPECT_TRUE(fails_with([&] { make_body(scene, make_mesh(scene.mesh)); },
                           "m.msh: second-order element 2 folds over itself: its Jacobian is -"));
}

// ---- middles that are made ----------------------------------------------------------------------------------------

TetMesh quadratic_cube(int n) {
    TetMesh mesh = make_cube(n, 0.03);
    add_middles(mesh);
    return mesh;
}

TEST(Middles, AreStraightAndBehindTheCorners) {
    const TetMesh linear = make_cube(4, 0.03), mesh = quadratic_cube(4);
    std::set<std::pair<std::int32_t, std::int32_t>> edges;
    for (const Tet& tet : linear.tet)
        for (const auto& [a, b] : kTetEdges) edges.insert(std::minmax(tet[a], tet[b]));
    ASSERT_EQ(mesh.position_m.size(), linear.position_m.size() + edges.size());
    for (std::size_t i = 0; i < linear.position_m.size(); ++i) EXPECT_EQ(mesh.position_m[i], linear.position_m[i]);
    EXPECT_EQ(mesh.tet, linear.tet);
    for (std::size_t t = 0; t < mesh.tet.size(); ++t)
        for (std::size_t e = 0; e < 6; ++e) {
            const auto at = [&](std::size_t c) { return mesh.position_m[std::size_t(mesh.tet[t][c])]; };
            EXPECT_EQ(mesh.position_m[std::size_t(mesh.middle[t][e])],
                      0.5 * (at(kTetEdges[e][0]) + at(kTetEdges[e][1])));
        }
}

TEST(Middles, OfAGroupAreThoseOfItsElementsOrOfTheSurfaceBetweenItsNodes) {
    TetMesh mesh = make_cube(3, 2.0);  // corners at 0, 1, 2
    const auto low = [&](std::int32_t i) { return mesh.position_m[std::size_t(i)].z() == 0.0; };
    const auto left = [&](std::int32_t i) { return mesh.position_m[std::size_t(i)].x() == 0.0; };
    const auto of_part = [&](std::int32_t i) {
        bool is_its = false;
        for_each_node(mesh, 7, [&](std::int32_t node) { is_its |= node == i; });
        return is_its;
    };
    const std::map<std::string, std::function<bool(std::int32_t)>> groups{
        {"bottom", low},
        {"edge", [&](std::int32_t i) { return low(i) && left(i); }},
        {"two sides", [&](std::int32_t i) { return low(i) || left(i); }},  // not the diagonals between them
        {"part", of_part}};
    const auto nodes_of = [&](const std::string& name) {
        std::vector<std::int32_t> nodes;
        for (std::int32_t i = 0; i < std::int32_t(mesh.position_m.size()); ++i)
            if (groups.at(name)(i)) nodes.push_back(i);
        return nodes;
    };
    for (const auto& [name, belongs] : groups) mesh.group[name].node = nodes_of(name);
    for (const Patch& patch : find_surface(mesh.tet).patch)
        if (std::all_of(patch.begin(), patch.end(), low) || std::all_of(patch.begin(), patch.end(), left))
            mesh.group["two sides"].triangle.push_back(patch);
    mesh.group["part"].tet = {7};
    mesh.group["no face"].triangle = {{0, 1, 26}};  // the mesh has its edge 0-1 alone
    add_middles(mesh);
    for (const auto& [name, belongs] : groups) EXPECT_EQ(mesh.group[name].node, nodes_of(name)) << name;
    EXPECT_EQ(mesh.group["no face"].node.size(), 1U);
}

TEST(Middles, SplitEachFaceOfTheSurfaceInFour) {
    const TetMesh mesh = quadratic_cube(3);
    const Surface surface = find_surface(mesh), corners = find_surface(mesh.tet);
    ASSERT_EQ(surface.patch.size(), 4 * corners.patch.size());
    ASSERT_EQ(surface.face.size(), corners.patch.size());
    EXPECT_EQ(surface.joint, corners.joint);
    const auto area = [&](const Patch& p) {
        const auto at = [&](std::size_t c) { return mesh.position_m[std::size_t(p[c])]; };
        return Vector3d(0.5 * (at(1) - at(0)).cross(at(2) - at(0)));
    };
    for (std::size_t f = 0; f < surface.face.size(); ++f) {
        EXPECT_TRUE(std::equal(corners.patch[f].begin(), corners.patch[f].end(), surface.face[f].begin()));
        for (std::size_t k = 0; k < 4; ++k)
            EXPECT_WITHIN((4.0 * area(surface.patch[4 * f + k]) - area(corners.patch[f])).norm(), .count = 32,
                          .size = 1e-3);
    }
    const Audit audit = audit_mesh(mesh, surface);
    EXPECT_EQ(audit.euler, 2);
    EXPECT_EQ(audit.hinge_edges + audit.hinge_nodes, 0U);
    EXPECT_EQ(audit.curved, 0U);
    EXPECT_EQ(audit.middle_nodes, mesh.position_m.size() - 27);
    EXPECT_WITHIN(std::abs(audit.worst_jacobian_ratio - 1.0), .count = 64);
    EXPECT_WITHIN(std::abs(audit.volume_m3 / 2.7e-5 - 1.0), .count = 64);
}

// A ball of curved elements has the ball's volume to the fourth order, its corners' to the second.
TEST(Middles, OfACurvedBallGiveItsVolume) {
    if (!std::filesystem::exists("../shared/meshes/sphere_p2_1310.msh")) GTEST_SKIP() << "no ../shared/meshes";
    ReadOptions options;
    options.quadratic = true;
    const Audit curved = audit_mesh(read_mesh("../shared/meshes/sphere_p2_1310.msh", options));
    options.linearize = true;
    const Audit straight = audit_mesh(read_mesh("../shared/meshes/sphere_p2_1310.msh", options));
    const double r = 0.5 * curved.box_m.sizes().maxCoeff(), ball = 4.0 / 3.0 * 3.14159265358979 * r * r * r;
    EXPECT_GT(curved.curved, 0U);
    EXPECT_EQ(straight.curved, 0U);
    EXPECT_GT(std::abs(straight.volume_m3 / ball - 1.0), 10.0 * std::abs(curved.volume_m3 / ball - 1.0));
    EXPECT_GT(curved.worst_jacobian_ratio, 0.0);
}

}  // namespace
}  // namespace haptable::test
