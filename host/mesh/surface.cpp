// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/surface.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/index.hpp"
#include "host/mesh/quadratic_tet.hpp"

namespace haptable {

namespace {

/// The faces of a positively oriented tetrahedron, seen from outside: face c lies opposite to corner c.
constexpr std::size_t kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

struct Face {
    Patch key;  // its nodes, ascending: the same for both tetrahedra that meet in it
    std::int32_t tet;
    std::int32_t side;
};

Patch nodes_of(const Tet& tet, std::size_t side) {
    return {tet[kFace[side][0]], tet[kFace[side][1]], tet[kFace[side][2]]};
}

[[noreturn]] void fail_shared(const Face& a, const Face& b, const Face& c) {
    throw Error(
        fmt::format("tetrahedra {}, {} and {} (from 0) share one face, nodes {}: a face belongs to at most "
                    "two; remove the doubled element from the mesh",
                    a.tet, b.tet, c.tet, fmt::join(a.key, ", ")));
}

std::vector<Face> sorted_faces(std::span<const Tet> tets) {
    std::vector<Face> faces;
    faces.reserve(4 * tets.size());
    for (std::size_t t = 0; t < tets.size(); ++t)
        for (std::size_t side = 0; side < 4; ++side) {
            Patch key = nodes_of(tets[t], side);
            std::sort(key.begin(), key.end());
            faces.push_back({key, static_cast<std::int32_t>(t), static_cast<std::int32_t>(side)});
        }
    std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
        return std::tie(a.key, a.tet, a.side) < std::tie(b.key, b.tet, b.side);
    });
    return faces;
}

/// Place in kTetEdges of the edge between two corners.
std::size_t edge_between(std::size_t a, std::size_t b) {
    const auto found = std::find_if(kTetEdges.begin(), kTetEdges.end(), [&](const auto& edge) {
        return (edge[0] == a && edge[1] == b) || (edge[0] == b && edge[1] == a);
    });
    return static_cast<std::size_t>(found - kTetEdges.begin());
}

QuadraticFace face_of(const TetMesh& mesh, const Face& face) {
    const auto& corner = kFace[face.side];
    QuadraticFace nodes;
    for (std::size_t c = 0; c < 3; ++c) {
        nodes[c] = mesh.tet[at(face.tet)][corner[c]];
        nodes[3 + c] = mesh.middle[at(face.tet)][edge_between(corner[c], corner[(c + 1) % 3])];
    }
    return nodes;
}

void sort_unique(std::vector<std::int32_t>& nodes) {
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

/// Faces of one tetrahedron, in the mesh's order; those of two go into joint.
std::vector<Face> find_boundary(std::span<const Tet> tets, std::vector<std::array<std::int32_t, 2>>& joint) {
    const std::vector<Face> faces = sorted_faces(tets);
    std::vector<Face> boundary;
    for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
        while (last < faces.size() && faces[last].key == faces[first].key) ++last;
        if (last - first > 2) fail_shared(faces[first], faces[first + 1], faces[first + 2]);
        if (last - first == 2) joint.push_back({faces[first].tet, faces[first + 1].tet});
        if (last - first == 1) boundary.push_back(faces[first]);
    }
    // Neighbours in the mesh's order stay neighbours in memory, and equal meshes give equal orders.
    std::sort(boundary.begin(), boundary.end(),
              [](const Face& a, const Face& b) { return std::tie(a.tet, a.side) < std::tie(b.tet, b.side); });
    return boundary;
}

}  // namespace

Surface find_surface(std::span<const Tet> tets) {
    Surface surface;
    for (const Face& face : find_boundary(tets, surface.joint)) {
        surface.patch.push_back(nodes_of(tets[at(face.tet)], at(face.side)));
        surface.node.insert(surface.node.end(), face.key.begin(), face.key.end());
    }
    sort_unique(surface.node);
    return surface;
}

Surface find_surface(const TetMesh& mesh) {
    if (mesh.middle.empty()) return find_surface(mesh.tet);
    Surface surface;
    for (const Face& boundary : find_boundary(mesh.tet, surface.joint)) {
        const QuadraticFace& face = surface.face.emplace_back(face_of(mesh, boundary));
        const auto quarters = quarters_of(face);
        surface.patch.insert(surface.patch.end(), quarters.begin(), quarters.end());
        surface.node.insert(surface.node.end(), face.begin(), face.end());
    }
    sort_unique(surface.node);
    return surface;
}

std::array<Patch, 4> quarters_of(const QuadraticFace& face) {
    const auto& [a, b, c, ab, bc, ca] = face;
    return {Patch{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
}

}  // namespace haptable
