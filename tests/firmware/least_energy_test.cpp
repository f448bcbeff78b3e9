// SPDX-License-Identifier: GPL-2.0-or-later
// The least-energy god-object: derivatives, minima, and what closed loops give.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "firmware/haptable_bounds.h"
#include "tests/bodies.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/reference_servo.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(LeastEnergy, SlopeAndCurvatureAreTheEnergysDerivatives) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(cube_scene(5, 0.3), force, 0.01);
        const ReferenceServo servo(body.model(GodObject::kLeastEnergy));
        std::mt19937 random(3);
        std::uniform_int_distribution<int> any(0, body.patches() - 1);
        for (int i = 0; i < 300; ++i) {
            const int patch = any(random);
            const Vector3d alpha = random_alpha(random);
            const Vector3d x = body.point(patch, alpha) - 0.002 * body.normal(patch) + 3e-4 * random_alpha(random);
            const auto at = [&](double b, double c) { return servo.energy(patch, alpha + Vector3d(-b - c, b, c), x); };
            const auto e = at(0, 0);
            const double h = 1e-5;
            const Vector2d gradient((at(h, 0).energy - at(-h, 0).energy) / (2 * h),
                                    (at(0, h).energy - at(0, -h).energy) / (2 * h));
            Eigen::Matrix2d hessian;
            hessian.col(0) = (at(h, 0).gradient - at(-h, 0).gradient) / (2 * h);
            hessian.col(1) = (at(0, h).gradient - at(0, -h).gradient) / (2 * h);
            // An error of second order in h, times third derivatives over a patch of 4 times u; and roundings of E / h.
            const Bound differences{.count = 100.0 * 4.0 * 4.0 * 4.0, .epsilon = h * h};
            EXPECT_WITHIN((gradient - e.gradient).norm() / (e.gradient.norm() + e.energy), differences) << force;
            EXPECT_WITHIN((hessian - e.hessian).norm() / (e.hessian.norm() + e.energy), differences) << force;
            EXPECT_GT(e.gauss_newton.determinant(), 0.0);
        }
    }
}

haptable_energy energy_at(const haptable_model& model, const haptable_contact& contact, const Vector3d& x,
                          haptable_energy_terms terms, const Vector3d& load = Vector3d::Zero()) {
    haptable_energy e{};
    for (int c = 0; c < 3; ++c) e.load_n[c] = float(load[c]);
    model.energy(&model, &contact, Eigen::Vector3f(x.cast<float>()).data(), terms, &e);
    return e;
}

/// Largest over least stiffness at a contact.
double condition_at(const haptable_model& model, const haptable_contact& contact) {
    Eigen::Matrix3d s;
    for (int c = 0; c < 3; ++c)
        s.col(c) = to_vector(
            energy_at(model, contact, to_vector(contact.god_object_m) + 1e-3 * Vector3d::Unit(c), HAPTABLE_ENERGY_LOAD)
                .load_n);
    const Vector3d k =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(s + s.transpose(), Eigen::EigenvaluesOnly).eigenvalues();
    return k[2] / k[0];
}

void expect_the_same(const ElasticBody& body, const haptable_contact& contact, const Vector3d& x) {
    const haptable_model model = body.model(GodObject::kLeastEnergy);
    const haptable_energy all = energy_at(model, contact, x, HAPTABLE_ENERGY_ALL);
    const Vector3d load = to_vector(all.load_n);
    const haptable_energy slope = energy_at(model, contact, x, HAPTABLE_ENERGY_SLOPE);
    const haptable_energy short_one = energy_at(model, contact, x, HAPTABLE_ENERGY_LOAD);
    const haptable_energy gradient = energy_at(model, contact, x, HAPTABLE_ENERGY_GRADIENT, load);
    // Sums of up to 15 blocks in another order, and three steps of elimination; a gradient is of loads times edges.
    const double condition = condition_at(model, contact), edge_m = body.size();
    const Bound rounded{.count = 64, .epsilon = kFloat, .condition = condition, .size = load.norm()};
    for (const haptable_energy* less : {&slope, &short_one}) {
        EXPECT_WITHIN((to_vector(less->load_n) - load).norm(), rounded);
        EXPECT_WITHIN(std::abs(double(less->energy_j) - double(all.energy_j)),
                      rounded.times(double(all.energy_j) / load.norm()));
    }
    for (const haptable_energy* less : {&slope, &gradient})
        for (int b = 0; b < 2; ++b)
            EXPECT_WITHIN(std::abs(double(less->gradient_j[b]) - double(all.gradient_j[b])), rounded.times(edge_m));
}

