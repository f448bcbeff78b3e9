// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/surface.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"

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

}  // namespace

Surface find_surface(std::span<const Tet> tets) {
    const std::vector<Face> faces = sorted_faces(tets);
    Surface surface;
    std::vector<Face> boundary;
    for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
        while (last < faces.size() && faces[last].key == faces[first].key) ++last;
        if (last - first > 2) fail_shared(faces[first], faces[first + 1], faces[first + 2]);
        if (last - first == 2) surface.joint.push_back({faces[first].tet, faces[first + 1].tet});
        if (last - first == 1) boundary.push_back(faces[first]);
    }
    // Neighbours in the mesh's order stay neighbours in memory, and equal meshes give equal orders.
    std::sort(boundary.begin(), boundary.end(),
              [](const Face& a, const Face& b) { return std::tie(a.tet, a.side) < std::tie(b.tet, b.side); });
    for (const Face& face : boundary) {
        surface.patch.push_back(
            nodes_of(tets[static_cast<std::size_t>(face.tet)], static_cast<std::size_t>(face.side)));
        surface.node.insert(surface.node.end(), face.key.begin(), face.key.end());
    }
    std::sort(surface.node.begin(), surface.node.end());
    surface.node.erase(std::unique(surface.node.begin(), surface.node.end()), surface.node.end());
    return surface;
}

}  // namespace haptable
