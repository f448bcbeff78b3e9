// SPDX-License-Identifier: GPL-2.0-or-later
// n = sum over the faces at a node of (angle at the node) * (face normal), normalised
// G. Thürmer and C. A. Wüthrich, "Computing vertex normals from polygonal facets", J. Graphics Tools 3(1), 1998.
#include "host/view/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

namespace haptable {

namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// The angle at corner c of a triangle, radians.
float corner_angle(const std::array<Vector3f, 3>& corner, std::size_t c) {
    const Vector3f a = corner[(c + 1) % 3] - corner[c];
    const Vector3f b = corner[(c + 2) % 3] - corner[c];
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

Vector3f unit_normal(const std::array<Vector3f, 3>& corner) {
    return (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
}

/// The root of element i in a union-find forest; shortens the path on its way.
int root(std::vector<int>& parent, int i) {
    while (parent[index(i)] != i) i = parent[index(i)] = parent[index(parent[index(i)])];
    return i;
}

/// [N] Those that have a row or a column. Without rows only those of touchable patches are known.
std::vector<bool> moving_nodes(const Tables& tables) {
    std::vector<bool> moves(tables.position.size(), false);
    for (const auto* nodes : {&tables.row_id, &tables.node_id})
        for (const std::int32_t node : *nodes) moves[index(node)] = true;
    return moves;
}

}  // namespace

DrawnSurface::DrawnSurface(const Tables& tables) {
    number_nodes(tables);
    find_neighbours();
    find_creases();
    group_normals();
    mark_patches(tables);
    update_normals();
}

/// Numbers the mesh nodes of the surface patches, in their order in the mesh, and finds their rows.
void DrawnSurface::number_nodes(const Tables& tables) {
    std::vector<int> surface_node(tables.position.size(), -1);
    std::vector<std::int32_t> row_of(tables.position.size(), -1);
    for (const auto& nodes : tables.surface)
        for (const std::int32_t node : nodes) surface_node[index(node)] = 0;
    for (std::size_t r = 0; r < tables.row_id.size(); ++r)
        row_of[index(tables.row_id[r])] = static_cast<std::int32_t>(r);
    for (std::size_t i = 0; i < surface_node.size(); ++i) {
        if (surface_node[i] < 0) continue;
        surface_node[i] = static_cast<int>(node_id.size());
        const auto& p = tables.position[i];
        node_id.push_back(static_cast<std::int32_t>(i));
        row.push_back(row_of[i]);
        rest_m.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]));
    }
    for (const auto& n : tables.surface)
        patch.emplace_back(surface_node[index(n[0])], surface_node[index(n[1])], surface_node[index(n[2])]);
    displacement_m.assign(nodes(), Vector3f::Zero());
}

/// Two patches are neighbours when they run along an edge in opposite directions.
void DrawnSurface::find_neighbours() {
    std::map<std::pair<int, int>, int> patch_at;  // directed edge
    for (std::size_t p = 0; p < patches(); ++p)
        for (int c = 0; c < 3; ++c)
            patch_at.emplace(std::pair(patch[p][(c + 1) % 3], patch[p][(c + 2) % 3]), static_cast<int>(p));
    neighbour.assign(patches(), Vector3i::Constant(-1));
    for (std::size_t p = 0; p < patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const auto other = patch_at.find({patch[p][(c + 2) % 3], patch[p][(c + 1) % 3]});
            if (other != patch_at.end()) neighbour[p][c] = other->second;
        }
}

void DrawnSurface::find_creases() {
    const float cosine = static_cast<float>(std::cos(kCreaseDegrees * std::numbers::pi / 180.0));
    std::vector<Vector3f> face;
    for (const Vector3i& p : patch)
        face.push_back(unit_normal({rest_m[index(p[0])], rest_m[index(p[1])], rest_m[index(p[2])]}));
    rest_face_ = face;
    Eigen::AlignedBox3f box;
    for (const Vector3f& x : rest_m) box.extend(x);
    thinnest_m_ = box.sizes().minCoeff();
    crease.assign(patches(), {1, 1, 1});
    for (std::size_t p = 0; p < patches(); ++p)
        for (int c = 0; c < 3; ++c)
            if (const int other = neighbour[p][c]; other >= 0)
                crease[p][index(c)] = face[p].dot(face[index(other)]) < cosine ? 1 : 0;
}

