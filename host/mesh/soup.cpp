// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/soup.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>

#include "host/mesh/sets.hpp"

namespace haptable {

namespace {

constexpr double kSameCorner = 1e-6;  // of the diagonal: ten times the rounding of a float coordinate

/// Points by the cell of a grid that they lie in: what is near lies in a cell beside.
class Grid {
public:
    explicit Grid(double cell) : cell_(cell) {}
    /// The first point that was put within `radius` (at most a cell) of p, or `self` after putting it.
    std::size_t find_or_put(const std::vector<Eigen::Vector3d>& point, std::size_t self, double radius) {
        const Key at = key(point[self]);
        for (std::int64_t k = 0; k < 27; ++k) {
            const auto cell = cells_.find(hash({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1}));
            if (cell == cells_.end()) continue;
            for (std::size_t other : cell->second)
                if ((point[other] - point[self]).norm() <= radius) return other;
        }
        cells_[hash(at)].push_back(self);
        return self;
    }

private:
    using Key = std::array<std::int64_t, 3>;
    Key key(const Eigen::Vector3d& p) const {
        const auto step = [&](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)); };
        return {step(p.x()), step(p.y()), step(p.z())};
    }
    static std::uint64_t hash(const Key& key) {
        std::uint64_t mixed = 0;
        for (std::int64_t k : key) mixed = (mixed ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15ULL;
        return mixed;
    }
    double cell_;
    std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

Eigen::AlignedBox3d box_of(const Soup& soup) {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : soup.point) box.extend(p);
    return box;
}

std::string place(const Eigen::Vector3d& p) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", p.x(), p.y(), p.z()); }

}  // namespace

std::size_t weld(Soup& soup) {
    const Eigen::AlignedBox3d box = box_of(soup);
    const double radius = kSameCorner * box.diagonal().norm();
    if (!(radius > 0.0)) return 0;
    std::vector<Eigen::Vector3d> centred = soup.point;
    for (Eigen::Vector3d& p : centred) p -= box.center();
    Grid grid(radius);
    std::vector<std::size_t> same(soup.point.size());
    for (std::size_t i = 0; i < centred.size(); ++i) same[i] = grid.find_or_put(centred, i, radius);

    Soup welded;
    std::vector<std::size_t> number(soup.point.size(), soup.point.size());
    for (const auto& triangle : soup.triangle) {
        std::array<std::size_t, 3> corner{same[triangle[0]], same[triangle[1]], same[triangle[2]]};
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
        for (std::size_t& i : corner) {
            if (number[i] == soup.point.size()) {
                number[i] = welded.point.size();
                welded.point.push_back(soup.point[i]);
            }
            i = number[i];
        }
        welded.triangle.push_back(corner);
    }
    const std::size_t dropped = soup.triangle.size() - welded.triangle.size();
    soup = std::move(welded);
    return dropped;
}

std::size_t to_soup(const RawMesh& raw, Soup& soup) {
    std::map<Tag, std::size_t> number;
    for (std::size_t i = 0; i < raw.node_tag.size(); ++i) number[raw.node_tag[i]] = i;
    soup.point = raw.position;
    soup.triangle.clear();
    for (const auto& [a, b, c] : raw.triangle) soup.triangle.push_back({number.at(a), number.at(b), number.at(c)});
    return weld(soup);
}

BadEdges find_bad_edges(const Soup& soup) {
    struct Edge {
        int along = 0, against = 0;  // triangles that run from its lower point to its higher one, and back
        std::size_t triangle = 0;
    };
    std::map<std::pair<std::size_t, std::size_t>, Edge> edges;
    for (std::size_t t = 0; t < soup.triangle.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t from = soup.triangle[t][c], to = soup.triangle[t][(c + 1) % 3];
            Edge& edge = edges[std::minmax(from, to)];
            ++(from < to ? edge.along : edge.against);
            edge.triangle = t;
        }
    BadEdges bad;
    bad.edges = edges.size();
    for (const auto& [ends, edge] : edges) {
        const int count = edge.along + edge.against;
        bad.open += count == 1 ? 1 : 0;
        bad.non_manifold += count > 2 ? 1 : 0;
        bad.flipped += (edge.along > 1 ? 1U : 0U) + (edge.against > 1 ? 1U : 0U);
        if (count != 2 && bad.first.empty())
            bad.first = fmt::format("from {} to {} at triangle {}", place(soup.point[ends.first]),
                                    place(soup.point[ends.second]), edge.triangle + 1);
    }
    return bad;
}

std::string describe(const Soup& soup) {
    Sets sets(soup.point.size());
    double six_volumes = 0.0;
    const Eigen::AlignedBox3d box = box_of(soup);
    const Eigen::Vector3d centre = box.center(), size = box.sizes();
    for (const auto& [a, b, c] : soup.triangle) {
        sets.join(a, b);
        sets.join(a, c);
        six_volumes += (soup.point[a] - centre).dot((soup.point[b] - centre).cross(soup.point[c] - centre));
    }
    const std::vector<std::size_t> part = sets.numbers();
    const BadEdges bad = find_bad_edges(soup);
    const auto euler = static_cast<std::int64_t>(soup.point.size()) + static_cast<std::int64_t>(soup.triangle.size()) -
                       static_cast<std::int64_t>(bad.edges);
    return fmt::format(
        "{} vertices, {} triangles, {} parts, {} open, {} non-manifold and {} flipped edges, Euler characteristic {}, "
        "{:.4g} x {:.4g} x {:.4g} long, volume {:.4g} (units of the file)",
        soup.point.size(), soup.triangle.size(), part.empty() ? 0 : *std::max_element(part.begin(), part.end()) + 1,
        bad.open, bad.non_manifold, bad.flipped, euler, size.x(), size.y(), size.z(), six_volumes / 6.0);
}

}  // namespace haptable
