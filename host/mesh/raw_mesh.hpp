// SPDX-License-Identifier: GPL-2.0-or-later
// What a mesh file says, before it is judged: every reader fills one of these, and make_tet_mesh checks it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host/mesh/mesh.hpp"

namespace haptable {

using Tag = std::uint64_t;  ///< a node's or element's number in the file: with gaps, and beyond 2^31

/// A named set of a mesh file, by the file's numbers.
struct RawGroup {
    std::vector<Tag> node;                     ///< in any order, doubles allowed
    std::vector<std::array<Tag, 3>> triangle;  ///< by its nodes
    std::vector<std::size_t> tet;              ///< places in RawMesh::tet
};

/// Elements that cannot be taken, such as hexahedra: they are counted, never dropped in silence.
struct RawOthers {
    std::string type;
    std::size_t count = 0;
    Tag first = 0;  ///< number of the first one
};

struct RawMesh {
    std::vector<Tag> node_tag;               ///< [P]
    std::vector<Eigen::Vector3d> position;   ///< [P] in units of the file
    std::vector<Tag> tet_tag;                ///< [T]
    std::vector<std::array<Tag, 4>> tet;     ///< [T] corner nodes
    std::vector<std::array<Tag, 6>> middle;  ///< [second_order] the middles of edges 01 12 20 03 13 23, in tet's order
    std::size_t second_order = 0;            ///< tetrahedra that had more than their corners
    Tag first_second_order = 0;              ///< number of the first of them
    std::vector<std::array<Tag, 3>> triangle;  ///< loose triangles: a closed surface, or a boundary
    std::size_t surface_elements = 0;          ///< of any shape
    std::vector<RawOthers> other;              ///< elements of three dimensions that are no tetrahedra
    std::map<std::string, RawGroup, std::less<>> group;
    CellVectors vectors;                ///< [T] each
    std::vector<double> scan_distance;  ///< [P] as TetMesh::scan_distance_m, in units of the file; empty: not wrapped
    std::vector<std::string> notes;

    void add_other(std::string_view type, Tag tag) {
        if (other.empty() || other.back().type != type) other.push_back({std::string(type), 0, tag});
        ++other.back().count;
    }
    /// `nodes`: all nodes of the element, 4 or 10; the first four are its corners in every format that we read.
    /// place: of the middles of edges 01 12 20 03 13 23 among the six others, which each format orders in its own way.
    template <typename Range>
    void add_tet(Tag tag, const Range& nodes, const std::array<std::size_t, 6>& place = {0, 1, 2, 3, 4, 5}) {
        if (nodes.size() > 4 && second_order++ == 0) first_second_order = tag;
        tet_tag.push_back(tag);
        tet.push_back({static_cast<Tag>(nodes[0]), static_cast<Tag>(nodes[1]), static_cast<Tag>(nodes[2]),
                       static_cast<Tag>(nodes[3])});
        if (nodes.size() < 10) return;
        auto& between = middle.emplace_back();
        for (std::size_t e = 0; e < 6; ++e) between[e] = static_cast<Tag>(nodes[4 + place[e]]);
    }
};

}  // namespace haptable
