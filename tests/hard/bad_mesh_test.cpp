// SPDX-License-Identifier: GPL-2.0-or-later
// Broken meshes by other people and made ones: each gets the answer that a user needs, in bounded memory and time.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <string>

#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

struct BadMesh {
    const char* file;
    bool audited;      ///< the audit is printed; whether the body is held is another matter
    const char* says;  ///< a regular expression that the output must hold
};

constexpr BadMesh kBadMeshes[] = {
    {"00_good_base.msh", true, "nodes 14, on the surface 14; tetrahedra 24; patches 24"},
    {"01_empty.msh", false, "empty"},
    {"03_truncated_binary.msh", false, "promises 4556"},
    {"04_garbage_good_header.msh", false, "record 1 "},
    {"06_huge_counts.vtk", false, "promises 99999999999"},
    {"07_negative_count.msh", false, "negative"},
    {"09_overflow_coord.msh", false, "node 5 has no finite position"},
    {"10_index_out_of_range.msh", false, "9999"},
    {"12_inverted_three.msh", true, "turned 3, folded 0"},
    {"13_folded.msh", false, "fold"},
    {"15_repeated_node.msh", false, "element 6 names node 12 twice"},
    {"16_duplicate_tet.msh", false, "elements 1 and 777"},
    {"18_duplicate_node_id.msh", false, "node number 3 is given twice"},
    {"19_duplicate_nodes_unmerged.msh", true, "5 pairs of nodes coincide and are not joined, in 2 bodies"},
    {"21_surface_only.msh", false, "no tetrahedra but a surface: 14 vertices, 24 triangles, 1 parts, 0 open"},
    {"22_mixed_hex_tet.vtk", false, "Hexahedron"},
    {"24_cr_only.msh", true, "nodes 14, on the surface 14; tetrahedra 24; patches 24"},
    {"25_comma_decimals.msh", false, "line 6: \"-0,5\""},
    {"27_git_lfs_pointer.ele", false, "Git LFS"},
    {"28_xml_named_vtk.vtk", true, "nodes 1911"},
    {"30_six_tets_touching.msh", false, "promises 6 elements"},
    {"31_one_negative_tet.vtk", true, "nodes 4, on the surface 4; tetrahedra 1"},
    {"33_edge_hinge.msh", true, "hinges: 1 edges"},
    {"34_node_hinge.msh", true, "hinges: 0 edges, 1 nodes"},
    {"36_utf16.msh", false, "UTF-16"},
    {"37_sofa_broken_polydata.vtk", false, "POLYDATA"},
    {"39_stl_count_lies.stl", false, "promises 5000 triangles"},
    {"41_node_ids_4e9.msh", true, "nodes 14, on the surface 14; tetrahedra 24; patches 24"},
    {"43_far_from_origin.msh", true, "nodes 14, on the surface 14; tetrahedra 24; patches 24"},
    {"m_malformed_cube_22_ascii_missing_element.msh", false, "promises 24"},
    {"m_malformed_cube_22_ascii_missing_num_elements.msh", false, "missing"},
    {"m_malformed_cube_22_ascii_missing_num_nodes.msh", false, "missing"},
    {"m_malformed_cube_41_ascii_missing_element.msh", false, "elements"},
    {"m_malformed_cube_41_ascii_missing_element_header.msh", false, "entity"},
    {"m_malformed_cube_41_ascii_missing_node_header.msh", false, "dimension"},
    {"m_malformed_cube_41_ascii_missing_node_index.msh", false, "node 1"},
};

class BadMeshes : public testing::TestWithParam<BadMesh> {};

TEST_P(BadMeshes, GetTheAnswerThatAUserNeeds) {
    const BadMesh& bad = GetParam();
    const fs::path file = fs::absolute(fs::path("../shared/meshes/bad") / bad.file);
    if (!fs::exists(file)) GTEST_SKIP() << "no ../shared/meshes/bad";
    const TemporaryFolder folder;
    const fs::path scene = folder.path() / "bad.toml";
    write_file(scene, "name = \"bad\"\n[mesh]\nfile = \"" + file.string() +
                          "\"\n[material]\nyoung = 1e4\npoisson = 0.3\n"
                          "[[fixed]]\nbox = [-1e9, -1e9, -1e9, 1e9, 1e9, 1e9]\n");
    const auto [status, output, none] =
        run("ulimit -v 1048576; LC_ALL=C exec " + program("haptable-precompute").string() + " " + scene.string() +
                " --check 2>&1",
            {}, std::chrono::seconds(20));
    EXPECT_TRUE(status == 1 || (status == 0 && bad.audited)) << "status " << status << ": " << output;
    EXPECT_TRUE(std::regex_search(output, std::regex(bad.says))) << output;
}

std::string name_of(const testing::TestParamInfo<BadMesh>& bad) {
    std::string name = fs::path(bad.param.file).stem();
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    return name;
}

INSTANTIATE_TEST_SUITE_P(Shared, BadMeshes, testing::ValuesIn(kBadMeshes), name_of);

}  // namespace
}  // namespace haptable::test
