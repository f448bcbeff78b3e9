// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/sample_tool.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "host/base/error.hpp"
#include "host/base/si.hpp"
#include "host/base/tool_range.hpp"
#include "host/mesh/read_mesh.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

// So many places a face's points are chosen from: at 32 points some 100 to each.
constexpr std::size_t kTried = 3000;

// Of the spacing, from a flat face's border to its outermost points. A punch's force and tilt are right to 2 % and 5 %
// from seven points on, where the mask's radius is 0.7 of the spacing.
constexpr double kInset = 0.265;

constexpr double kGolden = 1.0 / std::numbers::phi;  // its multiples fill a circle evenly

/// A surface by places of equal area.
struct Face {
    std::vector<Vector3d> place, normal;
    double area = 0.0;
    std::vector<std::array<Vector3d, 2>> border;  ///< edges
};

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// Between neighbours of a hexagonal grid.
double spacing(double area, std::size_t count) {
    return std::sqrt(2.0 * area / (std::numbers::sqrt3 * static_cast<double>(count)));
}

/// The middle of the k-th of `count` equal parts of 0 to 1.
double middle(std::size_t k, std::size_t count) { return (static_cast<double>(k) + 0.5) / static_cast<double>(count); }

/// Around an axis, 0 to 1.
double turn(std::size_t k) {
    const double turns = kGolden * static_cast<double>(k);
    return turns - std::floor(turns);
}

/// Equal heights of a sphere are equal areas (Archimedes).
Face on_sphere(const ToolShape& shape, std::size_t count) {
    const double height = 1.0 - std::cos(radians(shape.angle_deg));
    Face face;
    face.area = 2.0 * std::numbers::pi * shape.radius_m * shape.radius_m * height;
    for (std::size_t k = 0; k < count; ++k) {
        const double z = 1.0 - height * middle(k, count), angle = 2.0 * std::numbers::pi * turn(k);
        const double across = std::sqrt(1.0 - z * z);
        face.normal.emplace_back(across * std::cos(angle), across * std::sin(angle), -z);
        face.place.push_back(shape.radius_m * face.normal.back());
    }
    return face;
}

/// The same of its ends, which go on where the cylinder ends: equal lengths of the axis are equal areas all along.
Face on_capsule(const ToolShape& shape, std::size_t count) {
    const double half = 0.5 * shape.length_m, reach = half + shape.radius_m, angle = radians(shape.angle_deg);
    Face face;
    face.area = 2.0 * reach * 2.0 * angle * shape.radius_m;
    for (std::size_t k = 0; k < count; ++k) {
        const double x = reach * (2.0 * middle(k, count) - 1.0), about = angle * (2.0 * turn(k + 1) - 1.0);
        const double beyond = (x - std::clamp(x, -half, half)) / shape.radius_m;
        const double across = std::sqrt(1.0 - beyond * beyond);
        face.normal.emplace_back(beyond, across * std::sin(about), -across * std::cos(about));
        face.place.push_back(Vector3d(std::clamp(x, -half, half), 0.0, 0.0) + shape.radius_m * face.normal.back());
    }
    return face;
}

/// Points of a disc: a sunflower's.
Face on_disc(const ToolShape& shape) {
    Face face;
    face.area = std::numbers::pi * shape.radius_m * shape.radius_m;
    const auto at = [&](double radius, double turns) {
        const double angle = 2.0 * std::numbers::pi * turns;
        return Vector3d(radius * std::cos(angle), radius * std::sin(angle), 0.0);
    };
    for (std::size_t k = 0; k < kTried; ++k)
        face.place.push_back(at(shape.radius_m * std::sqrt(middle(k, kTried)), turn(k)));
    face.normal.assign(kTried, -Vector3d::UnitZ());
    constexpr std::size_t kEdges = 360;
    for (std::size_t k = 0; k < kEdges; ++k)
        face.border.push_back({at(shape.radius_m, static_cast<double>(k) / kEdges),
                               at(shape.radius_m, static_cast<double>(k + 1) / kEdges)});
    return face;
}

