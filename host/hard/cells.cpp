// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/hard/cells.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kRadius_m = 0.02;

/// The nodes of a mesh in the making: points that fall together, to a millionth of a millionth of the extent, are one.
class Nodes {
public:
    explicit Nodes(double extent_m) : per_m_(1e9 / extent_m) {}
    std::int32_t add(const Vector3d& x) {
        const std::array<long, 3> key{std::lround(x.x() * per_m_), std::lround(x.y() * per_m_),
                                      std::lround(x.z() * per_m_)};
        const auto [it, fresh] = seen_.try_emplace(key, static_cast<std::int32_t>(position_m.size()));
        if (fresh) position_m.push_back(x);
        return it->second;
    }
    std::vector<Vector3d> position_m;

private:
    double per_m_;
    std::map<std::array<long, 3>, std::int32_t> seen_;
};

/// Turned so that its volume is positive.
void add_tet(TetMesh& mesh, Tet tet) {
    if (six_volumes(mesh.position_m, tet) < 0.0) std::swap(tet[2], tet[3]);
    mesh.tet.push_back(tet);
}

/// The nodes of the corners of a cell's six tetrahedra, each a way from its low corner to its high one.
template <typename Add>
void for_each_way(const Add& add) {
    for (const auto& way : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}) add(way);
}

}  // namespace

TetMesh mesh_of(const Cells& cells) {
    const auto point = [&](const std::array<int, 3>& i) {
        return cells.at(double(i[0]) / cells.count[0], double(i[1]) / cells.count[1], double(i[2]) / cells.count[2]);
    };
    Eigen::AlignedBox3d box;
    for (int corner = 0; corner < 8; ++corner)
        box.extend(point({corner % 2 * cells.count[0], corner / 2 % 2 * cells.count[1], corner / 4 * cells.count[2]}));
    Nodes nodes(std::max(box.diagonal().norm(), 1e-9));
    TetMesh mesh;
    for (int i = 0; i < cells.count[0]; ++i)
        for (int j = 0; j < cells.count[1]; ++j)
            for (int k = 0; k < cells.count[2]; ++k) {
                if (!cells.solid(i, j, k)) continue;
                for_each_way([&](const std::array<int, 3>& way) {
                    std::array<int, 3> at{i, j, k};
                    Tet tet{nodes.add(point(at))};
                    for (std::size_t s = 0; s < 3; ++s) {
                        ++at[static_cast<std::size_t>(way[s])];
                        tet[s + 1] = nodes.add(point(at));
                    }
                    if (std::set<std::int32_t>(tet.begin(), tet.end()).size() == 4) mesh.tet.push_back(tet);
                });
            }
    mesh.position_m = std::move(nodes.position_m);
    return mesh;
}

TetMesh sliver_mesh(int n, double radius_ratio) {
    const double edge = 0.03 / n,
                 sag = radius_ratio * edge / std::sqrt(1.125);  // inradius sag / 4, circumradius edge / sqrt 2
    TetMesh mesh;
    const auto node = [&](int i, int j, int k) { return static_cast<std::int32_t>((k * (n + 1) + j) * (n + 1) + i); };
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i)  // a saddle between the layers
                mesh.position_m.emplace_back(edge * i, edge * j, 0.015 * k - (k == 1 ? sag * i * j : 0.0));
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                for_each_way([&](const std::array<int, 3>& way) {  // mirrored above
                    std::array<int, 3> at{};
                    const auto here = [&] { return node(k == 0 ? i + at[0] : i + 1 - at[0], j + at[1], k + at[2]); };
                    Tet tet{here()};
                    for (std::size_t s = 0; s < 3; ++s) {
                        ++at[static_cast<std::size_t>(way[s])];
                        tet[s + 1] = here();
                    }
                    add_tet(mesh, tet);
                });
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            add_tet(mesh, {node(i, j, 1), node(i + 1, j + 1, 1), node(i + 1, j, 1), node(i, j + 1, 1)});
    return mesh;
}

TetMesh hub_mesh() {
    const double golden = std::numbers::phi;
    std::vector<Vector3d> corner;
    for (int turn = 0; turn < 3; ++turn)
        for (double a : {-1.0, 1.0})
            for (double b : {-golden, golden}) {
                Vector3d x;
                x[turn] = 0.0;
                x[(turn + 1) % 3] = a;
                x[(turn + 2) % 3] = b;
                corner.push_back(x.normalized());
            }
    Nodes nodes(1.0);
    const std::int32_t middle = nodes.add(Vector3d::Zero());
    const double side = 2.0 / std::hypot(1.0, golden);
    std::vector<std::array<Vector3d, 3>> faces;
    for (std::size_t a = 0; a < 12; ++a)  // corners that are one edge apart from each other
        for (std::size_t b = a + 1; b < 12; ++b)
            for (std::size_t c = b + 1; c < 12; ++c)
                if (std::max({(corner[a] - corner[b]).norm(), (corner[b] - corner[c]).norm(),
                              (corner[c] - corner[a]).norm()}) < 1.1 * side)
                    faces.push_back({corner[a], corner[b], corner[c]});
    TetMesh mesh;
    std::vector<std::array<std::int32_t, 3>> triangles;
    for (const auto& [a, b, c] : faces) {
        const Vector3d ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
        for (const auto& [x, y, z] : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
            triangles.push_back({nodes.add(x), nodes.add(y), nodes.add(z)});
    }
    for (const Vector3d& x : nodes.position_m) mesh.position_m.push_back(kRadius_m * x);
    for (const auto& t : triangles) add_tet(mesh, {middle, t[0], t[1], t[2]});
    return mesh;
}

TetMesh cone_mesh(int sides) {
    TetMesh mesh;
    mesh.position_m = {Vector3d(0, 0, 0), Vector3d(0, 0, kRadius_m)};
    for (int s = 0; s < sides; ++s) {
        const double turn = 2.0 * std::numbers::pi * s / sides;
        mesh.position_m.emplace_back(kRadius_m * std::cos(turn), kRadius_m * std::sin(turn), 0.0);
    }
    for (int s = 0; s < sides; ++s) add_tet(mesh, {0, 1, 2 + s, 2 + (s + 1) % sides});
    return mesh;
}

}  // namespace haptable
