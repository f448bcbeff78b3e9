// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/cells.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace haptable::test {

namespace {

using Eigen::Vector3d;

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

double lowest_tenth_m(const TetMesh& mesh) {
    std::vector<double> z;
    for (const Vector3d& x : mesh.position_m) z.push_back(x.z());
    const auto tenth = z.begin() + static_cast<std::ptrdiff_t>(z.size() / 10);
    std::nth_element(z.begin(), tenth, z.end());
    return *tenth + 1e-9;
}

}  // namespace haptable::test
