// SPDX-License-Identifier: GPL-2.0-or-later
// A part of haptable-cgal.so: surface -> oriented -> not intersecting -> creases -> Delaunay refinement at a size ->
// measured, size mended
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/detect_features.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/make_mesh_3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "host/base/error.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
namespace pmp = CGAL::Polygon_mesh_processing;
namespace parameters = CGAL::parameters;

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using SurfaceMesh = CGAL::Surface_mesh<Point>;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel, SurfaceMesh>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

struct TooManyPoints {};

/// The surface has no inside, which a wrap around it would have.
struct NoInside : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The domain, counting the points that are put on creases: around noisy ones CGAL puts them without end. And with
/// points to begin with on each of several parts: those of CGAL, on rays from the middle of all, miss small ones.
class CountingDomain : public Domain {
public:
    explicit CountingDomain(const SurfaceMesh& surface) : Domain(surface), across_(segments_across(surface)) {}
    /// Until the next call, at most so many.
    void allow(std::size_t points) { left_ = points; }
    Point construct_point_on_curve(const Point& from, const Curve_index& curve, double distance) const {
        if (left_-- == 0) throw TooManyPoints();
        return Domain::construct_point_on_curve(from, curve, distance);
    }
    auto construct_initial_points_object() const {
        return [this](auto points, int count = 8) {
            points = Domain::construct_initial_points_object()(points, count);
            for (const Kernel::Segment_3& segment : across_) {
                if (!do_intersect_surface_object()(segment)) continue;
                const auto met = construct_intersection_object()(segment);
                *points++ = std::make_pair(std::get<0>(met), std::get<1>(met));
            }
            return points;
        };
    }

private:
    /// Short ones through some faces of each part; none of a surface of one part.
    static std::vector<Kernel::Segment_3> segments_across(const SurfaceMesh& surface) {
        constexpr std::size_t kOfPart = 16;
        constexpr double kShort = 1e-3;  // of a face
        std::vector<std::size_t> part(surface.number_of_faces());
        const auto of = boost::make_iterator_property_map(part.begin(), get(boost::face_index, surface));
        std::vector<std::vector<SurfaceMesh::Face_index>> faces(pmp::connected_components(surface, of));
        for (const auto face : surface.faces()) faces[part[face]].push_back(face);
        std::vector<Kernel::Segment_3> across;
        for (const auto& list : faces)
            for (std::size_t k = 0; faces.size() > 1 && k < std::min(kOfPart, list.size()); ++k) {
                const auto h = surface.halfedge(list[k * list.size() / std::min(kOfPart, list.size())]);
                const Point &a = surface.point(surface.source(h)), &b = surface.point(surface.target(h)),
                            &c = surface.point(surface.target(surface.next(h)));
                const auto normal = CGAL::cross_product(b - a, c - a);
                const auto way = kShort / std::sqrt(std::sqrt(normal.squared_length())) * normal;
                across.emplace_back(CGAL::centroid(a, b, c) - way, CGAL::centroid(a, b, c) + way);
            }
        return across;
    }

    mutable std::size_t left_ = 0;
    std::vector<Kernel::Segment_3> across_;
};

/// A criterion of the refinement that counts the nodes there are whenever it is asked.
template <typename Base>
class Counting : public Base {
public:
    Counting(const Base& base, ChildCount& count) : Base(base), count_(&count) {}
    template <typename Part>
    auto operator()(const Triangulation& triangulation, const Part& part) const {
        count_->done = triangulation.number_of_vertices();
        return Base::operator()(triangulation, part);
    }

private:
    ChildCount* count_;
};

/// The criteria, counting.
class CountingCriteria {
public:
    using Edge_criteria = Criteria::Edge_criteria;
    using Facet_criteria = Counting<Criteria::Facet_criteria>;
    using Cell_criteria = Counting<Criteria::Cell_criteria>;
    CountingCriteria(const Criteria& criteria, ChildCount& count)
        : edge_(criteria.edge_criteria_object()),
          facet_(criteria.facet_criteria_object(), count),
          cell_(criteria.cell_criteria_object(), count) {}
    const Edge_criteria& edge_criteria_object() const { return edge_; }
    const Facet_criteria& facet_criteria_object() const { return facet_; }
    const Cell_criteria& cell_criteria_object() const { return cell_; }

private:
    Edge_criteria edge_;
    Facet_criteria facet_;
    Cell_criteria cell_;
};

