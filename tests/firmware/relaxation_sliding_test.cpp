// SPDX-License-Identifier: GPL-2.0-or-later
// A relaxing body that a finger slides over: the servo, whose history goes with the contact, against the whole body's
// viscoelastic solution, whose history stays where it was.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "codegen/in_memory.hpp"
#include "codegen/laws.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kRadius_m = 0.005, kDent_m = 0.002;

/// K(t) = g(t) K on the nodes of the surface, exactly: e = K u are the loads that would deform the body so at once, and
/// of a tick in which they go straight, f = rest e + sum share_k h_k with h_k <- h_k + rise_k de - fall_k h_k. What a
/// mask w is moved by, w . L e, is the finger's.
class WholeBody {
public:
    WholeBody(const ElasticBody& body, const RelaxationTerm& term)
        : body_(body),
          term_(term),
          tick_(relaxation_of_tick(term)),
          at_once_(VectorXd::Zero(body.compliance().rows())),
          branch_(at_once_) {}

    /// The force at a point of the top, N, that is u_m deep.
    Vector3d to(double x, double y, const Vector3d& u_m) {
        Vector3d alpha;
        const int patch = body_.patch_over(x, y, alpha);
        const VectorXd weight = body_.weights(patch, alpha);
        const double left = 1.0 - term_.share + term_.share * tick_.rise;
        const VectorXd past = term_.share * ((1.0 - tick_.fall) * branch_ - tick_.rise * at_once_);
        const Vector3d moved = gather(weight, body_.compliance() * past);
        const Vector3d force = compliance(weight).ldlt().solve(left * u_m + moved);
        VectorXd next = -past;
        for (Eigen::Index node = 0; node < weight.size(); ++node) next.segment<3>(3 * node) += weight[node] * force;
        next /= left;
        branch_ += tick_.rise * (next - at_once_) - tick_.fall * branch_;
        at_once_ = next;
        return -force;
    }

private:
    static Vector3d gather(const VectorXd& weight, const VectorXd& u) {
        Vector3d sum = Vector3d::Zero();
        for (Eigen::Index node = 0; node < weight.size(); ++node) sum += weight[node] * u.segment<3>(3 * node);
        return sum;
    }
    Matrix3d compliance(const VectorXd& weight) const {
        Matrix3d c = Matrix3d::Zero();
        for (Eigen::Index a = 0; a < weight.size(); ++a)
            for (Eigen::Index b = 0; b < weight.size(); ++b)
                if (weight[a] != 0.0 && weight[b] != 0.0)
                    c += weight[a] * weight[b] * body_.compliance().block<3, 3>(3 * a, 3 * b);
        return 0.5 * (c + c.transpose());
    }

    const ElasticBody& body_;
    RelaxationTerm term_;
    TickRelaxation tick_;
    VectorXd at_once_, branch_;
};

struct Slid {
    double fixed = 0.0;  ///< largest difference of the normal force before the slide, as a part of it
    double sliding = 0.0;
};

/// Pressed for `hold_s`, then 10 mm along the top.
Slid slide(const ElasticBody& body, const RelaxationTerm& term, double speed, double hold_s) {
    Tables tables = body.tables();
    tables.relaxation = {term};
    tables.limits = {};
    const ServoModel servo_model = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo_model);
    Finger finger(model);
    WholeBody whole(body, term);
    Slid slid;
    const double y = 0.0152;
    const int press = 20, hold = press + static_cast<int>(hold_s / kTick_s);
    const int end = hold + static_cast<int>(0.01 / (speed * kTick_s));
    finger.to({0.01, y, kTop_m + 1e-5});
    for (int tick = 1; tick <= end; ++tick) {
        const double x = 0.01 + std::max(0, tick - hold) * speed * kTick_s;
        const double depth_m = kDent_m * std::min(1.0, double(tick) / press);
        finger.to({x, y, kTop_m - depth_m});
        const Vector3d force =
            whole.to(finger.god().x(), finger.god().y(), {0.0, 0.0, finger.at().z() - finger.god().z()});
        double& worst = tick > hold ? slid.sliding : slid.fixed;
        worst = std::max(worst, std::abs(finger.force().z() - force.z()) / force.z());
    }
    return slid;
}

