// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/small_strain.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "host/body/assembly.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Unknowns = std::span<const std::int32_t>;

constexpr std::size_t kPressed = 5;  // odd: a median is one of them
constexpr std::size_t kWays = 3;     // that are solved for: along the normal, and two along the surface

/// Inward, and two ways along the surface.
Matrix3d ways_of(const Vector3d& outward) {
    Matrix3d ways;
    ways << -outward, outward.unitOrthogonal(), outward.cross(outward.unitOrthogonal());
    return ways;
}

/// Area-weighted normals of the touchable patches at a node.
Vector3d outward_at(const Body& body, std::int32_t node) {
    const auto at = [&](std::int32_t i) { return body.mesh.position_m[static_cast<std::size_t>(i)]; };
    Vector3d normal = Vector3d::Zero();
    for (const Patch& p : body.touch_patch)
        if (std::find(p.begin(), p.end(), node) != p.end()) normal += (at(p[1]) - at(p[0])).cross(at(p[2]) - at(p[0]));
    return normal.normalized();
}

double median_depth(std::span<const Departure> all) {
    std::vector<double> depth;
    for (const Departure& one : all) depth.push_back(one.depth_m(SmallStrain::kShare));
    const auto middle = depth.begin() + static_cast<std::ptrdiff_t>(depth.size() / 2);
    std::nth_element(depth.begin(), middle, depth.end());
    return *middle;
}

/// The worst of the four departures of each finger.
std::vector<Departure> worst_of_four(const std::vector<Departure>& sideways) {
    std::vector<Departure> worst;
    for (auto four = sideways.begin(); four != sideways.end(); four += 4)
        worst.push_back(*std::min_element(four, four + 4, [](const Departure& x, const Departure& y) {
            return x.depth_m(SmallStrain::kShare) < y.depth_m(SmallStrain::kShare);
        }));
    return worst;
}

}  // namespace

FingerLoad finger_at(const Body& body, const Masks& masks, std::int32_t node) {
    NodeWeights load{{node}, {1.0}};
    if (!masks.vertex.empty()) {
        const auto at = std::lower_bound(masks.vertex_id.begin(), masks.vertex_id.end(), node);
        load = masks.vertex[static_cast<std::size_t>(at - masks.vertex_id.begin())];
    }
    return {load, outward_at(body, node), node};
}

std::vector<FingerLoad> fingers_on(const Body& body, const Masks& masks) {
    std::vector<FingerLoad> fingers;
    const std::size_t count = std::min(kPressed, body.touch_node.size());
    for (std::size_t k = 0; k < count; ++k)
        fingers.push_back(finger_at(body, masks, body.touch_node[(2 * k + 1) * body.touch_node.size() / (2 * count)]));
    return fingers;
}

Matrix3d stiffness_under(const NodeWeights& load, const LinearSolver& solver, Unknowns unknown) {
    const MatrixXd w = load_matrix(load, unknown, solver.size());
    MatrixXd x;
    solver.solve(w, x);
    return Matrix3d(transposed_product(w, x)).inverse();
}

double Departure::depth_m(double share) const {
    double least = std::numeric_limits<double>::infinity();
    // b t^2 + a t +- share = 0, in the form that keeps its digits.
    for (const double off : {share, -share}) {
        const double discriminant = a_per_m * a_per_m - 4.0 * b_per_m2 * off;
        if (discriminant < 0.0) continue;
        for (const double root : {std::sqrt(discriminant), -std::sqrt(discriminant)})
            if (const double t = -2.0 * off / (a_per_m + root); t > 0.0) least = std::min(least, t);
    }
    return least;
}

Departures departures(const NeoHooke& body, const LinearSolver& solver, Unknowns unknown,
                      std::span<const FingerLoad> fingers) {
    Departures result;
    const Index size = solver.size();
    for (const FingerLoad& finger : fingers) {
        const MatrixXd w = load_matrix(finger.load, unknown, size);
        MatrixXd x, v;
        solver.solve(w, x);
        const Matrix3d stiffness = Matrix3d(transposed_product(w, x)).inverse(), ways = ways_of(finger.outward);
        const MatrixXd phi = x * stiffness * ways;
        MatrixXd second(size, kWays), third(size, kWays);
        for (Index way = 0; way < Index{kWays}; ++way) {
            const ForceOrders f = body.force_orders(spread(phi.col(way), unknown));
            second.col(way) = gather(f.force_n[1], unknown, size);
            third.col(way) = gather(f.force_n[2], unknown, size);
        }
        solver.solve(second, v);
        v = product(x * stiffness, transposed_product(w, v)) - v;
        for (Index way = 0; way < Index{kWays}; ++way) {
            const double s = ways.col(way).dot(stiffness * ways.col(way));
            const double a = phi.col(way).dot(second.col(way)) / s;
            const double b = (phi.col(way).dot(third.col(way)) + 2.0 * v.col(way).dot(second.col(way))) / s;
            result[static_cast<std::size_t>(way == 0 ? Way::kPressing : Way::kSideways)].push_back({a, b});
            result[static_cast<std::size_t>(way == 0 ? Way::kPulling : Way::kSideways)].push_back({-a, b});
        }
    }
    return result;
}

std::optional<SmallStrain> find_small_strain(const Scene& scene, const Body& body, const Masks& masks,
                                             const LinearSolver& solver) {
    const bool has_skin = std::any_of(body.layered.begin(), body.layered.end(),
                                      [](const LayeredFace& face) { return face.layer.has_membrane(); });
    // A neo-Hookean body is isotropic, has no skin and is not loaded before it is touched.
    if (!body.axes.empty() || has_skin || (scene.gravity && scene.gravity->prestress)) return {};
    const std::vector<Lame> material = materials_of(scene, body);
    const NeoHooke neo_hooke({scene.mesh.element, body.mesh.position_m, body.mesh.tet, material, body.mesh.middle});
    const std::vector<FingerLoad> fingers = fingers_on(body, masks);
    const auto [pressing, pulling, sideways] = departures(neo_hooke, solver, body.unknown, fingers);
    const SmallStrain found{scene.contact.mask_radius_m, fingers.size(), median_depth(pressing), median_depth(pulling),
                            median_depth(worst_of_four(sideways))};
    if (!std::isfinite(found.pressing_m + found.pulling_m + found.sideways_m)) return {};
    return found;
}

}  // namespace haptable
