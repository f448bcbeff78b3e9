// SPDX-License-Identifier: GPL-2.0-or-later
// surface -> welded, closed -> filled by CGAL in a child process (host/mesh/cgal/fill.cpp) -> a mesh
#include "host/mesh/fill.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/soup.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

// The refinement of two million nodes takes about 4 GB and ten minutes.
constexpr ChildLimits kLimits{std::size_t{8} << 30, 3600};

void require_closed(const fs::path& file, const BadEdges& bad) {
    if (bad.open + bad.non_manifold == 0) return;
    throw Error(
        file.string() + ": " +
        fmt::format("the surface does not bound a body: {} open and {} non-manifold edges (the first {}); close "
                    "its holes and part what meets there in your mesh program",
                    bad.open, bad.non_manifold, bad.first));
}

RawMesh unpack(std::string_view bytes, std::size_t triangles) {
    Unpacker in(bytes);
    RawMesh raw;
    const auto coordinate = in.list<double>();
    for (std::size_t k = 0; k + 2 < coordinate.size(); k += 3) {
        raw.node_tag.push_back(k / 3);
        raw.position.emplace_back(coordinate[k], coordinate[k + 1], coordinate[k + 2]);
    }
    const auto corner = in.list<std::size_t>();
    for (std::size_t k = 0; k + 3 < corner.size(); k += 4)
        raw.add_tet(k / 4, std::array<Tag, 4>{corner[k], corner[k + 1], corner[k + 2], corner[k + 3]});
    raw.notes.push_back(
        fmt::format("filled the surface of {} triangles with {} tetrahedra, {} nodes; its edges are {:.4g} long in the "
                    "mean (units of the file)",
                    triangles, raw.tet.size(), raw.node_tag.size(), in.one<double>()));
    return raw;
}

}  // namespace

RawMesh fill_surface(const fs::path& file, const RawMesh& raw, const FillTarget& target, const WatchFill& watch) {
    Soup soup;
    const std::size_t dropped = to_soup(raw, soup), triangles = soup.triangle.size();
    const BadEdges bad = find_bad_edges(soup);
    require_closed(file, bad);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : soup.point) centre += p / static_cast<double>(soup.point.size());
    const auto fill = from_module<decltype(haptable_cgal_fill)>(file, "haptable-cgal", "haptable_cgal_fill");
    const auto work = [&](ChildCount& count) {
        std::string packed;
        fill(file, soup, centre, target, count, packed);
        return packed;
    };
    const auto look = [&](const ChildCount& count) {
        if (watch) watch(count.done, count.expected);
    };
    RawMesh filled = unpack(run_in_child(file.string(), kLimits, work, look), triangles);
    if (dropped > 0) filled.notes.push_back(fmt::format("left out {} triangles without area", dropped));
    if (bad.flipped > 0)
        filled.notes.push_back(
            fmt::format("turned triangles that were inside out: {} edges had both on one side", bad.flipped));
    return filled;
}

}  // namespace haptable
