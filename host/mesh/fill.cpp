// SPDX-License-Identifier: GPL-2.0-or-later
// surface -> welded, closed -> filled by CGAL in a child process (host/mesh/cgal/fill.cpp), with its creases or without
// -> a mesh; where that fails, surface -> wrapped (host/mesh/cgal/wrap.cpp) -> filled
#include "host/mesh/fill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host/base/error.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/soup.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

// The refinement of two million nodes takes about 4 GB and ten minutes.
constexpr ChildLimits kLimits{std::size_t{8} << 30, 3600};
constexpr double kCrease_deg = 75.0;
// What a filling may miss without another being tried.
constexpr double kCountMiss = 0.1, kVolumeMiss = 0.02;

/// Why it bounds no body, or nothing.
std::string describe(const BadEdges& bad) {
    if (bad.open + bad.non_manifold == 0) return "";
    return fmt::format(
        "the surface does not bound a body: {} open and {} non-manifold edges (the first {}); close "
        "its holes and part what meets there in your mesh program",
        bad.open, bad.non_manifold, bad.first);
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

Eigen::Vector3d centre_of(const Soup& soup) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : soup.point) centre += p / static_cast<double>(soup.point.size());
    return centre;
}

/// What fills one file, each step of CGAL's in a child process.
class Filler {
public:
    Filler(const fs::path& file, const FillTarget& target, const WatchFill& watch)
        : file_(file), target_(target), watch_(watch) {}

    Filling fill(const Soup& soup, double crease_deg) const {
        const auto cgal_fill = module<decltype(haptable_cgal_fill)>("haptable_cgal_fill");
        return unpack(in_child([&](ChildCount& count, std::string& packed) {
            cgal_fill(file_, soup, centre_of(soup), target_, crease_deg, count, packed);
        }));
    }

    /// A watertight surface around the soup's triangles, and a note of how it was made.
    Soup wrap(const Soup& soup, std::string& note) const {
        const auto cgal_wrap = module<decltype(haptable_cgal_wrap)>("haptable_cgal_wrap");
        const std::string bytes = in_child(
            [&](ChildCount&, std::string& packed) { cgal_wrap(file_, soup, centre_of(soup), target_, packed); });
        Unpacker in(bytes);
        const double alpha = in.one<double>();
        const auto holes = in.one<std::size_t>();
        note = fmt::format("a ball of radius {:.4g} rolled over it, {} holes closed", alpha, holes);
        Soup wrapped;
        const auto coordinate = in.list<double>();
        for (std::size_t k = 0; k + 2 < coordinate.size(); k += 3)
            wrapped.point.emplace_back(coordinate[k], coordinate[k + 1], coordinate[k + 2]);
        const auto corner = in.list<std::size_t>();
        for (std::size_t k = 0; k + 2 < corner.size(); k += 3)
            wrapped.triangle.push_back({corner[k], corner[k + 1], corner[k + 2]});
        return wrapped;
    }

    /// [points] of each from the nearest triangle.
    std::vector<double> distances(const Soup& soup, const std::vector<Eigen::Vector3d>& points) const {
        const auto measure = module<decltype(haptable_cgal_distances)>("haptable_cgal_distances");
        const std::string bytes =
            in_child([&](ChildCount&, std::string& packed) { measure(soup, points, centre_of(soup), packed); });
        return Unpacker(bytes).list<double>();
    }

private:
    template <typename Function>
    Function* module(const char* function) const {
        return from_module<Function>(file_, "haptable-cgal", function);
    }
    template <typename Work>
    std::string in_child(const Work& work) const {
        const auto pack = [&](ChildCount& count) {
            std::string packed;
            work(count, packed);
            return packed;
        };
        return run_in_child(file_.string(), kLimits, pack, [&](const ChildCount& count) {
            if (watch_ && count.expected > 0) watch_(count.done, count.expected);
        });
    }

    const fs::path& file_;
    const FillTarget& target_;
    const WatchFill& watch_;
};

/// "0.21 in the mean, 3.4 at most, near (1, 2, 3)".
std::string describe_distances(const std::vector<double>& distance, const std::vector<Eigen::Vector3d>& point) {
    const auto most = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    const double mean = std::accumulate(distance.begin(), distance.end(), 0.0) / static_cast<double>(distance.size());
    return fmt::format("{:.3g} in the mean, {:.3g} at most, near ({:.4g}, {:.4g}, {:.4g})", mean, distance[most],
                       point[most].x(), point[most].y(), point[most].z());
}

/// Distances of the filling's surface nodes from the scan: [nodes], 0 inside; notes of them, and the scan's from it.
std::vector<double> measure(const Filler& filler, const Soup& scan, const Filling& filling,
                            std::vector<std::string>& notes) {
    const Surface surface = find_surface(filling.mesh.tet);
    Soup skin;
    skin.point = filling.mesh.position_m;
    for (const Patch& p : surface.patch)
        skin.triangle.push_back(
            {static_cast<std::size_t>(p[0]), static_cast<std::size_t>(p[1]), static_cast<std::size_t>(p[2])});
    std::vector<Eigen::Vector3d> node;
    for (const std::int32_t i : surface.node) node.push_back(filling.mesh.position_m[static_cast<std::size_t>(i)]);
    const std::vector<double> away = filler.distances(scan, node);
    notes.push_back(fmt::format("the body's surface is {} from the scan; the scan is {} from the body's surface",
                                describe_distances(away, node),
                                describe_distances(filler.distances(skin, scan.point), scan.point)));
    std::vector<double> distance(filling.mesh.position_m.size(), 0.0);
    for (std::size_t k = 0; k < node.size(); ++k) distance[static_cast<std::size_t>(surface.node[k])] = away[k];
    return distance;
}

}  // namespace

RawMesh fill_surface(const fs::path& file, const RawMesh& raw, const FillTarget& target, const WatchFill& watch) {
    Soup soup;
    const std::size_t dropped = to_soup(raw, soup);
    const BadEdges bad = find_bad_edges(soup);
    const Filler filler(file, target, watch);
    std::vector<std::string> notes;
    Filling best;
    best.failed = target.wrap.value_or(false) ? "mesh.wrap = true" : describe(bad);
    if (best.failed.empty())
        best = fill_best(
            target, [&](double crease_deg) { return filler.fill(soup, crease_deg); }, notes);
    std::vector<double> scan_distance;
    std::size_t triangles = soup.triangle.size();
    if (!best.failed.empty() && target.wrap.value_or(true)) {
        std::string how;
        const Soup wrapped = filler.wrap(soup, how);
        notes = {fmt::format("wrapped before it was filled ({}): {}", best.failed, how)};
        triangles = wrapped.triangle.size();
        best = filler.fill(wrapped, 0.0);  // what creases it has are those of its triangles
        if (best.failed.empty()) scan_distance = measure(filler, soup, best, notes);
    }
    require_whole(file, best);
    for (const std::string& note : notes_of(best, target, triangles)) notes.push_back(note);
    RawMesh filled = to_raw(std::move(best));
    filled.scan_distance = std::move(scan_distance);
    filled.notes = notes;
    if (dropped > 0) filled.notes.push_back(fmt::format("left out {} triangles without area", dropped));
    if (bad.flipped > 0 && filled.scan_distance.empty())
        filled.notes.push_back(
            fmt::format("turned triangles that were inside out: {} edges had both on one side", bad.flipped));
    return filled;
}

}  // namespace haptable