constexpr double kNoCrease_deg = 180.0;  // CGAL: no edge is one
constexpr double kFlattest_deg = 10.0;   // dihedral angles below this are mended as far as it goes
constexpr double kFacetAngle_deg = 25.0;
constexpr double kShape = 2.5;       // circumradius over the shortest edge
constexpr double kFacetSize = 0.85;  // circumradius per edge that gives such edges in the mean
constexpr double kDistance = 0.1;    // from the given surface, per edge
constexpr double kClose = 0.05;      // relative: near enough to what was asked for
constexpr int kTries = 12, kTriesOver = 3;
constexpr double kMostNodes = 2e6;
// A refinement that takes this many times the nodes asked for, and this many at the least, is given up.
constexpr std::size_t kMostTimes = 8, kLeastBudget = 20'000;
constexpr double kNodesPerVolume = 1.6;  // of a body of tetrahedra with edges of length 1

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

/// The surface as CGAL has it, about `centre`, its outside outside.
SurfaceMesh to_surface_mesh(const Soup& soup, const Eigen::Vector3d& centre) {
    std::vector<Point> points;
    for (const Eigen::Vector3d& p : soup.point)
        points.emplace_back(p.x() - centre.x(), p.y() - centre.y(), p.z() - centre.z());
    std::vector<std::vector<std::size_t>> polygons;
    for (const auto& triangle : soup.triangle) polygons.emplace_back(triangle.begin(), triangle.end());
    pmp::orient_polygon_soup(points, polygons);  // doubles the points where two sheets touch
    if (!pmp::is_polygon_soup_a_polygon_mesh(polygons))
        throw NoInside(
            "the surface has no inside and outside (a Moebius strip or the like); mend it in your mesh program");
    SurfaceMesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh);
    if (!CGAL::is_closed(mesh)) throw NoInside("the surface cannot be oriented: it has no inside; mend its triangles");
    return mesh;
}

void require_apart(const SurfaceMesh& mesh, const Eigen::Vector3d& centre) {
    std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
    pmp::self_intersections(mesh, std::back_inserter(pairs));
    if (pairs.empty()) return;
    const auto first = std::min_element(pairs.begin(), pairs.end());
    const Point& p = mesh.point(mesh.target(mesh.halfedge(first->first)));
    throw NoInside(
        fmt::format("the surface intersects itself: {} pairs of triangles (the first near ({:.6g}, {:.6g}, "
                    "{:.6g})); mend it in your mesh program",
                    pairs.size(), p.x() + centre.x(), p.y() + centre.y(), p.z() + centre.z()));
}

double mean_edge(const Complex& complex) {
    double sum = 0.0;
    std::size_t count = 0;
    for (auto facet = complex.facets_in_complex_begin(); facet != complex.facets_in_complex_end(); ++facet) {
        const auto triangle = complex.triangulation().triangle(*facet);
        for (int c = 0; c < 3; ++c) sum += std::sqrt(CGAL::squared_distance(triangle[c], triangle[(c + 1) % 3]));
        count += 3;
    }
    return sum / static_cast<double>(count);
}

/// The vertices of tetrahedra, numbered as they come.
std::map<Triangulation::Vertex_handle, std::size_t> number_vertices(const Complex& complex) {
    std::map<Triangulation::Vertex_handle, std::size_t> number;
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell)
        for (int c = 0; c < 4; ++c) number.emplace(cell->vertex(c), number.size());
    return number;
}

/// False where it takes `most` nodes, or creases alone do; then count.done = most.
bool refine(CountingDomain& domain, double edge, std::size_t most, ChildCount& count, Complex& complex) {
    CGAL::get_default_random() = CGAL::Random(0);  // same input, same mesh
    const Criteria criteria(parameters::edge_size = 1.5 * edge, parameters::facet_angle = kFacetAngle_deg,
                            parameters::facet_size = kFacetSize * edge, parameters::facet_distance = kDistance * edge,
                            parameters::cell_radius_edge_ratio = kShape, parameters::cell_size = kFacetSize * edge);
    CGAL::Mesh_error_code stopped = CGAL::CGAL_MESH_3_NO_ERROR;
    domain.allow(most / kMostTimes);
    try {
        Complex made = CGAL::make_mesh_3<Complex>(
            domain, CountingCriteria(criteria, count), parameters::no_perturb(), parameters::no_exude(),
            parameters::mesh_3_options(parameters::maximal_number_of_vertices = most,
                                       parameters::pointer_to_error_code = &stopped));
        complex.swap(made);
        if (stopped == CGAL::CGAL_MESH_3_NO_ERROR) return true;
    } catch (const TooManyPoints&) {
    }
    count.done = most;
    return false;
}

