// SPDX-License-Identifier: GPL-2.0-or-later
// A part of haptable-cgal.so: any triangles -> holes closed -> wrapped by a ball of radius alpha (Portaneri, Rouxel-
// Labbe, Hemmer, Cohen-Steiner and Alliez, Alpha Wrapping with an Offset, 2022) -> pulled in by the gap to the scan
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "host/base/error.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
namespace pmp = CGAL::Polygon_mesh_processing;

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Triangle = Kernel::Triangle_3;
using Surface = CGAL::Surface_mesh<Point>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, std::vector<Triangle>::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

constexpr double kOffset = 1.0 / 30.0;          // of alpha: how far outside the wrap lies
constexpr double kCoarse = 0.05, kMost = 0.35;  // alpha over the diagonal: tried first, and the largest
constexpr double kFinest = 0.005;               // the same: finer ones take minutes
constexpr double kDeep = 2.0;                   // alphas in which noise may fold the scan below its wrap
constexpr double kPerEdge = 1.0 / 3.0;          // alpha over the edge of the tetrahedra to come
constexpr double kNodesPerVolume = 1.6;         // of a body of tetrahedra with edges of length 1
constexpr double kLeak = 0.05;                  // of its area on the inner side of the scan, beyond what noise gives
constexpr double kMostLeak = 0.5;               // the same, where no wrap has less: noise folds the scan's triangles
constexpr double kSheet = 3.0;                  // volume over area times offset: a sheet that is wrapped has 1
constexpr std::size_t kLongestBorder = 1000;    // edges of a hole that is closed by triangles: their time is cubic
constexpr int kBisections = 3, kUntangle = 20;

/// The scan's triangles and those that close its holes, oriented alike in each part.
struct Scan {
    std::vector<Point> point;
    std::vector<std::vector<std::size_t>> face;
    std::vector<std::size_t> part;   ///< of each face
    std::vector<Triangle> triangle;  ///< the faces
    Tree tree;
    std::size_t parts = 1, holes = 0;
    double diagonal = 0.0;

    std::size_t place(Tree::Primitive_id id) const { return static_cast<std::size_t>(id - triangle.begin()); }
};

std::vector<Point> about(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& centre) {
    std::vector<Point> moved;
    for (const Eigen::Vector3d& p : points)
        moved.emplace_back(p.x() - centre.x(), p.y() - centre.y(), p.z() - centre.z());
    return moved;
}

/// Closes the holes of an oriented surface. Returns how many.
std::size_t close_holes(Surface& surface) {
    std::vector<Surface::Halfedge_index> borders;
    pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
    std::size_t closed = 0;
    for (const Surface::Halfedge_index border : borders) {
        std::size_t edges = 0;
        for (auto h = border; edges == 0 || h != border; h = surface.next(h)) ++edges;
        if (edges > kLongestBorder) continue;
        std::vector<Surface::Face_index> patch;
        pmp::triangulate_hole(surface, border, std::back_inserter(patch));
        closed += patch.empty() ? 0 : 1;
    }
    return closed;
}

/// The faces of a surface and the parts that they form.
void take(const Surface& surface, Scan& scan) {
    scan.point.clear();
    for (const auto v : surface.vertices()) scan.point.push_back(surface.point(v));
    scan.face.clear();
    for (const auto f : surface.faces()) {
        std::vector<std::size_t> corner;
        for (const auto v : surface.vertices_around_face(surface.halfedge(f))) corner.push_back(v);
        scan.face.push_back(corner);
    }
    std::vector<std::size_t> part(surface.number_of_faces());
    const auto of = boost::make_iterator_property_map(part.begin(), get(boost::face_index, surface));
    scan.parts = pmp::connected_components(surface, of);
    scan.part = part;
}

void read_scan(const Soup& soup, const Eigen::Vector3d& centre, Scan& scan) {
    scan.point = about(soup.point, centre);
    for (const auto& triangle : soup.triangle) scan.face.emplace_back(triangle.begin(), triangle.end());
    pmp::repair_polygon_soup(scan.point, scan.face);  // triangles that stand twice, or have no area
    pmp::orient_polygon_soup(scan.point, scan.face);
    scan.part.assign(scan.face.size(), 0);
    if (pmp::is_polygon_soup_a_polygon_mesh(scan.face)) {
        Surface surface;
        pmp::polygon_soup_to_polygon_mesh(scan.point, scan.face, surface);
        scan.holes = close_holes(surface);
        take(surface, scan);
    }
    for (const auto& f : scan.face) scan.triangle.emplace_back(scan.point[f[0]], scan.point[f[1]], scan.point[f[2]]);
    scan.tree.insert(scan.triangle.cbegin(), scan.triangle.cend());
    scan.tree.build();
    const CGAL::Bbox_3 box = scan.tree.bbox();
    scan.diagonal = std::hypot(box.xmax() - box.xmin(), box.ymax() - box.ymin(), box.zmax() - box.zmin());
}