/// Edges that one triangle has and no other.
std::vector<std::array<Vector3d, 2>> border_of(const std::vector<std::array<std::size_t, 3>>& triangle,
                                               const std::vector<Vector3d>& point) {
    std::map<std::array<std::size_t, 2>, int> count;
    for (const auto& corner : triangle)
        for (std::size_t e = 0; e < 3; ++e) {
            const auto [low, high] = std::minmax(corner[e], corner[(e + 1) % 3]);
            ++count[{low, high}];
        }
    std::vector<std::array<Vector3d, 2>> border;
    for (const auto& [edge, times] : count)
        if (times == 1) border.push_back({point[edge[0]], point[edge[1]]});
    return border;
}

/// The triangles that face along -z.
Face on_mesh(const ToolShape& shape) {
    const Soup soup = read_triangles(shape.file, shape.scale_m);
    Face face;
    std::vector<std::array<std::size_t, 3>> kept;
    std::vector<Vector3d> normal;
    std::vector<double> until;  // areas, summed
    const double least = std::cos(radians(shape.angle_deg));
    for (const auto& corner : soup.triangle) {
        const Vector3d &a = soup.point[corner[0]], &b = soup.point[corner[1]], &c = soup.point[corner[2]];
        const Vector3d twice = (b - a).cross(c - a);
        if (!(-twice.z() >= least * twice.norm()) || twice.norm() == 0.0) continue;
        kept.push_back(corner);
        normal.push_back(twice.normalized());
        until.push_back(face.area += 0.5 * twice.norm());
    }
    if (kept.empty())
        throw Error(
            fmt::format("{}: none of its {} triangles faces along -z within {:g} degrees: turn the tool, so "
                        "that the side that touches faces down, or give a greater angle in [tool]",
                        shape.file.string(), soup.triangle.size(), shape.angle_deg));
    for (std::size_t k = 0; k < kTried; ++k) {
        const double to = face.area * middle(k, kTried);
        const auto found = static_cast<std::size_t>(std::upper_bound(until.begin(), until.end(), to) - until.begin());
        const std::size_t t = std::min(found, kept.size() - 1);
        // Even shares of a triangle: a square's, folded.
        constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;  // Roberts' R2 sequence
        double s = kFirst * static_cast<double>(k), r = kSecond * static_cast<double>(k);
        s -= std::floor(s);
        r -= std::floor(r);
        if (s + r > 1.0) {
            s = 1.0 - s;
            r = 1.0 - r;
        }
        const Vector3d& a = soup.point[kept[t][0]];
        face.place.emplace_back(a + s * (soup.point[kept[t][1]] - a) + r * (soup.point[kept[t][2]] - a));
        face.normal.push_back(normal[t]);
    }
    face.border = border_of(kept, soup.point);
    return face;
}

