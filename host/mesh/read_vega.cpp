// SPDX-License-Identifier: GPL-2.0-or-later
// Vega FEM 4.0 User's Manual, "Volumetric mesh file format": sections that begin with '*', comments with '#'.

#include <unordered_map>

#include "host/mesh/lines.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

void read_vertices(Lines& in, RawMesh& raw) {
    in.require("the number of vertices");
    const std::size_t count = in.count(0, "the number of vertices");
    for (std::size_t k = 0; k < count; ++k) {
        in.require("its last vertex");
        raw.node_tag.push_back(in.whole(0, "a vertex's number"));
        raw.position.emplace_back(in.real(1), in.real(2), in.real(3));
    }
}

void read_elements(Lines& in, RawMesh& raw) {
    in.require("the type of its elements");
    const std::string type(in.fields()[0]);
    const bool tets = type == "TET" || type == "TETS";
    in.require("the number of elements");
    const std::size_t count = in.count(0, "the number of elements");
    for (std::size_t k = 0; k < count; ++k) {
        in.require("its last element");
        const Tag tag = in.whole(0, "an element's number");
        if (!tets) raw.add_other(type, tag);
        if (!tets) continue;
        std::vector<Tag> node;
        for (std::size_t c = 1; c <= 4; ++c) node.push_back(in.whole(c, "a vertex's number"));
        raw.add_tet(tag, node);
    }
}

/// "*SET name" and then numbers of elements.
void read_set(Lines& in, RawMesh& raw) {
    if (in.size() < 2) in.fail("a *SET needs a name");
    RawGroup& group = raw.group[std::string(in.fields()[1])];
    std::unordered_map<Tag, std::size_t> place;
    for (std::size_t t = 0; t < raw.tet.size(); ++t) place.emplace(raw.tet_tag[t], t);
    while (in.next()) {
        if (in.fields()[0][0] == '*') return in.again();
        for (std::size_t k = 0; k < in.size(); ++k)
            if (const auto at = place.find(in.whole(k, "an element's number")); at != place.end())
                group.tet.push_back(at->second);
    }
}

}  // namespace

bool is_vega(const MeshFile& file) { return file.head.find("*VERTICES") != std::string_view::npos; }

RawMesh read_vega(const MeshFile& file) {
    Lines in(file.path, file.text);
    RawMesh raw;
    while (in.next()) {
        const std::string_view word = in.fields()[0];
        if (word == "*VERTICES") read_vertices(in, raw);
        if (word == "*ELEMENTS") read_elements(in, raw);
        if (word == "*SET") read_set(in, raw);
        if (word == "*INCLUDE") in.fail("*INCLUDE is not followed; put its content here");
    }
    return raw;
}

}  // namespace haptable