/// The corners that meet at a node over smooth edges share a normal.
void DrawnSurface::group_normals() {
    std::vector<int> parent(3 * patches());  // of corner 3 p + c
    for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = static_cast<int>(i);
    for (int p = 0; p < static_cast<int>(patches()); ++p)
        for (int c = 0; c < 3; ++c) {
            if (crease[index(p)][index(c)] != 0) continue;
            // The edge's ends are the corners c + 1 and c + 2 here, and some corners over there.
            const int other = neighbour[index(p)][c];
            for (int end = 1; end < 3; ++end)
                for (int d = 0; d < 3; ++d)
                    if (patch[index(other)][d] == patch[index(p)][(c + end) % 3])
                        parent[index(root(parent, 3 * p + (c + end) % 3))] = root(parent, 3 * other + d);
        }
    std::vector<int> number(parent.size(), -1);
    int groups = 0;
    normal_of.resize(patches());
    for (int corner = 0; corner < static_cast<int>(parent.size()); ++corner) {
        int& group = number[index(root(parent, corner))];
        if (group < 0) group = groups++;
        normal_of[index(corner / 3)][corner % 3] = group;
    }
    normal.resize(index(groups));
}

/// Patches that all nodes hold still, and patches that are not among the touchable ones.
void DrawnSurface::mark_patches(const Tables& tables) {
    std::set<std::array<std::int32_t, 3>> touched;
    for (std::array<std::int32_t, 3> nodes : tables.patch) {
        std::sort(nodes.begin(), nodes.end());
        touched.insert(nodes);
    }
    held.assign(patches(), 0);
    touchable.assign(patches(), 0);
    const std::vector<bool> moves = moving_nodes(tables);
    for (std::size_t p = 0; p < patches(); ++p) {
        std::array<std::int32_t, 3> nodes = tables.surface[p];
        std::sort(nodes.begin(), nodes.end());
        touchable[p] = touched.contains(nodes) ? 1 : 0;
        const bool known = !tables.row_id.empty() || touchable[p] != 0;
        const bool fixed =
            known && std::none_of(nodes.begin(), nodes.end(), [&](std::int32_t node) { return moves[index(node)]; });
        held[p] = fixed ? 1 : 0;
    }
}

void DrawnSurface::deform(std::span<const float> displacement) {
    for (std::size_t i = 0; i < nodes(); ++i) {
        if (row[i] < 0) continue;
        const std::size_t first = 3 * index(row[i]);
        displacement_m[i] = Vector3f(displacement[first], displacement[first + 1], displacement[first + 2]);
    }
}

void DrawnSurface::move(const Eigen::Isometry3d& pose) {
    const Eigen::Isometry3f to_world = pose.cast<float>();
    for (std::size_t i = 0; i < nodes(); ++i)
        displacement_m[i] = to_world * (rest_m[i] + displacement_m[i]) - rest_m[i];
    for (Eigen::Vector3f& n : normal) n = to_world.linear() * n;
}

void DrawnSurface::update_normals() {
    constexpr float kFar = 0.25F;  // of the body's thinnest side: less, and no part has come through another
    std::fill(normal.begin(), normal.end(), Vector3f::Zero());
    is_inside_out = std::any_of(displacement_m.begin(), displacement_m.end(),
                                [&](const Vector3f& u) { return u.norm() > kFar * thinnest_m_; });
    for (std::size_t p = 0; p < patches(); ++p) {
        std::array<Vector3f, 3> corner;
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t node = index(patch[p][static_cast<int>(c)]);
            corner[c] = rest_m[node] + displacement_m[node];
        }
        const Vector3f face = unit_normal(corner);
        is_inside_out = is_inside_out || !(face.dot(rest_face_[p]) > 0.0F);
        for (std::size_t c = 0; c < 3; ++c)
            normal[index(normal_of[p][static_cast<int>(c)])] += corner_angle(corner, c) * face;
    }
    for (Vector3f& n : normal) n.normalize();
}

}  // namespace haptable