// Within patches, on edges and vertices, of free and of fixed nodes, the parts of an energy are those of all of it.
TEST(LeastEnergy, WhatIsAskedForAloneIsTheSame) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(cube_scene(5, 0.3), force, 0.01);
        std::mt19937 random(4);
        std::uniform_int_distribution<int> any(0, body.patches() - 1);
        for (int i = 0; i < 300; ++i) {
            const int patch = any(random);
            Vector3d alpha = random_alpha(random);
            for (int zero = 0; zero < i % 3; ++zero) alpha[(i / 3 + zero) % 3] = 0.0;
            alpha /= alpha.sum();
            const Vector3d x = body.point(patch, alpha) - 0.002 * body.normal(patch) + 3e-4 * random_alpha(random);
            SCOPED_TRACE(testing::Message() << word(force) << " " << i);
            expect_the_same(body, contact_at(body, patch, alpha), x);
        }
    }
}

/// The work of a clamped force is another matter.
haptable_model unclamped(haptable_model model) {
    model.max_force_n = 1e6F;
    return model;
}

struct Loops {
    double worst = -1.0;  // largest part of the most that was stored that the user was given
    std::uint32_t most_steps = 0;
};

/// In along a patch's normal, straight to under another point, out along the normal there and back above the first.
Loops run_loops(const ElasticBody& body, GodObject god_object, int count, double deep_m, double wide_m) {
    Finger finger(unclamped(body.model(god_object)));
    std::mt19937 random(11);
    std::uniform_int_distribution<int> any(0, body.patches() - 1);
    std::uniform_real_distribution<double> uniform(0.3, 1.0);
    Loops result;
    for (int loops = 0; loops < count;) {
        const int patch = any(random);
        bool free = true;
        for (int c = 0; c < 3; ++c) free &= body.is_free(body.vertex(patch, c));
        if (!free) continue;
        const Vector3d start = body.point(patch, random_alpha(random)), n = body.normal(patch);
        const Vector3d side = n.unitOrthogonal();
        const double angle = 6.28 * uniform(random);
        const Vector3d way = std::cos(angle) * side + std::sin(angle) * n.cross(side);
        const double depth = deep_m * uniform(random), width = wide_m * uniform(random);
        const Vector3d above = start + 0.001 * n, in = start - depth * n, across = in + width * way;
        const Vector3d corner[] = {above, in, across, across + (depth + 0.02) * n, above};
        Work work;
        double deepest = 0.0;
        finger.begin();
        for (int leg = 1; leg < 5; ++leg) {
            const Vector3d from = corner[leg - 1], to = corner[leg];
            walk({from, to}, std::max(1, int((to - from).norm() / 1e-5)), [&](const Vector3d& x) {
                finger.to(x);
                work.add(finger.at(), finger.force());
                deepest = std::max(deepest, finger.energy());
            });
        }
        if (deepest <= 0.0) continue;
        ++loops;
        result.worst = std::max(result.worst, work.given_j / deepest);
    }
    result.most_steps = finger.counters().most_energies;
    return result;
}

void expect_passive(const ElasticBody& body, int count, double deep_m, double wide_m) {
    const Loops least = run_loops(body, GodObject::kLeastEnergy, count, deep_m, wide_m);
    const Loops nearest = run_loops(body, GodObject::kNearest, count, deep_m, wide_m);
    EXPECT_WITHIN(least.worst, .epsilon = 1e-3) << body.name() << " " << body.tables().force;
    EXPECT_GT(nearest.worst, 0.02) << "the loops must be able to show it";
    EXPECT_LE(least.most_steps, std::uint32_t{MOST_ENERGIES});
}