/// How far a mesh is from the count of nodes: below 1 where it is too coarse. A length is met as it is.
double miss(const Complex& complex, const FillTarget& target) {
    if (target.node_count == 0) return 1.0;
    return std::cbrt(static_cast<double>(number_vertices(complex).size()) / static_cast<double>(target.node_count));
}

/// The edge that a count of nodes would have in a body without a surface; an edge is met as it is.
double first_edge(const fs::path& file, double volume, const FillTarget& target) {
    double edge = target.edge_length;
    if (edge <= 0.0) edge = std::cbrt(kNodesPerVolume * volume / static_cast<double>(target.node_count));
    const double nodes = kNodesPerVolume * volume / (edge * edge * edge);
    if (nodes > kMostNodes)
        fail(file, fmt::format("about {:.2g} nodes would fill it, and {:.0e} is the most; give a longer edge_length or "
                               "a smaller node_count in [mesh]",
                               nodes, kMostNodes));
    return edge;
}

/// About as many as there will be, inside and on the surface.
std::size_t nodes_of(double volume, double area, double edge) {
    return static_cast<std::size_t>(kNodesPerVolume * volume / (edge * edge * edge) + area / (edge * edge));
}

/// The size that a count of nodes wants, from those that were tried.
class Search {
public:
    explicit Search(double edge) : edge_(edge) {}
    double edge() const { return edge_; }
    /// factor: how far the edge is from giving the count. False where the count does not follow the edge: creases of
    /// noise have their nodes whatever it is.
    bool next(double factor) {
        const bool follows = last_edge_ == 0.0 ||
                             std::abs(std::log(factor / last_factor_)) > 0.1 * std::abs(std::log(edge_ / last_edge_));
        last_edge_ = edge_;
        last_factor_ = factor;
        (factor > 1.0 ? too_short_ : too_long_) = edge_;
        edge_ = too_short_ > 0.0 && too_long_ > 0.0 ? std::sqrt(too_short_ * too_long_) : edge_ * factor;
        return follows;
    }

private:
    double edge_, too_short_ = 0.0, too_long_ = 0.0;  // 0: none yet
    double last_edge_ = 0.0, last_factor_ = 0.0;
};

/// Refines at a size and, for a count of nodes, measures and mends the size. Without a cell where none fits into it;
/// then count.done < most, or it takes too many.
Complex refine_to(CountingDomain& domain, double edge, std::size_t most, const FillTarget& target, ChildCount& count) {
    Complex best;
    double least = std::numeric_limits<double>::infinity();
    Search search(edge);
    int over = 0;
    for (int tries = 0; tries < kTries && 3.0 * least > std::log(1.0 + kClose); ++tries) {
        Complex complex;
        if (!refine(domain, search.edge(), most, count, complex)) {
            if (target.node_count == 0 || ++over == kTriesOver) break;
            search.next(std::cbrt(kMostTimes));
            continue;
        }
        if (complex.number_of_cells_in_complex() == 0) break;
        const double factor = miss(complex, target);
        if (std::abs(std::log(factor)) < least) {
            least = std::abs(std::log(factor));
            best.swap(complex);
        }
        if (!search.next(factor)) break;
    }
    return best;
}

/// Where creases lie nearer to each other than the edges asked for, tetrahedra are pressed flat between them.
bool has_flat(const Complex& complex) {
    constexpr double kFlat = 1e-9;  // volume over the longest edge cubed; 0.118 for the regular tetrahedron
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
        const auto tet = complex.triangulation().tetrahedron(cell);
        double longest2 = 0.0;
        for (int c = 0; c < 4; ++c)
            for (int d = 0; d < c; ++d) longest2 = std::max(longest2, CGAL::squared_distance(tet[c], tet[d]));
        if (!(tet.volume() > kFlat * longest2 * std::sqrt(longest2))) return true;
    }
    return false;
}