struct Wrapped {
    double alpha = 0.0;
    Surface surface;
    double leaked = 1.0;  ///< share of its area that lies inside the scan, by the directions of the scan's triangles
};

Triangle triangle_of(const Surface& surface, Surface::Face_index f) {
    const auto h = surface.halfedge(f);
    return {surface.point(surface.source(h)), surface.point(surface.target(h)),
            surface.point(surface.target(surface.next(h)))};
}

Vector double_area(const Triangle& t) { return CGAL::cross_product(t[1] - t[0], t[2] - t[0]); }

/// What a ray from a face of the wrap inwards meets first.
struct Hit {
    std::size_t face;  ///< of the scan
    double distance;
};

std::optional<Hit> look_inwards(const Scan& scan, const Triangle& t) {
    const auto hit = scan.tree.first_intersection(Kernel::Ray_3(CGAL::centroid(t), -double_area(t)));
    const Point* at = hit ? boost::get<Point>(&hit->first) : nullptr;
    if (at == nullptr) return {};
    return Hit{scan.place(hit->second), std::sqrt(CGAL::squared_distance(*at, CGAL::centroid(t)))};
}

/// Where a wrap has run through a hole, it lies on both sides of the scan: what of each part's is on the lesser one.
double leaked_share(const Surface& wrap, const Scan& scan) {
    std::vector<std::array<double, 2>> side(scan.parts, {0.0, 0.0});
    double area = 0.0;
    for (const auto f : wrap.faces()) {
        const Vector normal = double_area(triangle_of(wrap, f));
        const std::optional<Hit> hit = look_inwards(scan, triangle_of(wrap, f));
        if (!hit) continue;
        const double twice = std::sqrt(normal.squared_length());
        side[scan.part[hit->face]][normal * double_area(scan.triangle[hit->face]) > 0.0 ? 1 : 0] += twice;
        area += twice;
    }
    double leaked = 0.0;
    for (const auto& [in, out] : side) leaked += 2.0 * std::min(in, out);
    return leaked / area;
}

Wrapped wrap_at(const Scan& scan, double alpha) {
    Wrapped wrapped{alpha, {}};
    CGAL::alpha_wrap_3(scan.point, scan.face, alpha, kOffset * alpha, wrapped.surface);
    const Surface& surface = wrapped.surface;
    if (surface.is_empty()) return wrapped;
    const double sheet = kOffset * alpha * pmp::area(surface);
    if (pmp::volume(surface) > kSheet * sheet) wrapped.leaked = leaked_share(surface, scan);
    return wrapped;
}

/// A coarse one that has not run into holes; or else the one that has least.
Wrapped find_coarse(const fs::path& file, const Scan& scan) {
    Wrapped best;
    for (double alpha = kCoarse * scan.diagonal; alpha < kMost * scan.diagonal && best.leaked > kLeak; alpha *= 1.5)
        if (Wrapped next = wrap_at(scan, alpha); next.leaked < best.leaked) best = std::move(next);
    if (best.leaked > kMostLeak)
        throw Error(file.string() +
                    ": bounds no body: a wrap around it lies on both sides of its triangles; close its largest holes "
                    "in your mesh program, or give it a thickness");
    return best;
}

/// As fine as the tetrahedra to come want it, or as holes allow.
Wrapped find_wrap(const fs::path& file, const Scan& scan, const FillTarget& target) {
    Wrapped best = find_coarse(file, scan);
    double edge = target.edge_length;
    if (edge <= 0.0)
        edge = std::cbrt(kNodesPerVolume * pmp::volume(best.surface) / static_cast<double>(target.node_count));
    const double wanted = std::max(kPerEdge * edge, kFinest * scan.diagonal), allowed = best.leaked + kLeak;
    double leaks = wanted;
    for (int k = 0; k <= kBisections && best.alpha > wanted; ++k) {
        Wrapped finer = wrap_at(scan, k == 0 ? wanted : std::sqrt(leaks * best.alpha));
        if (finer.leaked < allowed)
            best = std::move(finer);
        else
            leaks = finer.alpha;
    }
    return best;
}

