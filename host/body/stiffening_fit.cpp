// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/stiffening_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/body/indentation.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int kDepths = 8;             // of each way
constexpr double kDeepest = 0.3;       // of the body's least extent, where it is as stiff as at the median place
constexpr double kEvaluations = 20.0;  // of W and its gradient that a dent takes, about
constexpr double kLeastTangent = 0.1;  // of the linear stiffness: a dent that gave way would be none

double least_extent_m(const Body& body) {
    Vector3d low = body.mesh.position_m.front(), high = low;
    for (const Vector3d& x : body.mesh.position_m) {
        low = low.cwiseMin(x);
        high = high.cwiseMax(x);
    }
    return (high - low).minCoeff();
}

/// What the dents will take, by one step of each of the two: W, and a solve.
double expected_s(const Hyperelastic& hyper, const LinearSolver& solver, std::size_t nodes, std::size_t dents) {
    const auto begin = std::chrono::steady_clock::now();
    Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, static_cast<Index>(nodes)), f;
    hyper.energy(u, f);
    Eigen::MatrixXd x;
    solver.solve(Eigen::MatrixXd::Zero(solver.size(), 1), x);
    const std::chrono::duration<double> once = std::chrono::steady_clock::now() - begin;
    return kEvaluations * once.count() * static_cast<double>(dents);
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// By their place in kDentWays. A god-object that is not held and knows no friction goes to where the finger presses.
std::array<bool, 4> ways_of(const ContactOptions& contact) {
    const bool sticks = contact.static_friction > 0.0 || contact.grab;
    return {true, sticks || contact.god_object == GodObject::kLeastEnergy, sticks, contact.grab};
}

std::array<Vector3d, 4> directions(const Vector3d& outward) {
    const Vector3d along = outward.unitOrthogonal();
    return {-outward, (along - outward).normalized(), along, outward};
}

/// A row of Psi' - 1 by c, for `terms` of them.
Eigen::RowVectorXd powers(double s, Index terms) {
    Eigen::RowVectorXd row(terms);
    for (Index k = 0; k < terms; ++k) row[k] = std::pow(s, static_cast<double>(k + 1));
    return row;
}

DentErrors errors_of(const std::vector<Dent>& dents, const StiffeningCurve& curve, const auto& is_of) {
    DentErrors errors;
    double sum = 0.0, linear = 0.0;
    for (const Dent& dent : dents) {
        if (!is_of(dent)) continue;
        const double error = dent.error(curve.factor(dent.linear_j));
        ++errors.dents;
        sum += error * error;
        linear += std::pow(dent.error(1.0), 2);
        errors.worst = std::max(errors.worst, error);
        errors.depth_m = std::max(errors.depth_m, dent.depth_m);
    }
    const double count = std::max(1.0, static_cast<double>(errors.dents));
    errors.rms = std::sqrt(sum / count);
    errors.linear_rms = std::sqrt(linear / count);
    return errors;
}

/// How deep the force is within the share at one place and way. Dents are in order of depth.
double good_depth_m(const std::vector<Dent>& dents, std::size_t place, std::size_t way, const StiffeningCurve& curve) {
    double depth_m = 0.0, before = 0.0;
    for (const Dent& dent : dents) {
        if (dent.place != place || dent.way != way) continue;
        const double error = dent.error(curve.factor(dent.linear_j));
        if (error > SmallStrain::kShare)
            return depth_m + (dent.depth_m - depth_m) * (SmallStrain::kShare - before) / (error - before);
        depth_m = dent.depth_m;
        before = error;
    }
    return depth_m;
}

}  // namespace

double Dent::error(double p) const { return std::hypot(p - factor, across) / std::hypot(factor, across); }

StiffeningCurve fit_curve(const std::vector<Dent>& dents, const std::array<bool, 4>& is_fitted) {
    StiffeningCurve curve;
    std::vector<const Dent*> used;
    for (const Dent& dent : dents)
        if (is_fitted[dent.way]) used.push_back(&dent);
    for (const Dent* dent : used) curve.energy_j = std::max(curve.energy_j, dent->linear_j);
    if (!(curve.energy_j > 0.0)) throw Error("no dent of the body came to rest");
    for (Index terms = std::min<Index>(3, std::ssize(used)); terms > 0; --terms) {
        Eigen::MatrixXd a(std::ssize(used), terms);
        Eigen::VectorXd b(std::ssize(used));
        for (Index i = 0; i < a.rows(); ++i) {
            const Dent& dent = *used[static_cast<std::size_t>(i)];
            const double weight = 1.0 / std::hypot(dent.factor, dent.across);
            a.row(i) = weight * powers(std::sqrt(dent.linear_j / curve.energy_j), terms);
            b[i] = weight * (dent.factor - 1.0);
        }
        const Eigen::VectorXd c = least_squares(a, b);
        curve.c = {};
        std::copy(c.begin(), c.end(), curve.c.begin());
        if (curve.least_tangent() >= kLeastTangent) return curve;
    }
    const double part = (1.0 - kLeastTangent) / (1.0 - curve.least_tangent());  // both are linear in c
    for (double& c : curve.c) c *= part;
    return curve;
}

