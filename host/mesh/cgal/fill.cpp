// SPDX-License-Identifier: GPL-2.0-or-later
// A part of haptable-cgal.so: surface -> oriented -> not intersecting -> Delaunay refinement at a size -> measured,
// size mended
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/make_mesh_3.h>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>

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

constexpr double kCrease_deg = 75.0;
constexpr double kFlattest_deg = 10.0;  // dihedral angles below this are mended as far as it goes
constexpr double kFacetAngle_deg = 25.0;
constexpr double kShape = 2.5;       // circumradius over the shortest edge
constexpr double kFacetSize = 0.85;  // circumradius per edge that gives such edges in the mean
constexpr double kDistance = 0.1;    // from the given surface, per edge
constexpr double kClose = 0.05;      // relative: near enough to what was asked for
constexpr int kTries = 12;
constexpr double kMostNodes = 2e6;
constexpr double kNodesPerVolume = 1.6;  // of a body of tetrahedra with edges of length 1

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

/// The surface as CGAL has it, about `centre`, its outside outside.
SurfaceMesh to_surface_mesh(const fs::path& file, const Soup& soup, const Eigen::Vector3d& centre) {
    std::vector<Point> points;
    for (const Eigen::Vector3d& p : soup.point)
        points.emplace_back(p.x() - centre.x(), p.y() - centre.y(), p.z() - centre.z());
    std::vector<std::vector<std::size_t>> polygons;
    for (const auto& triangle : soup.triangle) polygons.emplace_back(triangle.begin(), triangle.end());
    pmp::orient_polygon_soup(points, polygons);  // doubles the points where two sheets touch
    if (!pmp::is_polygon_soup_a_polygon_mesh(polygons))
        fail(file, "the surface has no inside and outside (a Moebius strip or the like); mend it in your mesh program");
    SurfaceMesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, polygons, mesh);
    if (!CGAL::is_closed(mesh)) fail(file, "the surface cannot be oriented: it has no inside; mend its triangles");
    return mesh;
}

void require_apart(const fs::path& file, const SurfaceMesh& mesh, const Eigen::Vector3d& centre) {
    std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
    pmp::self_intersections(mesh, std::back_inserter(pairs));
    if (pairs.empty()) return;
    const auto first = std::min_element(pairs.begin(), pairs.end());
    const Point& p = mesh.point(mesh.target(mesh.halfedge(first->first)));
    fail(file, fmt::format("the surface intersects itself: {} pairs of triangles (the first near ({:.6g}, {:.6g}, "
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

Complex refine(const Domain& domain, double edge, ChildCount& count) {
    CGAL::get_default_random() = CGAL::Random(0);  // same input, same mesh
    const Criteria criteria(parameters::edge_size = 1.5 * edge, parameters::facet_angle = kFacetAngle_deg,
                            parameters::facet_size = kFacetSize * edge, parameters::facet_distance = kDistance * edge,
                            parameters::cell_radius_edge_ratio = kShape, parameters::cell_size = kFacetSize * edge);
    return CGAL::make_mesh_3<Complex>(domain, CountingCriteria(criteria, count), parameters::no_perturb(),
                                      parameters::no_exude());
}

/// How far a mesh is from the count of nodes: below 1 where it is too coarse. A length is met as it is.
double miss(const Complex& complex, const FillTarget& target) {
    if (target.node_count == 0) return 1.0;
    return std::cbrt(static_cast<double>(number_vertices(complex).size()) / static_cast<double>(target.node_count));
}

/// Refines at a size and, for a count of nodes, measures and mends the size.
Complex refine_to(const fs::path& file, const SurfaceMesh& surface, const FillTarget& target, ChildCount& count) {
    const double volume = pmp::volume(surface);
    double edge = target.edge_length;
    if (edge <= 0.0) edge = std::cbrt(kNodesPerVolume * volume / static_cast<double>(target.node_count));
    const double nodes = kNodesPerVolume * volume / (edge * edge * edge);
    if (nodes > kMostNodes)
        fail(file, fmt::format("about {:.2g} nodes would fill it, and {:.0e} is the most; give a longer edge_length or "
                               "a smaller node_count in [mesh]",
                               nodes, kMostNodes));
    Domain domain(surface);
    domain.detect_features(kCrease_deg);
    Complex best;
    double least = std::numeric_limits<double>::infinity();
    double too_short = 0.0, too_long = 0.0;  // edges; 0: none yet
    for (int tries = 0; tries < kTries && 3.0 * least > std::log(1.0 + kClose); ++tries) {
        count.expected = target.node_count > 0 ? target.node_count : static_cast<std::uint64_t>(nodes);
        Complex complex = refine(domain, edge, count);
        if (complex.number_of_cells_in_complex() == 0) break;
        const double factor = miss(complex, target);
        if (std::abs(std::log(factor)) < least) {
            least = std::abs(std::log(factor));
            best.swap(complex);
        }
        (factor > 1.0 ? too_short : too_long) = edge;
        edge = too_short > 0.0 && too_long > 0.0 ? std::sqrt(too_short * too_long) : edge * factor;
    }
    if (best.number_of_cells_in_complex() == 0) fail(file, "no tetrahedron fits into it; give a shorter edge_length");
    CGAL::perturb_mesh_3(best, domain, parameters::sliver_bound = kFlattest_deg);
    CGAL::exude_mesh_3(best, parameters::sliver_bound = kFlattest_deg);
    return best;
}

/// Where creases lie nearer to each other than the edges asked for, tetrahedra are pressed flat between them.
void require_volumes(const fs::path& file, const Complex& complex) {
    constexpr double kFlat = 1e-9;  // volume over the longest edge cubed; 0.118 for the regular tetrahedron
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
        const auto tet = complex.triangulation().tetrahedron(cell);
        double longest2 = 0.0;
        for (int c = 0; c < 4; ++c)
            for (int d = 0; d < c; ++d) longest2 = std::max(longest2, CGAL::squared_distance(tet[c], tet[d]));
        if (!(tet.volume() > kFlat * longest2 * std::sqrt(longest2)))
            fail(file,
                 "its creases lie nearer to each other than the tetrahedra's edges, which leaves flat ones; give "
                 "a shorter edge_length or more nodes, or smooth the surface");
    }
}

std::string pack(const Complex& complex, const Eigen::Vector3d& centre) {
    const auto number = number_vertices(complex);
    std::vector<double> coordinate(3 * number.size());
    for (const auto& [vertex, i] : number)
        for (int axis = 0; axis < 3; ++axis)
            coordinate[3 * i + static_cast<std::size_t>(axis)] = vertex->point().point()[axis] + centre[axis];
    std::vector<std::size_t> corner;
    for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell)
        for (int c = 0; c < 4; ++c) corner.push_back(number.at(cell->vertex(c)));
    Packer out;
    out.list(coordinate);
    out.list(corner);
    out.one(mean_edge(complex));
    return out.take();
}

}  // namespace

}  // namespace haptable

void haptable_cgal_fill(const std::filesystem::path& file, const haptable::Soup& soup, const Eigen::Vector3d& centre,
                        const haptable::FillTarget& target, haptable::ChildCount& count, std::string& packed) {
    using namespace haptable;
    SurfaceMesh surface = to_surface_mesh(file, soup, centre);
    require_apart(file, surface, centre);
    pmp::orient_to_bound_a_volume(surface);
    const Complex complex = refine_to(file, surface, target, count);
    require_volumes(file, complex);
    packed = pack(complex, centre);
}