std::size_t count_creases(const SurfaceMesh& surface, double crease_deg) {
    auto is_crease = get(CGAL::dynamic_edge_property_t<bool>(), surface);
    for (const auto edge : surface.edges()) put(is_crease, edge, false);
    pmp::detect_sharp_edges(surface, crease_deg, is_crease);
    return static_cast<std::size_t>(std::count_if(surface.edges().begin(), surface.edges().end(),
                                                  [&](const auto edge) { return get(is_crease, edge); }));
}

/// The number of its closed parts that are turned inwards.
std::size_t count_cavities(const SurfaceMesh& surface) {
    std::vector<SurfaceMesh> parts;
    pmp::split_connected_components(surface, parts);
    return static_cast<std::size_t>(
        std::count_if(parts.begin(), parts.end(), [](const SurfaceMesh& part) { return pmp::volume(part) < 0.0; }));
}

void pack(const Complex& complex, const Eigen::Vector3d& centre, Packer& out) {
    const auto number = number_vertices(complex);
    std::vector<double> coordinate(3 * number.size());
    for (const auto& [vertex, i] : number)
        for (int axis = 0; axis < 3; ++axis)
            coordinate[3 * i + static_cast<std::size_t>(axis)] = vertex->point().point()[axis] + centre[axis];
    std::vector<std::size_t> corner;
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell)
        for (int c = 0; c < 4; ++c) corner.push_back(number.at(cell->vertex(c)));
    out.list(coordinate);
    out.list(corner);
    out.one(mean_edge(complex));
}

/// Meshes the inside; returns why that failed, or nothing.
std::string mesh_inside(CountingDomain& domain, double edge, std::size_t expected, const FillTarget& target,
                        ChildCount& count, Complex& complex) {
    const std::size_t most = std::max(kLeastBudget, kMostTimes * expected);
    count.expected = expected;
    complex = refine_to(domain, edge, most, target, count);
    if (complex.number_of_cells_in_complex() == 0)
        return count.done >= most
                   ? "its creases or its thin parts take many times the nodes asked for; give more nodes or a shorter "
                     "edge_length, or smooth the surface"
                   : "no tetrahedron fits into it; give a shorter edge_length";
    CGAL::perturb_mesh_3(complex, domain, parameters::sliver_bound = kFlattest_deg);
    CGAL::exude_mesh_3(complex, parameters::sliver_bound = kFlattest_deg);
    if (has_flat(complex))
        return "its creases lie nearer to each other than the tetrahedra's edges, which leaves flat ones; give a "
               "shorter edge_length or more nodes, or smooth the surface";
    return "";
}

}  // namespace

}  // namespace haptable

void haptable_cgal_fill(const std::filesystem::path& file, const haptable::Soup& soup, const Eigen::Vector3d& centre,
                        const haptable::FillTarget& target, double crease_deg, haptable::ChildCount& count,
                        std::string& packed) {
    using namespace haptable;
    double volume = 0.0;
    std::size_t cavities = 0, creases = 0;
    Complex complex;
    std::string failed;
    try {
        SurfaceMesh surface = to_surface_mesh(soup, centre);
        require_apart(surface, centre);
        pmp::orient_to_bound_a_volume(surface);
        volume = pmp::volume(surface);
        cavities = count_cavities(surface);
        creases = crease_deg > 0.0 ? count_creases(surface, crease_deg) : 0;
        const double edge = first_edge(file, volume, target);
        CountingDomain domain(surface);
        domain.detect_features(crease_deg > 0.0 ? crease_deg : kNoCrease_deg);
        const std::size_t expected =
            target.node_count > 0 ? target.node_count : nodes_of(volume, pmp::area(surface), edge);
        failed = mesh_inside(domain, edge, expected, target, count, complex);
    } catch (const NoInside& why) {
        failed = why.what();
    }
    Packer out;
    out.one(volume);
    out.one(cavities);
    out.one(creases);
    out.text(failed);
    if (failed.empty()) pack(complex, centre, out);
    packed = out.take();
}