StiffeningFit fit_stiffening(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver,
                             Progress& progress) try {
    const std::vector<Lame> material = materials_of(scene, body);
    const Hyperelastic hyper({scene.mesh.element, body.mesh.position_m, body.mesh.tet, material, body.mesh.middle},
                             *scene.material.stiffening);
    const double deepest_m = kDeepest * least_extent_m(body);
    const std::vector<FingerLoad> fingers = fingers_on(body, masks);
    StiffeningFit fit;
    std::vector<Indentation> presses;
    for (const FingerLoad& finger : fingers) {
        const Indentation& press = presses.emplace_back(hyper, solver, body.unknown, finger.load);
        fit.pressed_n_per_m.push_back((press.stiffness_n_per_m() * finger.outward).norm());
    }
    const double most_n = std::min(servo_force_limit_n(scene), deepest_m * median(fit.pressed_n_per_m));
    std::vector<Dent> dents;
    const std::size_t all = fingers.size() * kDentWays.size() * kDepths;
    progress.stage(fmt::format("{} dents, about {:.0f} s", all, expected_s(hyper, solver, body.unknown.size(), all)));
    for (std::size_t place = 0; place < fingers.size(); ++place) {
        const std::array<Vector3d, 4> ways = directions(fingers[place].outward);
        for (std::size_t way = 0; way < ways.size(); ++way) {
            Indentation dent = presses[place];
            const Vector3d linear_n_per_m = dent.stiffness_n_per_m() * ways[way];
            const double reach_m = std::min(deepest_m, most_n / linear_n_per_m.norm());
            for (int step = 1; step <= kDepths; ++step) {
                const std::size_t done = (place * kDentWays.size() + way) * kDepths + static_cast<std::size_t>(step);
                progress.done(static_cast<double>(done) / static_cast<double>(all),
                              fmt::format("dent {} of {}", done, all));
                const double depth_m = reach_m * step / kDepths;
                const std::optional<Vector3d> force_n = dent.force_n(depth_m * ways[way]);
                if (!force_n) break;
                const Vector3d linear_n = depth_m * linear_n_per_m;
                const double factor = force_n->dot(linear_n) / linear_n.squaredNorm();
                dents.push_back({place, way, depth_m, 0.5 * depth_m * ways[way].dot(linear_n), factor,
                                 (*force_n - factor * linear_n).norm() / linear_n.norm()});
            }
        }
        fit.node.push_back(fingers[place].node);
    }
    fit.is_fitted = ways_of(scene.contact);
    fit.curve = fit_curve(dents, fit.is_fitted);
    const auto is_fitted = [&](const Dent& dent) { return fit.is_fitted[dent.way]; };
    fit.fitted = errors_of(dents, fit.curve, is_fitted);
    for (std::size_t way = 0; way < kDentWays.size(); ++way)
        fit.by_way[way] = errors_of(dents, fit.curve, [&](const Dent& dent) { return dent.way == way; });
    std::array<std::vector<double>, 4> good_m;  // by way: of each place
    for (std::size_t place = 0; place < fingers.size(); ++place) {
        fit.by_place.push_back(
            errors_of(dents, fit.curve, [&](const Dent& dent) { return dent.place == place && is_fitted(dent); }));
        fit.good_m.push_back(fit.by_place.back().depth_m);
        for (std::size_t way = 0; way < kDentWays.size(); ++way) {
            good_m[way].push_back(good_depth_m(dents, place, way, fit.curve));
            if (fit.is_fitted[way]) fit.good_m.back() = std::min(fit.good_m.back(), good_m[way].back());
        }
    }
    fit.good = {scene.contact.mask_radius_m, fingers.size(), median(good_m[0]), median(good_m[3]), median(good_m[2])};
    return fit;
} catch (const Error& error) {
    throw Error(fmt::format("{}: material.stiffening: {}: make the mesh finer, or choose force = \"pressure-mask\"",
                            scene.file.string(), error.what()));
}

StiffeningFit fit_press(const Scene& scene, const Body& body, const Masks& masks, const LinearSolver& solver) {
    const RecordedPress& press = *scene.material.stiffening->press;
    const Vector3d at = Eigen::Map<const Vector3d>(press.at_m.data());
    const auto x = [&](std::int32_t node) -> const Vector3d& {
        return body.mesh.position_m[static_cast<std::size_t>(node)];
    };
    const auto from = [&](std::int32_t node) { return (x(node) - at).norm(); };
    const std::int32_t node = *std::min_element(body.touch_node.begin(), body.touch_node.end(),
                                                [&](auto a, auto b) { return from(a) < from(b); });
    double edge_m = 0.0;
    for (const Patch& p : body.touch_patch)
        if (std::find(p.begin(), p.end(), node) != p.end())
            for (const std::int32_t other : p) edge_m = std::max(edge_m, (x(other) - x(node)).norm());
    if (from(node) > edge_m)
        throw Error(fmt::format(
            "{}: material.stiffening.at: [{:g}, {:g}, {:g}] is {:.3g} m from the touchable surface, "
            "whose nearest node {} is at [{:g}, {:g}, {:g}] m",
            scene.file.string(), at.x(), at.y(), at.z(), from(node), node, x(node).x(), x(node).y(), x(node).z()));
    const FingerLoad finger = finger_at(body, masks, node);
    const double own_n_per_m = finger.outward.dot(stiffness_under(finger.load, solver, body.unknown) * finger.outward);
    StiffeningFit fit;
    fit.curve = scene.material.stiffening->curve;
    fit.curve.energy_j = 0.5 * own_n_per_m * press.depth_m * press.depth_m;
    fit.pressed = {node, own_n_per_m};
    return fit;
}

}  // namespace haptable
