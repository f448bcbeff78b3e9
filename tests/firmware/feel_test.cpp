// SPDX-License-Identifier: GPL-2.0-or-later
// What a finger notices: contact that is never lost, and the digits of a float.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "firmware/haptable_bounds.h"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/reference_servo.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A shape and how deep a point lies in it at the least, m; negative outside.
struct Solid {
    Shape shape;
    std::function<double(const Vector3d&)> depth;
};

double box_depth(const Vector3d& x, const Vector3d& low, const Vector3d& high) {
    return std::min((x - low).minCoeff(), (high - x).minCoeff());
}

/// A box of which the upper side is narrowed to a fiftieth of its width in x, and in y where `both`.
Shape tapered(int cells, const Vector3d& side, bool both) {
    Shape shape = box_shape(cells, side);
    for (Vector3d& x : shape.point) {
        const double width = 1.0 - 0.98 * x.z() / side.z();
        x.x() = (x.x() - 0.5 * side.x()) * width;
        x.y() = (x.y() - 0.5 * side.y()) * (both ? width : 1.0);
    }
    return shape;
}

/// A convex shape, by the planes of its patches.
Solid convex(const std::string& name, Shape shape) {
    std::vector<std::pair<Vector3d, double>> plane;
    for (const auto& [a, b, c] : shape.patch) {
        const auto at = [&](std::int32_t i) { return shape.point[std::size_t(i)]; };
        const Vector3d n = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
        plane.emplace_back(n, n.dot(at(a)));
    }
    shape.name = name;
    return {shape, [plane](const Vector3d& x) {
                double depth = 1.0;
                for (const auto& [n, d] : plane) depth = std::min(depth, d - n.dot(x));
                return depth;
            }};
}

/// With creases, cavities, hinges and vertices of few and of many patches too.
std::vector<Solid> solids() {
    const Vector3d o = Vector3d::Zero(), side(0.04, 0.04, 0.04), hollow(0.01, 0.01, 0.01);
    std::vector<Solid> all{
        convex("box", box_shape(4, {0.03, 0.03, 0.03})), convex("thin plate", box_shape(10, {0.1, 0.1, 0.001})),
        convex("sphere", sphere_shape(3, 0.03)), convex("wedge", tapered(5, {0.03, 0.03, 0.03}, false)),
        convex("needle", tapered(6, {0.006, 0.006, 0.06}, true))};
    all.push_back({l_shape(6, 0.06), [=](const Vector3d& x) {
                       return std::max(box_depth(x, o, {0.03, 0.06, 0.06}), box_depth(x, o, {0.06, 0.06, 0.03}));
                   }});
    all.push_back({torus_shape(48, 24, 0.05, 0.02),
                   [](const Vector3d& x) { return 0.0194 - std::hypot(std::hypot(x.x(), x.y()) - 0.05, x.z()); }});
    all.push_back({hollow_shape(4, 0.04), [=](const Vector3d& x) {
                       return std::min(box_depth(x, o, side), -box_depth(x, hollow, side - hollow));
                   }});
    all.push_back({hinge_shape(4, 0.04), [=](const Vector3d& x) {  // both arms share the edge x = z = 0.02
                       return std::max(box_depth(x, o, {0.02, 0.04, 0.02}), box_depth(x, {0.02, 0, 0.02}, side));
                   }});
    all.push_back(convex("tip of 3", spindle_shape(3, 0.02, 0.03)));
    all.push_back(convex("tip of 30", spindle_shape(30, 0.02, 0.03)));
    all.push_back(convex("fanned disk", fanned_disk_shape(28, 0.03, 0.01)));
    return all;
}

/// A point of a patch by lot.
struct Spot {
    Vector3d at, normal;
};

Spot any_spot(const TestModel& model, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const int patch = std::uniform_int_distribution<int>(0, int(model.servo().patch.size()) - 1)(random);
    Vector3d alpha(uniform(random), uniform(random), uniform(random));
    alpha /= alpha.sum();
    const Vector3d a = model.corner(patch, 0), b = model.corner(patch, 1), c = model.corner(patch, 2);
    return {alpha[0] * a + alpha[1] * b + alpha[2] * c, (b - a).cross(c - a).normalized()};
}

struct Strokes {
    int strokes = 0, inside = 0, lost = 0, through = 0;
};

