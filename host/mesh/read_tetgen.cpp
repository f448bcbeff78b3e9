// SPDX-License-Identifier: GPL-2.0-or-later
// TetGen 1.5 manual, 5.2.1 and 5.2.3: "count dimension attributes markers" and "count nodes attributes", a record a
// line.
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/mesh/lines.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

// As TetGen 1.5 -o2 writes them: between 23 03 01 12 13 20.
constexpr std::array<std::size_t, 6> kMiddlesOfTetgen{2, 3, 5, 1, 4, 0};

void read_nodes(const fs::path& file, RawMesh& raw) {
    const std::string text = read_text(file);
    Lines in(file, text);
    in.require("the number of nodes");
    const std::size_t count = in.count(0, "the number of nodes");
    if (in.size() > 1 && in.whole(1, "the dimension") != 3) in.fail("its nodes are not in three dimensions");
    for (std::size_t k = 0; k < count; ++k) {
        in.require("its last node");
        raw.node_tag.push_back(in.whole(0, "a node's number"));
        raw.position.emplace_back(in.real(1), in.real(2), in.real(3));
    }
}

/// The attribute of an element is its region: a group named after it.
void read_tets(const fs::path& file, RawMesh& raw) {
    const std::string text = read_text(file);
    Lines in(file, text);
    in.require("the number of tetrahedra");
    const std::size_t count = in.count(0, "the number of tetrahedra");
    const std::uint64_t corners = in.size() > 1 ? in.whole(1, "the nodes of a tetrahedron") : 4;
    const bool region = in.size() > 2 && in.whole(2, "the number of attributes") > 0;
    if (corners != 4 && corners != 10) in.fail(fmt::format("{} nodes a tetrahedron; TetGen writes 4 or 10", corners));
    for (std::size_t k = 0; k < count; ++k) {
        in.require("its last tetrahedron");
        std::vector<Tag> node;
        for (std::size_t c = 0; c < corners; ++c) node.push_back(in.whole(1 + c, "a node's number"));
        if (region && in.size() > corners + 1)
            raw.group[std::string(in.fields()[corners + 1])].tet.push_back(raw.tet.size());
        raw.add_tet(in.whole(0, "a tetrahedron's number"), node, kMiddlesOfTetgen);
    }
}

}  // namespace

bool is_tetgen(const MeshFile& file) { return file.ending == ".node" || file.ending == ".ele"; }

RawMesh read_tetgen(const MeshFile& given) {
    const fs::path& file = given.path;
    RawMesh raw;
    const fs::path nodes = fs::path(file).replace_extension(".node"), tets = fs::path(file).replace_extension(".ele");
    for (const fs::path& part : {nodes, tets})
        if (!fs::exists(part))
            throw Error(fmt::format("{}: its other half {} is missing; TetGen writes both: put them side by side",
                                    file.string(), part.string()));
    read_nodes(nodes, raw);
    read_tets(tets, raw);
    return raw;
}

}  // namespace haptable
