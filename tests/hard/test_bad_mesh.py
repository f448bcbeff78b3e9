# SPDX-License-Identifier: GPL-2.0-or-later
"""Broken meshes by other people and made ones: each gets the answer that a user needs, in bounded memory and time."""

import re

import pytest
from programs import program, run

# A file, whether it is audited (then whether the body is held is another matter), and a regular expression of what is
# said.
BAD = [
    ("00_good_base.msh", True, "nodes 14, on the surface 14; tetrahedra 24; patches 24"),
    ("01_empty.msh", False, "empty"),
    ("03_truncated_binary.msh", False, "promises 4556"),
    ("04_garbage_good_header.msh", False, "record 1 "),
    ("06_huge_counts.vtk", False, "promises 99999999999"),
    ("07_negative_count.msh", False, "negative"),
    ("09_overflow_coord.msh", False, "node 5 has no finite position"),
    ("10_index_out_of_range.msh", False, "9999"),
    ("12_inverted_three.msh", True, "turned 3, folded 0"),
    ("13_folded.msh", False, "fold"),
    ("15_repeated_node.msh", False, "element 6 names node 12 twice"),
    ("16_duplicate_tet.msh", False, "elements 1 and 777"),
    ("18_duplicate_node_id.msh", False, "node number 3 is given twice"),
    ("19_duplicate_nodes_unmerged.msh", True, "5 pairs of nodes coincide and are not joined, in 2 bodies"),
    ("21_surface_only.msh", False, "no tetrahedra but a surface: 14 vertices, 24 triangles, 1 parts, 0 open"),
    ("22_mixed_hex_tet.vtk", False, "Hexahedron"),
    ("24_cr_only.msh", True, "nodes 14, on the surface 14; tetrahedra 24; patches 24"),
    ("25_comma_decimals.msh", False, 'line 6: "-0,5"'),
    ("27_git_lfs_pointer.ele", False, "Git LFS"),
    ("28_xml_named_vtk.vtk", True, "nodes 1911"),
    ("30_six_tets_touching.msh", False, "promises 6 elements"),
    ("31_one_negative_tet.vtk", True, "nodes 4, on the surface 4; tetrahedra 1"),
    ("33_edge_hinge.msh", True, "hinges: 1 edges"),
    ("34_node_hinge.msh", True, "hinges: 0 edges, 1 nodes"),
    ("36_utf16.msh", False, "UTF-16"),
    ("37_sofa_broken_polydata.vtk", False, "POLYDATA"),
    ("39_stl_count_lies.stl", False, "promises 5000 triangles"),
    ("41_node_ids_4e9.msh", True, "nodes 14, on the surface 14; tetrahedra 24; patches 24"),
    ("43_far_from_origin.msh", True, "nodes 14, on the surface 14; tetrahedra 24; patches 24"),
    ("m_malformed_cube_22_ascii_missing_element.msh", False, "promises 24"),
    ("m_malformed_cube_22_ascii_missing_num_elements.msh", False, "missing"),
    ("m_malformed_cube_22_ascii_missing_num_nodes.msh", False, "missing"),
    ("m_malformed_cube_41_ascii_missing_element.msh", False, "elements"),
    ("m_malformed_cube_41_ascii_missing_element_header.msh", False, "entity"),
    ("m_malformed_cube_41_ascii_missing_node_header.msh", False, "dimension"),
    ("m_malformed_cube_41_ascii_missing_node_index.msh", False, "node 1"),
]


@pytest.mark.parametrize("file, audited, says", BAD, ids=[file for file, _, _ in BAD])
def test_gets_the_answer_that_a_user_needs(file, audited, says, shared, tmp_path):
    scene = tmp_path / "bad.toml"
    scene.write_text(f'name = "bad"\n[mesh]\nfile = "{shared}/meshes/bad/{file}"\n[material]\nyoung = 1e4\npoisson = 0.3\n'
                     "[[fixed]]\nbox = [-1e9, -1e9, -1e9, 1e9, 1e9, 1e9]\n")
    outcome = run(f"ulimit -v 1048576; exec {program('haptable-precompute')} {scene} --check 2>&1", patience_s=20, LC_ALL="C")
    assert outcome.status == 1 or (outcome.status == 0 and audited), outcome.out
    assert re.search(says, outcome.out)