/// From just outside of a random patch straight inwards, 10 ticks, at 0.01 to 5 m/s.
void stroke(const Solid& solid, const TestModel& model, Finger& finger, std::mt19937& random, Strokes& result) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const Spot spot = any_spot(model, random);
    const double step = 1e-3 * 0.01 * std::pow(500.0, uniform(random));
    Vector3d x = spot.at + (step * uniform(random) + 2e-6) * spot.normal;
    if (solid.depth(x) > -1e-6) return;
    Vector3d way = random_direction(random);
    if (way.dot(spot.normal) > 0.0) way = -way;
    way = (way - 0.5 * spot.normal).normalized();
    ++result.strokes;
    finger.begin();
    finger.to(x);
    for (int tick = 0; tick < 10; ++tick) {
        const Vector3d last = x;
        const std::uint32_t before = finger.counters().contacts;
        const bool touched = finger.touches();
        x += step * way;
        finger.to(x);
        const bool inside = solid.depth(x) > 1e-6, crossed = solid.depth(0.5 * (last + x)) > 1e-6;
        result.inside += inside;
        result.lost += inside && !finger.touches();
        result.through += crossed && !touched && finger.counters().contacts == before;
    }
}

class StrokesOf : public testing::TestWithParam<GodObject> {};
INSTANTIATE_TEST_SUITE_P(GodObjects, StrokesOf, testing::ValuesIn(every<GodObject>()),
                         [](const auto& of) { return test_name(word(of.param)); });

TEST_P(StrokesOf, LoseNoContact) {
    int inside = 0;
    for (const Solid& solid : solids()) {
        SCOPED_TRACE(solid.shape.name);
        const TestModel model(solid.shape, -1e9, GetParam());
        Finger finger(model);
        std::mt19937 random(17);
        Strokes all;
        while (all.strokes < 20'000) stroke(solid, model, finger, random, all);
        EXPECT_EQ(all.lost, 0);
        EXPECT_EQ(all.through, 0);
        EXPECT_LE(finger.counters().most_steps, std::uint32_t{MOST_STEPS});
        EXPECT_LE(finger.counters().most_energies, std::uint32_t{MOST_ENERGIES});
        EXPECT_EQ(finger.counters().slide_limits, 0U);
        inside += all.inside;
    }
    EXPECT_GT(inside, 700'000);
}

/// How far the float servo's force is from the double one's, as a rounding of the positions, ticks in order of size.
struct Digits {
    std::vector<double> difference;
    int parted = 0;
};

/// The finger waits there as long as a tick's steps do not do for its god-object to come to rest.
void rest_at(const Vector3d& x, Finger& finger) {
    std::uint32_t limits = 0;
    int ticks = 0;
    do {
        limits = finger.counters().walk_limits;
        finger.to(x);
    } while (finger.counters().walk_limits != limits && ++ticks < 10);
}

Digits compare(const ElasticBody& body, GodObject god_object, unsigned seed) {
    haptable_model model = body.model(god_object);
    model.max_force_n = 1e6F;
    Finger finger(model);
    ReferenceServo reference(model);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> any(0, body.patches() - 1);
    Digits digits;
    for (int way = 0; way < 60; ++way) {
        const int patch = any(random);
        const Vector3d n = body.normal(patch), start = body.point(patch, Vector3d(0.3, 0.3, 0.4));
        const Vector3d along = random_direction(random).cross(n).normalized();
        for (int tick = 0; tick < 200; ++tick) {
            const double s = tick / 199.0;
            Vector3d x = start + (0.001 - 0.004 * std::sin(std::numbers::pi * s)) * n + 0.008 * s * along;
            x = x.cast<float>().cast<double>();
            rest_at(x, finger);
            const ReferenceServo::Tick tock = reference.step(x);
            if (!finger.touches() || tock.state != HAPTABLE_CONTACT) continue;
            if (tock.force.norm() < 1e-3) continue;
            // u, and with it the force, is a difference of positions.
            const double condition = body.size() / (x - tock.god).norm();
            const double difference = (finger.force() - tock.force).norm() / tock.force.norm();
            if (difference < 1e-3) {
                digits.difference.push_back(difference / condition);
                continue;
            }
            // Parted at a tie: both must be minima, and both go on from the float's.
            ++digits.parted;
            reference.set_contact(finger.out().patch, to_vector(finger.out().alpha), x);
            const ReferenceServo::Tick again = reference.step(x);
            const auto energy = [&](const ReferenceServo::Tick& at) { return -0.5 * at.force.dot(x - at.god); };
            const double energy_j = -0.5 * finger.force().dot(x - finger.god());
            EXPECT_WITHIN(std::abs(energy(again) - energy_j), .count = 16, .epsilon = kFloat, .condition = condition,
                          .size = energy(again))
                << god_object << " is no minimum";
        }
    }
    std::sort(digits.difference.begin(), digits.difference.end());
    return digits;
}

TEST(Feel, FloatsGiveTheForceOfDoubles) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.008);
            const Digits d = compare(body, god, 4);
            ASSERT_GT(d.difference.size(), 3000U);
            const double at_999 = d.difference[d.difference.size() * 999 / 1000];
            EXPECT_WITHIN(at_999, .count = 16, .epsilon = kFloat) << force << " " << god;
            EXPECT_LT(d.parted, int(d.difference.size() / 500)) << force << " " << god;
        }
}

}  // namespace
}  // namespace haptable::test
