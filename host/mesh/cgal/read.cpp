// SPDX-License-Identifier: GPL-2.0-or-later
// A part of haptable-cgal.so: surfaces by CGAL's readers. It runs in a child process (host/mesh/read_surface.cpp).
#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#include <fmt/format.h>

#include <cmath>
#include <sstream>
#include <vector>

#include "host/base/error.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Point = CGAL::Simple_cartesian<double>::Point_3;
using Polygon = std::vector<std::size_t>;

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

bool parse(std::istringstream& in, SurfaceKind kind, std::vector<Point>& points, std::vector<Polygon>& polygons) {
    switch (kind) {
        case SurfaceKind::kStl:
            return CGAL::IO::read_STL(in, points, polygons);
        case SurfaceKind::kPly:
            return CGAL::IO::read_PLY(in, points, polygons);
        case SurfaceKind::kOff:
            return CGAL::IO::read_OFF(in, points, polygons);
        case SurfaceKind::kObj:
            return CGAL::IO::read_OBJ(in, points, polygons);
    }
    return false;
}

/// Polygons of more corners become fans of triangles.
std::string pack(const fs::path& file, const std::vector<Point>& points, const std::vector<Polygon>& polygons) {
    std::vector<double> coordinate;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            if (!std::isfinite(points[i][axis])) fail(file, fmt::format("vertex {} has no finite position", i));
            coordinate.push_back(points[i][axis]);
        }
    std::vector<Tag> corner;
    for (std::size_t f = 0; f < polygons.size(); ++f) {
        for (std::size_t i : polygons[f])
            if (i >= points.size())
                fail(file, fmt::format("face {} names vertex {} of {}; save it again", f, i, points.size()));
        for (std::size_t c = 2; c < polygons[f].size(); ++c)
            corner.insert(corner.end(), {polygons[f][0], polygons[f][c - 1], polygons[f][c]});
    }
    Packer out;
    out.list(coordinate);
    out.list(corner);
    return out.take();
}

}  // namespace

}  // namespace haptable

void haptable_cgal_read(const std::filesystem::path& file, std::string_view text, haptable::SurfaceKind kind,
                        std::string& packed) {
    std::istringstream in{std::string(text)};
    std::vector<haptable::Point> points;
    std::vector<haptable::Polygon> polygons;
    if (!haptable::parse(in, kind, points, polygons))
        haptable::fail(file, "CGAL cannot read it: it is damaged; save it again");
    packed = haptable::pack(file, points, polygons);
}
