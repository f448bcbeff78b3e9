// SPDX-License-Identifier: GPL-2.0-or-later
// The point of a triangle nearest to another: C. Ericson, Real-Time Collision Detection, 2005, 5.1.5.
#include "host/device/touchable.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "host/base/error.hpp"
#include "host/tables/folder.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

Corners corners_of(const Touchable& body, const std::array<std::int32_t, 3>& patch) {
    Corners x;
    for (std::size_t c = 0; c < 3; ++c) x[c] = body.position_m[static_cast<std::size_t>(patch[c])];
    return x;
}

Vector3d normal_of(const Corners& x) { return (x[1] - x[0]).cross(x[2] - x[0]).normalized(); }

Eigen::AlignedBox3d box_of(const Touchable& body) {
    Eigen::AlignedBox3d box;
    for (const auto& patch : body.patch)
        for (const Vector3d& x : corners_of(body, patch)) box.extend(x);
    return box;
}

/// The height of a patch that is seen from above, over (x, y); nothing beside it.
std::optional<double> height_over(const Corners& x, const Vector3d& over) {
    const auto twice_area = [&](const Vector3d& a, const Vector3d& b) {
        return (a.x() - over.x()) * (b.y() - over.y()) - (a.y() - over.y()) * (b.x() - over.x());
    };
    const Vector3d area(twice_area(x[1], x[2]), twice_area(x[2], x[0]), twice_area(x[0], x[1]));
    if (!(area.sum() > 0.0) || area.minCoeff() < 0.0) return {};
    return (area[0] * x[0].z() + area[1] * x[1].z() + area[2] * x[2].z()) / area.sum();
}

Vector3d nearest_on_segment(const Vector3d& a, const Vector3d& b, const Vector3d& to) {
    const double length2 = (b - a).squaredNorm();
    const double share = length2 > 0.0 ? std::clamp((to - a).dot(b - a) / length2, 0.0, 1.0) : 0.0;
    return a + share * (b - a);
}

Vector3d nearest_on(const Corners& x, const Vector3d& to) {
    const Vector3d n = (x[1] - x[0]).cross(x[2] - x[0]);
    bool inside = n.squaredNorm() > 0.0;
    for (std::size_t c = 0; c < 3 && inside; ++c) inside = (x[(c + 1) % 3] - x[c]).cross(to - x[c]).dot(n) >= 0.0;
    if (inside) return to - (to - x[0]).dot(n) / n.squaredNorm() * n;
    Vector3d best = nearest_on_segment(x[2], x[0], to);
    for (std::size_t c = 0; c < 2; ++c)
        if (const Vector3d p = nearest_on_segment(x[c], x[c + 1], to); (p - to).norm() < (best - to).norm()) best = p;
    return best;
}

TouchPlace nearest_to(const Touchable& body, const Vector3d& middle_m) {
    TouchPlace place{middle_m, -Vector3d::UnitZ()};
    double least_m = std::numeric_limits<double>::infinity();
    for (const auto& patch : body.patch) {
        const Corners x = corners_of(body, patch);
        const Vector3d at_m = nearest_on(x, middle_m), normal = normal_of(x);
        if (!normal.allFinite() || (at_m - middle_m).norm() >= least_m) continue;
        least_m = (at_m - middle_m).norm();
        place = {at_m, -normal};
    }
    return place;
}

}  // namespace

Touchable read_touchable(const std::filesystem::path& folder) {
    const Array<double> position = read_npy<double>(folder / "position.npy");
    const Array<std::int32_t> patch = read_npy<std::int32_t>(folder / "patch.npy");
    const auto fail = [&](const char* file) {
        throw Error((folder / file).string() + ": does not fit the other tables: make them again");
    };
    if (position.shape.size() != 2 || position.shape[1] != 3) fail("position.npy");
    if (patch.shape.size() != 2 || patch.shape[1] != 3 || patch.values.empty()) fail("patch.npy");
    Touchable body;
    for (std::size_t i = 0; i < position.values.size(); i += 3) body.position_m.emplace_back(&position.values[i]);
    for (std::size_t i = 0; i < patch.values.size(); i += 3)
        body.patch.push_back({patch.values[i], patch.values[i + 1], patch.values[i + 2]});
    for (const std::int32_t node : patch.values)
        if (node < 0 || static_cast<std::size_t>(node) >= body.position_m.size()) fail("patch.npy");
    return body;
}

std::int64_t tables_hash_in(const std::filesystem::path& folder) {
    if (!std::filesystem::exists(folder / "tables.json")) return 0;
    return static_cast<std::int64_t>(TablesFolder(folder).tables_hash());
}

TouchPlace top_of(const Touchable& body) {
    const Eigen::AlignedBox3d box = box_of(body);
    const Vector3d middle_m(box.center().x(), box.center().y(), box.max().z());
    std::optional<double> highest_m;
    for (const auto& patch : body.patch)
        if (const auto z = height_over(corners_of(body, patch), middle_m); z && (!highest_m || *z > *highest_m))
            highest_m = z;
    if (highest_m) return {{middle_m.x(), middle_m.y(), *highest_m}, {0.0, 0.0, -1.0}, true};
    return nearest_to(body, middle_m);
}

std::vector<TouchPlace> sides_of(const Touchable& body, std::size_t count) {
    const Eigen::AlignedBox3d box = box_of(body);
    const double first = box.sizes().x() <= box.sizes().y() ? std::numbers::pi : -0.5 * std::numbers::pi;
    std::vector<TouchPlace> places;
    for (std::size_t side = 0; side < count; ++side) {
        const double angle = first + 2.0 * std::numbers::pi * static_cast<double>(side) / static_cast<double>(count);
        // A side's own middle to the last bit, where an angle is a right one.
        const auto whole = [](double x) { return std::abs(x) < 1e-12 ? 0.0 : x; };
        const Vector3d out(whole(std::cos(angle)), whole(std::sin(angle)), 0.0);
        Vector3d middle_m = box.center() + 0.5 * box.sizes().cwiseProduct(out);
        middle_m.z() = box.min().z() + 2.0 / 3.0 * box.sizes().z();
        places.push_back(nearest_to(body, middle_m));
        if (places.back().direction.dot(-out) >= 0.5) places.back().direction = -out;
    }
    return places;
}

std::string where_it_is(const Touchable& body) {
    const Eigen::AlignedBox3d box = box_of(body);
    return fmt::format("the touchable surface lies in ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g}) m",
                       box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

}  // namespace haptable