double distance(const Vector3d& p, const std::array<Vector3d, 2>& edge) {
    const Vector3d along = edge[1] - edge[0];
    const double share = std::clamp((p - edge[0]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (p - edge[0] - share * along).norm();
}

/// Places that are no nearer to the border. Where a face is too narrow for it, those that are farthest from it.
std::vector<std::size_t> inside(const Face& face, double inset, std::size_t least) {
    std::vector<double> to_border(face.place.size(), std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < face.place.size(); ++k)
        for (const auto& edge : face.border) to_border[k] = std::min(to_border[k], distance(face.place[k], edge));
    std::vector<double> ascending = to_border;
    const std::size_t most = face.place.size() - std::min(face.place.size(), 10 * least);
    std::nth_element(ascending.begin(), ascending.begin() + static_cast<std::ptrdiff_t>(most), ascending.end());
    std::vector<std::size_t> kept;
    for (std::size_t k = 0; k < face.place.size(); ++k)
        if (to_border[k] >= std::min(inset, ascending[most])) kept.push_back(k);
    return kept;
}

/// The places of `among` that repel each other least by the inverse square of their distance: each in turn moves to the
/// best place while any does.
std::vector<std::size_t> repel(const Face& face, const std::vector<std::size_t>& among, std::size_t count) {
    constexpr int kRounds = 40;
    const auto squared = [&](std::size_t a, std::size_t b) { return (face.place[a] - face.place[b]).squaredNorm(); };
    std::vector<std::size_t> chosen{among.front()};
    std::vector<double> nearest(among.size(), std::numeric_limits<double>::infinity());
    while (chosen.size() < count) {  // the farthest from those before
        for (std::size_t k = 0; k < among.size(); ++k)
            nearest[k] = std::min(nearest[k], squared(among[k], chosen.back()));
        chosen.push_back(
            among[static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin())]);
    }
    const auto energy = [&](std::size_t place, std::size_t of) {
        double sum = 0.0;
        for (std::size_t i = 0; i < count; ++i)
            if (i != of) sum += 1.0 / squared(place, chosen[i]);
        return sum;
    };
    bool has_moved = true;
    for (int round = 0; round < kRounds && has_moved; ++round) {
        has_moved = false;
        for (std::size_t i = 0; i < count; ++i) {
            double least = energy(chosen[i], i) * (1.0 - 1e-9);
            for (const std::size_t place : among)
                if (const double here = energy(place, i); here < least) {
                    least = here;
                    chosen[i] = place;
                    has_moved = true;
                }
        }
    }
    return chosen;
}

/// How far the face lies behind a place along its normal, in the mean that a mask weighs.
double behind(const Face& face, std::size_t at, double mask_radius) {
    if (!(mask_radius > 0.0)) return 0.0;
    double sum = 0.0, weights = 0.0;
    for (std::size_t k = 0; k < face.place.size(); ++k) {
        const Vector3d away = face.place[k] - face.place[at];
        const double along = away.dot(face.normal[at]), facing = face.normal[k].dot(face.normal[at]);
        const double share = 1.0 - (away.squaredNorm() - along * along) / (mask_radius * mask_radius);
        if (share <= 0.0 || facing <= 0.0 || std::abs(along) > mask_radius) continue;
        sum += share * share * facing * along;
        weights += share * share * facing;
    }
    return weights > 0.0 ? -sum / weights : 0.0;
}

// ---- as it is drawn ------------------------------------------------------------------------------------------------

using Triangles = std::vector<std::array<Vector3d, 3>>;

/// A surface of revolution about z, from below: (radius, height) by (radius, height).
Triangles turned(const std::vector<std::array<double, 2>>& profile) {
    constexpr int kAround = 48;
    Triangles triangles;
    const auto at = [](const std::array<double, 2>& ring, int k) {
        const double angle = 2.0 * std::numbers::pi * k / kAround;
        return Vector3d(ring[0] * std::cos(angle), ring[0] * std::sin(angle), ring[1]);
    };
    for (std::size_t r = 1; r < profile.size(); ++r)
        for (int k = 0; k < kAround; ++k) {
            const Vector3d low = at(profile[r - 1], k), low_next = at(profile[r - 1], k + 1);
            const Vector3d high = at(profile[r], k), high_next = at(profile[r], k + 1);
            if (profile[r - 1][0] > 0.0) triangles.push_back({low, low_next, high_next});
            if (profile[r][0] > 0.0) triangles.push_back({low, high_next, high});
        }
    return triangles;
}

Triangles round_surface(double radius, double half_length) {
    constexpr int kRings = 12;  // of half a sphere
    std::vector<std::array<double, 2>> profile;
    for (int end : {-1, 1})
        for (int k = 0; k <= kRings; ++k) {
            const double angle = 0.5 * std::numbers::pi * (end < 0 ? k - kRings : k) / kRings;
            const bool is_pole = k == (end < 0 ? 0 : kRings);
            profile.push_back({is_pole ? 0.0 : radius * std::cos(angle), radius * std::sin(angle) + end * half_length});
        }
    return turned(profile);
}

Triangles surface_of(const ToolShape& shape) {
    if (shape.kind == ToolShape::Kind::kSphere) return round_surface(shape.radius_m, 0.0);
    // A plate that is as thick as it takes to be seen.
    if (shape.kind == ToolShape::Kind::kDisc)
        return turned(
            {{0.0, 0.0}, {shape.radius_m, 0.0}, {shape.radius_m, 0.1 * shape.radius_m}, {0.0, 0.1 * shape.radius_m}});
    if (shape.kind == ToolShape::Kind::kCapsule) {
        Triangles triangles = round_surface(shape.radius_m, 0.5 * shape.length_m);
        for (auto& corner : triangles)
            for (Vector3d& p : corner) p = Vector3d(p.z(), p.x(), p.y());
        return triangles;
    }
    Triangles triangles;
    const Soup soup = read_triangles(shape.file, shape.scale_m);
    for (const auto& corner : soup.triangle)
        triangles.push_back({soup.point[corner[0]], soup.point[corner[1]], soup.point[corner[2]]});
    return triangles;
}

// ---- points --------------------------------------------------------------------------------------------------------

ToolSample by_spiral(const Face& face, double stand_back_m) {
    ToolSample sample{{}, spacing(face.area, face.place.size()), {}};
    for (std::size_t k = 0; k < face.place.size(); ++k)
        sample.point_m.emplace_back(face.place[k] - stand_back_m * face.normal[k]);
    return sample;
}

ToolSample by_repulsion(const Face& face, std::size_t count, double mask_radius_m) {
    ToolSample sample{{}, spacing(face.area, count), {}};
    for (const std::size_t k : repel(face, inside(face, kInset * sample.spacing_m, count), count))
        sample.point_m.emplace_back(face.place[k] - behind(face, k, mask_radius_m) * face.normal[k]);
    return sample;
}

ToolSample points_of(const ToolShape& shape, double mask_radius_m) {
    const auto count = static_cast<std::size_t>(shape.points);
    const double flattened_m2 = mask_radius_m * mask_radius_m / 16.0;
    switch (shape.kind) {
        case ToolShape::Kind::kSphere:
            return by_spiral(on_sphere(shape, count), 2.0 * flattened_m2 / shape.radius_m);
        case ToolShape::Kind::kCapsule:
            return by_spiral(on_capsule(shape, count), flattened_m2 / shape.radius_m);
        case ToolShape::Kind::kDisc:
            return by_repulsion(on_disc(shape), count, mask_radius_m);
        case ToolShape::Kind::kMesh:
            return by_repulsion(on_mesh(shape), count, mask_radius_m);
    }
    return {};
}

}  // namespace

