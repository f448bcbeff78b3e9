// SPDX-License-Identifier: GPL-2.0-or-later
// Contact that went wrong: each fault on a small shape of our own, and the strokes on real meshes that showed them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "host/scene/scene.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Straight to `end`, 0.1 mm a tick.
void go(Finger& finger, const Vector3d& end) {
    const Vector3d begin = finger.at();
    const int ticks = std::max(1, int(std::ceil((end - begin).norm() / 1e-4)));
    for (int i = 1; i <= ticks; ++i) finger.to(begin + (end - begin) * i / ticks);
}

/// A cube of 40 mm around the origin whose top and bottom are dented down and up to one point, the origin: its two
/// rings of four patches bound air each, and the body lies between them.
Shape pinhole_shape() {
    Shape shape{"pinhole", {}, {}};
    for (const double z : {-0.02, 0.02})
        for (const auto& [x, y] : {std::pair{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}})
            shape.point.emplace_back(x, y, z);
    shape.point.emplace_back(0.0, 0.0, 0.0);
    for (std::int32_t i = 0; i < 4; ++i) {
        const std::int32_t j = (i + 1) % 4;
        shape.patch.push_back({4 + i, 4 + j, 8});
        shape.patch.push_back({j, i, 8});
        shape.patch.push_back({i, j, 4 + j});
        shape.patch.push_back({i, 4 + j, 4 + i});
    }
    return shape;
}

TEST(Faults, AVertexIsAllOfItsRings) {
    for (const GodObject god : {GodObject::kNearest, GodObject::kLeastEnergy}) {
        const TestModel model(pinhole_shape(), -1e9, god);
        ASSERT_EQ(model.servo().hinge.size(), 8U);
        Finger finger(model);
        finger.to({0.004, 0.0005, 0.006});
        go(finger, {0.004, 0.0005, 0.003});
        ASSERT_TRUE(finger.touches());
        go(finger, {0.0005, 0.0001, 0.0001});  // beside the pinhole
        ASSERT_TRUE(finger.touches());
        go(finger, {0.0, 0.0, -0.005});  // in the free air below it
        EXPECT_FALSE(finger.touches());
    }
}

TEST(Faults, BodiesWithoutHingesHaveNoTableOfThem) {
    const TestModel model(box_shape(3, Vector3d(0.03, 0.03, 0.03)));
    EXPECT_TRUE(model.servo().hinge.empty());
    EXPECT_EQ(model.get()->hinge, nullptr);
}

/// Pressed on its top: a finger of much friction, which holds the god-object.
haptable_model held(const TestModel& model) {
    haptable_model rough = *model.get();
    rough.frictionless = rough.god_object;
    rough.god_object = haptable_god_object_friction;
    rough.static_friction = rough.kinetic_friction = 1000.0F;
    return rough;
}

// The frictionless god-object goes around half of the ball, which takes more steps than a tick has, while friction
// holds the one that is felt.
TEST(Faults, ASlideThatIsNotFinishedGoesOnWhereItWas) {
    const TestModel model(sphere_shape(5, 0.03));
    Finger finger(held(model));
    finger.to({0.001, 0.0, 0.031});
    finger.to({0.001, 0.0, 0.028});
    ASSERT_TRUE(finger.touches());
    int ticks = 0;
    for (; finger.touches() && ticks < 100; ++ticks) finger.to({0.003, 0.001, -0.04});  // through the ball, and out
    EXPECT_LT(ticks, int{HAPTABLE_UNDECIDED_TICKS});
    EXPECT_GT(finger.counters().walk_limits, 0U);
    EXPECT_EQ(finger.counters().given_up, 0U);
}

// A finger that is on the other side of the ball at every tick: no slide ever ends.
TEST(Faults, WhatIsNeverDecidedIsLetGoWithAFallingForce) {
    const TestModel model(sphere_shape(5, 0.03));
    Finger finger(model);
    finger.to({0.001, 0.0, 0.031});
    finger.to({0.001, 0.0, 0.028});
    ASSERT_TRUE(finger.touches());
    int ticks = 0;
    for (; finger.touches() && ticks < 100; ++ticks) {
        finger.to({0.001, 0.0005, ticks % 2 == 0 ? -0.028 : 0.028});
        const double left = 1.0 - double(finger.servo().fade_ticks) / HAPTABLE_FADE_TICKS;
        if (!finger.touches()) break;
        Vector3d whole = Vector3d::Zero();
        for (const auto& nodal : finger.out().nodal_force_n) whole -= to_vector(nodal);
        const double felt = std::min(whole.norm() * left, 8.5);
        ASSERT_NEAR(finger.force().norm(), felt, 1e-4 * felt) << ticks;
    }
    EXPECT_EQ(ticks, HAPTABLE_UNDECIDED_TICKS + HAPTABLE_FADE_TICKS - 2);
    EXPECT_EQ(finger.counters().given_up, 1U);
    EXPECT_EQ(finger.force().norm(), 0.0);
}

// ---- real meshes --------------------------------------------------------------------------------------------------

const std::filesystem::path kStrokes = "../shared/contact";

std::vector<std::optional<Vector3d>> read_stroke(const std::filesystem::path& file) {
    std::vector<std::optional<Vector3d>> stroke;
    std::ifstream text(file);
    std::string line;
    std::getline(text, line);  // x,y,z
    while (std::getline(text, line)) {
        double x = NAN, y = NAN, z = NAN;
        if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &x, &y, &z) != 3) break;
        stroke.push_back(std::isfinite(x) ? std::optional<Vector3d>({x, y, z}) : std::nullopt);
    }
    return stroke;
}

/// The stroke of one fault, on its mesh and in its mode, tick by tick.
template <typename Look>
void replay(const std::string& fault, Look look) {
    if (!std::filesystem::exists(kStrokes / (fault + ".csv"))) GTEST_SKIP() << "no " << kStrokes << " here";
    const Scene scene = read_scene(kStrokes / (fault + ".toml"));
    const ElasticBody body(scene, scene.contact.force);
    Finger finger(body.model(scene.contact.god_object));
    int row = 0;
    for (const auto& x : read_stroke(kStrokes / (fault + ".csv"))) {
        if (x) {
            finger.to(*x);
            look(row, finger);
        } else {
            finger.begin();
        }
        ++row;
    }
    EXPECT_GT(row, 100);
}

TEST(RealStrokes, AFingerThatIsOutIsNotPulledBack) {
    replay("stuck", [](int row, const Finger& finger) {
        if (row > 90) {
            ASSERT_FALSE(finger.touches()) << row;
        }
    });
}

TEST(RealStrokes, ANewContactNeverHoldsMoreThanTheOneLetGo) {
    double before = 0.0;
    std::uint32_t contacts = 0;
    bool touched = false;
    replay("energy", [&](int row, const Finger& finger) {
        if (touched && finger.touches() && finger.counters().contacts != contacts) {
            ASSERT_LT(finger.energy(), 1.01 * before + 1e-9) << row;
        }
        contacts = finger.counters().contacts;
        touched = finger.touches();
        before = finger.energy();
    });
}

TEST(RealStrokes, AFingerInsideKeepsItsContact) {
    replay("lost", [](int row, const Finger& finger) {
        if (row >= 55 && row < 90) {
            ASSERT_TRUE(finger.touches()) << row;
        }
    });
}

TEST(RealStrokes, AFingerInFreeAirIsNotCaughtOnAHinge) {
    replay("hinge", [](int row, const Finger& finger) {
        if (row >= 105) {
            ASSERT_FALSE(finger.touches()) << row;
        }
    });
}

}  // namespace
}  // namespace haptable::test
