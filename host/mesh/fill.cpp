// SPDX-License-Identifier: GPL-2.0-or-later
// surface -> welded, closed -> filled by CGAL in a child process (host/mesh/cgal/fill.cpp), with its creases or without
// -> a mesh
#include "host/mesh/fill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/error.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/soup.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

// The refinement of two million nodes takes about 4 GB and ten minutes.
constexpr ChildLimits kLimits{std::size_t{8} << 30, 3600};
constexpr double kCrease_deg = 75.0;
// What a filling may miss without another being tried.
constexpr double kCountMiss = 0.1, kVolumeMiss = 0.02;

void require_closed(const fs::path& file, const BadEdges& bad) {
    if (bad.open + bad.non_manifold == 0) return;
    throw Error(
        file.string() + ": " +
        fmt::format("the surface does not bound a body: {} open and {} non-manifold edges (the first {}); close "
                    "its holes and part what meets there in your mesh program",
                    bad.open, bad.non_manifold, bad.first));
}

/// A surface that was filled, or why it could not be.
struct Filling {
    double surface_volume = 0.0;       ///< of what the given surface bounds
    std::size_t surface_cavities = 0;  ///< of the given surface
    std::size_t creases = 0;           ///< of it that are kept, edges
    std::string failed;                ///< empty: it did not
    TetMesh mesh;                      ///< in units of the file
    Audit audit;
    double mean_edge = 0.0;  ///< of the new surface

    /// It is there, and encloses no emptiness that the surface does not.
    bool is_whole() const { return failed.empty() && audit.cavities <= surface_cavities; }
    double volume_share() const { return audit.volume_m3 / surface_volume; }
};

Filling unpack(std::string_view bytes) {
    Unpacker in(bytes);
    Filling filling;
    filling.surface_volume = in.one<double>();
    filling.surface_cavities = in.one<std::size_t>();
    filling.creases = in.one<std::size_t>();
    filling.failed = in.text();
    if (!filling.failed.empty()) return filling;
    const auto coordinate = in.list<double>();
    for (std::size_t k = 0; k + 2 < coordinate.size(); k += 3)
        filling.mesh.position_m.emplace_back(coordinate[k], coordinate[k + 1], coordinate[k + 2]);
    const auto corner = in.list<std::size_t>();
    for (std::size_t k = 0; k + 3 < corner.size(); k += 4) {
        Tet tet;
        for (std::size_t c = 0; c < 4; ++c) tet[c] = static_cast<std::int32_t>(corner[k + c]);
        filling.mesh.tet.push_back(tet);
    }
    filling.audit = audit_mesh(filling.mesh);
    filling.mean_edge = in.one<double>();
    return filling;
}

double excess(double miss, double allowed) { return std::max(0.0, std::abs(miss) / allowed - 1.0); }

/// What is wrong with a filling, each in units of what is allowed; 0: nothing.
double badness(const Filling& filling, const FillTarget& target) {
    if (!filling.is_whole()) return std::numeric_limits<double>::infinity();
    const Audit& audit = filling.audit;
    double sum = static_cast<double>(audit.hinge_edges + audit.hinge_nodes + filling.surface_cavities - audit.cavities);
    sum += excess(filling.volume_share() - 1.0, kVolumeMiss);
    if (target.node_count > 0)
        sum += excess(static_cast<double>(audit.nodes) / static_cast<double>(target.node_count) - 1.0, kCountMiss);
    return sum;
}

std::string describe(const Filling& filling) {
    if (!filling.failed.empty()) return filling.failed;
    return fmt::format("{} nodes, {:.3f} of the surface's volume, {} hinges, {} cavities", filling.audit.nodes,
                       filling.volume_share(), filling.audit.hinge_edges + filling.audit.hinge_nodes,
                       filling.audit.cavities);
}

/// What a user should know of the filling that was taken.
std::vector<std::string> notes_of(const Filling& filling, const FillTarget& target, std::size_t triangles) {
    std::vector<std::string> notes{
        fmt::format("filled the surface of {} triangles with {} tetrahedra, {} nodes; its edges are {:.4g} long in the "
                    "mean (units of the file)",
                    triangles, filling.audit.tets, filling.audit.nodes, filling.mean_edge)};
    if (badness(filling, target) > 0.0)
        notes.push_back(fmt::format(
            "the filling has {}{}: more nodes or a shorter edge_length come nearer", describe(filling),
            target.node_count > 0 ? fmt::format("; {} nodes were asked for", target.node_count) : std::string()));
    return notes;
}

RawMesh to_raw(Filling filling) {
    RawMesh raw;
    for (std::size_t i = 0; i < filling.mesh.position_m.size(); ++i) raw.node_tag.push_back(i);
    raw.position = std::move(filling.mesh.position_m);
    for (std::size_t t = 0; t < filling.mesh.tet.size(); ++t) {
        std::array<Tag, 4> corner{};
        std::copy(filling.mesh.tet[t].begin(), filling.mesh.tet[t].end(), corner.begin());
        raw.add_tet(t, corner);
    }
    return raw;
}

/// With creases; where something is wrong with that, without, and the better of the two.
Filling fill_best(const FillTarget& target, const std::function<Filling(double)>& fill,
                  std::vector<std::string>& notes) {
    Filling best = fill(kCrease_deg);
    if (badness(best, target) == 0.0 || best.creases == 0) return best;
    Filling smooth = fill(0.0);
    if (badness(smooth, target) < badness(best, target)) {
        notes.push_back(fmt::format("filled without its creases, {} edges sharper than {:.0f} degrees; with them: {}",
                                    best.creases, kCrease_deg, describe(best)));
        return smooth;
    }
    return best;
}

void require_whole(const fs::path& file, const Filling& filling) {
    if (!filling.failed.empty()) throw Error(file.string() + ": " + filling.failed);
    if (filling.is_whole()) return;
    throw Error(
        fmt::format("{}: filled, it encloses {} cavities, and its surface {}; give a shorter "
                    "edge_length or more nodes, or smooth the surface",
                    file.string(), filling.audit.cavities, filling.surface_cavities));
}

}  // namespace

RawMesh fill_surface(const fs::path& file, const RawMesh& raw, const FillTarget& target, const WatchFill& watch) {
    Soup soup;
    const std::size_t dropped = to_soup(raw, soup);
    const BadEdges bad = find_bad_edges(soup);
    require_closed(file, bad);
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : soup.point) centre += p / static_cast<double>(soup.point.size());
    const auto cgal_fill = from_module<decltype(haptable_cgal_fill)>(file, "haptable-cgal", "haptable_cgal_fill");
    const auto look = [&](const ChildCount& count) {
        if (watch) watch(count.done, count.expected);
    };
    const auto fill = [&](double crease_deg) {
        const auto work = [&](ChildCount& count) {
            std::string packed;
            cgal_fill(file, soup, centre, target, crease_deg, count, packed);
            return packed;
        };
        return unpack(run_in_child(file.string(), kLimits, work, look));
    };
    std::vector<std::string> notes;
    Filling best = fill_best(target, fill, notes);
    require_whole(file, best);
    for (const std::string& note : notes_of(best, target, soup.triangle.size())) notes.push_back(note);
    RawMesh filled = to_raw(std::move(best));
    filled.notes = notes;
    if (dropped > 0) filled.notes.push_back(fmt::format("left out {} triangles without area", dropped));
    if (bad.flipped > 0)
        filled.notes.push_back(
            fmt::format("turned triangles that were inside out: {} edges had both on one side", bad.flipped));
    return filled;
}

}  // namespace haptable