TEST(LeastEnergy, ClosedLoopsGiveNothing) {
    for (const ForceLaw force : kForces) {
        for (double poisson : {0.3, 0.49}) expect_passive({cube_scene(5, poisson), force, 0.008}, 1000, 0.003, 0.006);
        expect_passive({mouse_scene(true), force, 0.006}, 1000, 0.003, 0.006);
    }
}

// One edge of a vertex of more patches than a tick has steps leads down, to where the body is soft, so that a tick's
// steps may end before it is looked at: the search leaves steps to go, or goes on at the next tick.
TEST(LeastEnergy, FindsTheOneWayDownFromAVertexOfManyPatches) {
    constexpr int kSides = 31;
    const TestModel tip(spindle_shape(kSides, 0.02, 0.03), -1e9, GodObject::kLeastEnergy);
    for (int soft = 0; soft < kSides; ++soft) {
        std::vector<std::array<float, 6>> blocks(tip.servo().free_count, {2000.0F, 2000.0F, 2000.0F, 0.0F, 0.0F, 0.0F});
        haptable_model model = *tip.get();
        model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(blocks.data());
        for (std::size_t v = 0; v < blocks.size(); ++v) {
            const Vector3d at = to_vector(tip.servo().vertex_m[v].data());
            const double angle = 2.0 * std::numbers::pi * soft / kSides;
            const double gap = (at - Vector3d(0.02 * std::cos(angle), 0.02 * std::sin(angle), 0.0)).norm();
            const float k = at.z() > 0.02 ? 100.0F : gap < 1e-4 ? 10.0F : 2000.0F;
            blocks[v] = {k, k, k, 0.0F, 0.0F, 0.0F};
        }
        Finger finger(unclamped(model));
        finger.to({0.0, 0.0, 0.031});
        for (int tick = 0; tick < 12; ++tick) finger.to({0.0, 0.0, 0.02});
        ASSERT_TRUE(finger.touches());
        EXPECT_LT(finger.god().z(), 0.0299) << soft;
    }
}

// Wherever the finger is, no point of the surface around the god-object has less energy.
TEST(LeastEnergy, TheGodObjectRestsAtAMinimum) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(cube_scene(5, 0.3), force, 0.008);
        const haptable_model model = body.model(GodObject::kLeastEnergy);
        const ReferenceServo reference(model);
        Finger finger(unclamped(model));
        std::mt19937 random(5);
        std::uniform_real_distribution<double> over(0.004, 0.026), deep(0.0005, 0.004);
        std::normal_distribution<double> normal;
        int checked = 0;
        for (int i = 0; i < 300; ++i) {
            finger.to({over(random), over(random), 0.032});
            const Vector3d in(over(random), over(random), 0.030 - deep(random));
            for (int tick = 0; tick < 8; ++tick) finger.to(in);  // a slide of 2 cm may need more than one
            if (!finger.touches()) continue;
            const Vector3d x = finger.at(), g = to_vector(finger.out().god_object_m);
            const double here = reference.energy(finger.out().patch, to_vector(finger.out().alpha), x).energy;
            // The servo compares energies of u, a difference of positions in float.
            const Bound rounded{.count = 8, .epsilon = kFloat, .condition = body.size() / (x - g).norm()};
            // Beyond the next edge another minimum may be lower.
            double reach = 3e-5;
            for (float alpha : finger.out().alpha)
                if (alpha > 0.0F) reach = std::min(reach, 0.001 * double(alpha));
            for (int k = 0; k < 100; ++k) {
                const double r = reach * std::pow(10.0, -1.5 * k / 100.0);
                Vector3d alpha;
                const int patch = body.patch_over(g.x() + r * normal(random), g.y() + r * normal(random), alpha);
                if (patch < 0) continue;
                ++checked;
                ASSERT_WITHIN(1.0 - reference.energy(patch, alpha, x).energy / here, rounded) << force << " " << i;
            }
        }
        EXPECT_GT(checked, 5000);
    }
}

}  // namespace
}  // namespace haptable::test
