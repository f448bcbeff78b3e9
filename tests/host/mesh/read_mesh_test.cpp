// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/read_mesh.hpp"

#include <gtest/gtest.h>

#include <map>

#include "host/base/file.hpp"
#include "host/mesh/surface.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

// Two tetrahedra that share a face. Node numbers have gaps and reach far; node 7 belongs to a point and to no
// tetrahedron; the second tetrahedron stands the other way round.
const std::string kTwoTets = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 5 "pad"
3 6 "body"
$EndPhysicalNames
$Nodes
6
10 0 0 0
7 5 5 5
20 1000 0 0
30 0 1000 0
2000000000 0 0 1000
40 1000 1000 1000
$EndNodes
$Elements
4
17 15 2 0 1 7
1 2 2 5 1 10 30 20
2 4 2 6 2 10 20 30 2000000000
9 4 2 6 2 20 2000000000 30 40
$EndElements
)";

class MeshFile : public testing::Test {
protected:
    TetMesh read(const std::string& text, const std::string& name = "m.msh", double scale_m = 1.0) {
        write_file(folder_.path() / name, text);
        return read_mesh(folder_.path() / name, scale_m);
    }
    void expect_error(const fs::path& path, const std::string& part) {
        const std::string said = test::error_of([&] { read_mesh(path, 1.0); });
        EXPECT_EQ(said.rfind(path.string() + ": ", 0), 0U) << said;
        EXPECT_TRUE(test::says(said, part));
    }
    /// kTwoTets with `from` replaced by `to` is an error.
    void expect_changed_error(const std::string& from, const std::string& to, const std::string& part) {
        write_file(folder_.path() / "m.msh", test::replaced(kTwoTets, from, to));
        expect_error(folder_.path() / "m.msh", part);
    }

    const test::TemporaryFolder folder_;
};

TEST_F(MeshFile, NodesKeepTheirOrderAndWhatWasMendedIsSaid) {
    const TetMesh mesh = read(kTwoTets, "m.msh", 0.001);
    ASSERT_EQ(mesh.position_m.size(), 5U);
    EXPECT_TRUE(mesh.position_m[1].isApprox(Eigen::Vector3d(1, 0, 0)));
    EXPECT_TRUE(mesh.position_m[3].isApprox(Eigen::Vector3d(1, 1, 1)));
    EXPECT_TRUE(mesh.position_m[4].isApprox(Eigen::Vector3d(0, 0, 1)));
    EXPECT_EQ(mesh.tet[0], (Tet{0, 1, 2, 4}));
    for (const Tet& tet : mesh.tet) EXPECT_GT(six_volumes(mesh.position_m, tet), 0.0);
    ASSERT_EQ(mesh.notes.size(), 2U);
    EXPECT_TRUE(test::says(mesh.notes[0], "left out 1 of 6 nodes"));
    EXPECT_TRUE(test::says(mesh.notes[1], "turned 1 of 2 tetrahedra"));
}

TEST_F(MeshFile, NamedGroupsAreRead) {
    const TetMesh mesh = read(kTwoTets);
    ASSERT_EQ(mesh.group.size(), 2U);
    EXPECT_EQ(mesh.group.at("pad").node, (std::vector<std::int32_t>{0, 1, 2}));
    EXPECT_EQ(mesh.group.at("pad").triangle, (std::vector<Patch>{{0, 2, 1}}));
    EXPECT_EQ(mesh.group.at("body").node, (std::vector<std::int32_t>{0, 1, 2, 3, 4}));
    EXPECT_EQ(mesh.group.at("body").tet, (std::vector<std::int32_t>{0, 1}));
}