// Printed: docs/MATERIALS.md has the table. A slow slide has relaxed where it is; a fast one comes to what was never
// pressed.
TEST(SlidingOverARelaxingBody, IsExactAtAFixedContactAndErrsByTheHistoryThatStaysBehind) {
    const ElasticBody body(cube_scene(9, 0.3, true), ForceLaw::kPressureMask, kRadius_m);
    printf("speed x time / radius: largest error of the force after a long press, after a short one\n");
    double before = 0.0;
    for (const auto& [speed, time_s] :
         {std::pair{0.005, 0.01}, {0.005, 0.03}, {0.02, 0.03}, {0.02, 0.1}, {0.1, 0.1}, {0.1, 0.5}, {0.2, 2.0}}) {
        const RelaxationTerm term{0.5, time_s};
        const Slid after_long = slide(body, term, speed, 8.0 * time_s), after_short = slide(body, term, speed, 0.0);
        const double ratio = speed * time_s / kRadius_m;
        printf("%8.3g  %8.2g  %8.2g\n", ratio, after_long.sliding, after_short.sliding);
        EXPECT_LT(after_long.fixed, 1e-3) << "the blocks of the mask's quadratic, and float";
        EXPECT_GT(after_long.sliding, 0.8 * before) << "grows with the speed";
        EXPECT_LT(after_long.sliding, 0.51) << "it is never more than what has relaxed";
        EXPECT_LT(after_long.sliding, ratio < 0.02 ? 0.05 : 1.0);
        before = after_long.sliding;
    }
}

/// Energy given to the finger by one loop: down at the top's middle, aside at constant depth, up. J.
double loop(const haptable_model& model, int ticks, bool backwards) {
    Finger finger(model);
    const Vector3d over(0.015, 0.015, 0.0301), in(0.015, 0.015, 0.028), aside(0.020, 0.021, 0.028),
        up(0.020, 0.021, 0.0301);
    std::vector<Vector3d> corner = {over, in, aside, up, over};
    if (backwards) std::reverse(corner.begin(), corner.end());
    double given_j = 0.0;
    finger.to(corner[0]);
    for (std::size_t leg = 1; leg < corner.size(); ++leg)
        for (int tick = 1; tick <= ticks; ++tick) {
            const Vector3d from = finger.at(), force = finger.force();
            finger.to(corner[leg - 1] + (corner[leg] - corner[leg - 1]) * tick / ticks);
            given_j += 0.5 * (force + finger.force()).dot(finger.at() - from);
        }
    return given_j;
}

// Pressed as slowly as the body relaxes, faster and slower: with least energy no loop gives any, in either sense.
TEST(SlidingOverARelaxingBody, LoopsWithLeastEnergyGiveNothing) {
    for (const ForceLaw force : every<ForceLaw>()) {
        const ElasticBody body(cube_scene(5, 0.3), force, force == ForceLaw::kPressureMask ? 0.012 : 0.0);
        for (const double time_s : {1e-3, 0.03, 0.3, 1000.0}) {
            Tables tables = body.tables();
            tables.relaxation = {{0.3, time_s}, {0.3, 5.0 * time_s}};
            tables.limits = {};
            const auto most_j = [&](GodObject god_object) {
                tables.god_object = god_object;
                const ServoModel servo_model = build_model(tables);
                const haptable_model model = model_in_memory(tables, servo_model);
                return std::max(loop(model, 1000, false), loop(model, 1000, true));
            };
            EXPECT_LT(most_j(GodObject::kLeastEnergy), 0.0) << force << ", " << time_s << " s";
            if (time_s < 0.01) {
                EXPECT_GT(most_j(GodObject::kNearest), 0.0) << "the loop is one that gives where nothing is stored";
            }
        }
    }
}

}  // namespace
}  // namespace haptable::test