/// From the middle of a face inwards to the scan. Noise folds it: there the way leads out of it and in again, and what
/// is outside of it counts together, so that the volume is the scan's own. None where there is nothing as near as
/// alpha.
std::optional<double> gap_below(const Scan& scan, const Triangle& t, double alpha) {
    const Point from = CGAL::centroid(t);
    const Vector inwards = -double_area(t) / std::sqrt(double_area(t).squared_length());
    std::vector<Tree::Intersection_and_primitive_id<Kernel::Segment_3>::Type> hits;
    scan.tree.all_intersections(Kernel::Segment_3(from, from + kDeep * alpha * inwards), std::back_inserter(hits));
    double nearest = std::numeric_limits<double>::infinity(), outside = 0.0;
    int entered = 0;
    for (const auto& [met, id] : hits) {
        const Point* const at = boost::get<Point>(&met);
        if (at == nullptr) continue;
        const double distance = std::sqrt(CGAL::squared_distance(*at, from));
        const int enters = inwards * double_area(scan.triangle[scan.place(id)]) < 0.0 ? 1 : -1;
        entered += enters;
        outside += enters * distance;
        nearest = std::min(nearest, distance);
    }
    if (nearest > alpha) return {};
    // Where the other side of a sheet is as near, only the first counts. A part may be inside out.
    return std::abs(entered) == 1 ? std::max(nearest, entered * outside) : nearest;
}

/// [vertices] the mean gap of the faces around, by their areas.
std::vector<double> mean_gaps(const Wrapped& wrapped, const Scan& scan) {
    const Surface& surface = wrapped.surface;
    std::vector<std::optional<double>> gap(surface.number_of_faces());
    for (const auto f : surface.faces()) gap[f] = gap_below(scan, triangle_of(surface, f), wrapped.alpha);
    std::vector<double> mean(surface.number_of_vertices(), 0.0);
    for (const auto v : surface.vertices()) {
        double sum = 0.0, weight = 0.0;
        for (const auto f : surface.faces_around_target(surface.halfedge(v))) {
            if (!f.is_valid() || !gap[f]) continue;
            const double area = std::sqrt(double_area(triangle_of(surface, f)).squared_length());
            sum += area * *gap[f];
            weight += area;
        }
        if (weight > 0.0) mean[v] = sum / weight;
    }
    return mean;
}

/// Pulls the wrap, which lies outside of the scan, in by the gap between them: the noise of a scan is met in its mean.
/// Where it would intersect itself it stays.
void pull_in(const Scan& scan, Wrapped& wrapped) {
    Surface& surface = wrapped.surface;
    std::vector<double> way = mean_gaps(wrapped, scan);
    std::vector<Vector> normal(surface.number_of_vertices());
    pmp::compute_vertex_normals(surface,
                                boost::make_iterator_property_map(normal.begin(), get(boost::vertex_index, surface)));
    const std::vector<Point> from(surface.points().begin(), surface.points().end());
    for (int round = 0; round <= kUntangle; ++round) {
        for (const auto v : surface.vertices()) surface.point(v) = from[v] - way[v] * normal[v];
        std::vector<std::pair<Surface::Face_index, Surface::Face_index>> pairs;
        pmp::self_intersections(surface, std::back_inserter(pairs));
        if (pairs.empty()) return;
        for (const auto& [a, b] : pairs)
            for (const auto f : {a, b})
                for (const auto v : surface.vertices_around_face(surface.halfedge(f))) way[v] = 0.0;
        if (round + 1 == kUntangle) std::fill(way.begin(), way.end(), 0.0);
    }
}

}  // namespace

}  // namespace haptable

void haptable_cgal_wrap(const std::filesystem::path& file, const haptable::Soup& soup, const Eigen::Vector3d& centre,
                        const haptable::FillTarget& target, std::string& packed) {
    using namespace haptable;
    Scan scan;
    read_scan(soup, centre, scan);
    Wrapped wrapped = find_wrap(file, scan, target);
    pull_in(scan, wrapped);
    std::vector<double> coordinate;
    for (const auto v : wrapped.surface.vertices())
        for (int axis = 0; axis < 3; ++axis) coordinate.push_back(wrapped.surface.point(v)[axis] + centre[axis]);
    std::vector<std::size_t> corner;
    for (const auto f : wrapped.surface.faces())
        for (const auto v : wrapped.surface.vertices_around_face(wrapped.surface.halfedge(f))) corner.push_back(v);
    Packer out;
    out.one(wrapped.alpha);
    out.one(scan.holes);
    out.list(coordinate);
    out.list(corner);
    packed = out.take();
}

void haptable_cgal_distances(const haptable::Soup& soup, const std::vector<Eigen::Vector3d>& points,
                             const Eigen::Vector3d& centre, std::string& packed) {
    using namespace haptable;
    const std::vector<Point> corner = about(soup.point, centre);
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : soup.triangle) triangles.emplace_back(corner[a], corner[b], corner[c]);
    const Tree tree(triangles.cbegin(), triangles.cend());
    std::vector<double> distance;
    for (const Point& p : about(points, centre)) distance.push_back(std::sqrt(tree.squared_distance(p)));
    Packer out;
    out.list(distance);
    packed = out.take();
}