TEST_F(MeshFile, BadContentIsAnErrorThatNamesItsPlace) {
    expect_changed_error("40 1000 1000 1000", "40 nan 1000 1000", "");
    expect_changed_error("40 1000 1000 1000", "40 1e999 1000 1000", "node 40 has no finite position");
    expect_changed_error("40 1000 1000 1000", "40 500 0 500", "element 9 (nodes 20, 2000000000, 30, 40) has no volume");
    expect_changed_error("30 40\n", "30 30\n", "element 9");
    expect_changed_error("30 40\n", "30 41\n", "Gmsh cannot read it");
    expect_changed_error("6\n10 0 0 0", "7\n10 1 1 1\n10 0 0 0", "node number 10 is given twice");
    expect_changed_error("$MeshFormat", "MeshFormat", "its content is no mesh");
    expect_changed_error(kTwoTets.substr(kTwoTets.find("4\n17 15")), "1\n1 2 2 5 1 10 30 20\n$EndElements\n",
                         "has no tetrahedra but a surface: 3 vertices, 1 triangles");
    expect_changed_error("9 4 2 6 2 20 2000000000 30 40", "9 6 2 6 2 10 20 30 2000000000 40 7",
                         "has 1 elements of type Prism 6 (element 9 is the first)");
}

TEST_F(MeshFile, BadFilesAreErrors) {
    expect_error(folder_.path() / "missing.msh", "cannot be read");
    expect_error(folder_.path(), "is a folder");
    write_file(folder_.path() / "a.msh", "");
    expect_error(folder_.path() / "a.msh", "the file is empty");
    write_file(
        folder_.path() / "a.vtk",
        "# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n"
        "CELLS 2 4\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2 3\nCELL_TYPES 1\n10\n");
    expect_error(folder_.path() / "a.vtk", "is VTK of version 5, whose cells have OFFSETS: save it as .vtu");
    // The name does not decide.
    write_file(folder_.path() / "a.txt", kTwoTets);
    EXPECT_EQ(read_mesh(folder_.path() / "a.txt", 1.0).tet.size(), 2U);
}

TEST_F(MeshFile, ACountThatCannotBeIsRefusedBeforeMemoryIsTaken) {
    const fs::path path = folder_.path() / "a.vtk";
    for (const char* count : {"99999999999", "-1", "99999999999999999999999"}) {
        write_file(path, std::string("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS ") +
                             count + " double\n0 0 0\n");
        expect_error(path, "POINTS");
    }
}

/// Some editors begin a text with UTF-8's mark. The other formats: second_order_test.cpp.
TEST_F(MeshFile, AMarkOfUtf8IsSkippedInEveryTextFormat) {
    const std::string mark = "\xEF\xBB\xBF";
    const std::map<std::string, std::string> one_tet{
        {"a.mesh",
         "MeshVersionFormatted 2\nDimension\n3\nVertices\n4\n0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n"
         "Tetrahedra\n1\n1 2 3 4 1\nEnd\n"},
        {"a.veg", "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n"}};
    for (const auto& [name, text] : one_tet) {
        ASSERT_EQ(read(text, name).tet.size(), 1U) << name;
        EXPECT_EQ(read(mark + text, name).tet.size(), 1U) << name;
    }
    EXPECT_EQ(read(mark + kTwoTets).tet.size(), 2U);
    for (const char* part : {"needle.node", "needle.ele"})
        write_file(folder_.path() / part, mark + read_file(fs::path("meshes/hard") / part));
    EXPECT_EQ(read_mesh(folder_.path() / "needle.node", 1.0).tet, read_mesh("meshes/hard/needle.ele", 1.0).tet);
}

TEST_F(MeshFile, AScriptIsNotRun) {
    // Gmsh takes an unknown file for a script of its own, and scripts can run commands.
    const fs::path trace = folder_.path() / "trace";
    for (const char* name : {"a.msh", "a.vtk"}) {
        write_file(folder_.path() / name, "SystemCall \"touch " + trace.string() + "\";\n");
        expect_error(folder_.path() / name, "its content is no mesh");
    }
    EXPECT_FALSE(fs::exists(trace));
}

TEST_F(MeshFile, NothingIsPrinted) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    read(kTwoTets);
    expect_changed_error("30 40\n", "30 41\n", "Gmsh cannot read it");
    EXPECT_EQ(testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace haptable