ToolSample sample_tool(const ToolShape& shape, double mask_radius_m) {
    ToolSample sample = points_of(shape, mask_radius_m);
    sample.surface_m = surface_of(shape);
    return sample;
}

ToolSample complete_tool(Scene& scene) {
    if (!scene.tool) return {};
    Tool& tool = *scene.tool;
    ToolSample sample;
    if (tool.shape) {
        sample = sample_tool(*tool.shape, scene.contact.mask_radius_m);
        tool.point_m.clear();
        for (const Vector3d& p : sample.point_m) tool.point_m.push_back({p.x(), p.y(), p.z()});
    }
    double reach_m = 0.0;
    for (const auto& p : tool.point_m) reach_m = std::max(reach_m, std::hypot(p[0], p[1], p[2]));
    if (!(reach_m > 0.0))
        throw Error(fmt::format("{}:{}: tool.points: are all at the handle: give points that are apart",
                                scene.file.string(), tool.line));
    if (!(tool.max_torque_n_m > 0.0)) tool.max_torque_n_m = servo_force_limit_n(scene) * reach_m;
    return sample;
}

std::string describe_tool(const Scene& scene, const ToolSample& sample) {
    const std::size_t count = scene.tool->point_m.size();
    const double mask_m = scene.contact.mask_radius_m;
    if (!(sample.spacing_m > 0.0)) return fmt::format("{} points", count);
    const std::string text = fmt::format("{} points, {} apart", count, si(sample.spacing_m, "m"));
    if (!(mask_m > 0.0)) return text + "; points are the body's nodes: a pressure mask makes them as wide as the tool";
    constexpr double kLeast = 0.6, kMost = 0.8;  // of the spacing, to a digit: within 5 % of Hertz and of a punch
    const double share = mask_m / sample.spacing_m;
    std::string whole = fmt::format("{}, each with a mask of {:.2f} of that", text, share);
    if (share < kLeast - 0.05 || share > kMost + 0.05) {
        constexpr double kBest = 0.7;
        const double points = static_cast<double>(count) * std::pow(kBest * sample.spacing_m / mask_m, 2.0);
        whole += fmt::format(", and 0.6 to 0.8 is right: set mask_radius = {:.2g}, or points = {:.0f}",
                             kBest * sample.spacing_m,
                             std::clamp(std::round(points), double{kFewestPoints}, double{kMostPoints}));
    }
    return whole;
}

}  // namespace haptable
