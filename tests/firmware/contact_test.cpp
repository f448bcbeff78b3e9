// SPDX-License-Identifier: GPL-2.0-or-later
// The god-object, through the public header, against all-patches searches in double.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "firmware/haptable_bounds.h"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

std::vector<Shape> convex_shapes() {
    return {box_shape(4, Vector3d(0.03, 0.03, 0.03)), sphere_shape(3, 0.05), box_shape(3, Vector3d(0.1, 0.02, 0.005))};
}

std::vector<Shape> all_shapes() {
    auto shapes = convex_shapes();
    shapes.push_back(l_shape(6, 0.06));
    shapes.push_back(torus_shape(40, 16, 0.05, 0.02));
    return shapes;
}

/// A smooth random way around and through the body, `step_m` a tick.
class Wander {
public:
    Wander(const TestModel& model, double step_m, unsigned seed) : step_m_(step_m), random_(seed) {
        for (const auto& x : model.servo().vertex_m) {
            const Vector3d p = to_vector(x.data());
            low_ = low_.cwiseMin(p);
            high_ = high_.cwiseMax(p);
        }
        margin_ = 0.25 * (high_ - low_).maxCoeff();
        x_ = high_ + Vector3d::Constant(margin_);
        aim_ = x_;
    }
    Vector3d next() {
        if ((aim_ - x_).norm() < step_m_) {
            std::uniform_real_distribution<double> u(0.0, 1.0);
            for (int i = 0; i < 3; ++i) aim_[i] = low_[i] - margin_ + u(random_) * (high_[i] - low_[i] + 2 * margin_);
        }
        x_ += step_m_ * (aim_ - x_).normalized();
        return x_;
    }

private:
    double step_m_, margin_ = 0.0;
    std::mt19937 random_;
    Vector3d low_ = Vector3d::Constant(1e9), high_ = Vector3d::Constant(-1e9), x_, aim_;
};

void expect_valid(const TestModel& model, const haptable_output& out) {
    if (out.state != HAPTABLE_CONTACT) return;
    double sum = 0.0;
    Vector3d on_patch = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
        const auto alpha = static_cast<double>(out.alpha[c]);
        ASSERT_GE(alpha, 0.0);
        ASSERT_LE(alpha, 1.0);
        sum += alpha;
        on_patch += alpha * model.corner(out.patch, c);
    }
    ASSERT_WITHIN(std::abs(sum - 1.0), .count = 16, .epsilon = kFloat);
    ASSERT_WITHIN((on_patch - to_vector(out.god_object_m)).norm(), rounded(model));
}

TEST(Contact, AlphaIsInItsBoundsAndTheGodObjectOnItsPatch) {
    for (const Shape& shape : all_shapes()) {
        const TestModel model(shape);
        Finger finger(model);
        Wander wander(model, 0.01 * model.size(), 7);
        for (int tick = 0; tick < 20000; ++tick) expect_valid(model, finger.to(wander.next()));
        EXPECT_GT(finger.counters().contact_ticks, 1000U) << shape.name;
    }
}

/// The nearest point to x of all patches that hold the god-object: those with every vertex that it lies on.
Vector3d nearest_around(const TestModel& model, const haptable_output& out, const Vector3d& x) {
    const auto& patches = model.servo().patch;
    Vector3d best = to_vector(out.god_object_m);
    for (std::size_t p = 0; p < patches.size(); ++p) {
        bool holds = true;
        for (int c = 0; c < 3; ++c)
            holds &= out.alpha[c] == 0.0F || std::count(patches[p].begin(), patches[p].end(), out.vertex[c]) != 0;
        if (!holds) continue;
        const int i = static_cast<int>(p);
        const Vector3d y = nearest_on_triangle(x, model.corner(i, 0), model.corner(i, 1), model.corner(i, 2));
        if ((y - x).norm() < (best - x).norm()) best = y;
    }
    return best;
}

// A finger that grazes a surface without a step in its normal larger than the way in: the god-object is the nearest
// point of the whole surface.
TEST(Contact, UnderAFlatFaceTheGodObjectIsTheNearestPoint) {
    const TestModel model(box_shape(4, Vector3d(0.1, 0.1, 0.02)));
    Finger finger(model);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> over(0.02, 0.08), deep(0.0, 0.009);
    finger.to({0.05, 0.05, 0.03});
    for (int tick = 0; tick < 5000; ++tick) {
        const Vector3d x(over(random), over(random), 0.02 - deep(random));
        finger.to(x);
        ASSERT_TRUE(finger.touches());
        ASSERT_WITHIN((finger.god() - model.nearest(x)).norm(), rested(model)) << "tick " << tick;
    }
}

// Where the god-object rests, on a face, an edge or a vertex, no patch that it lies on leads nearer to the finger.
TEST(Contact, TheGodObjectRestsAtALocalMinimumOfTheDistance) {
    for (const Shape& shape : all_shapes()) {
        const TestModel model(shape);
        Finger finger(model);
        Wander wander(model, 0.01 * model.size(), 23);
        for (int tick = 0; tick < 6000; ++tick) {
            const Vector3d x = wander.next();
            finger.to(x);
            if (!finger.touches()) continue;
            const Vector3d nearest = nearest_around(model, finger.out(), x);
            ASSERT_WITHIN((finger.god() - nearest).norm(), rested(model)) << shape.name << " tick " << tick;
        }
        EXPECT_EQ(finger.counters().walk_limits, 0U);
    }
}

// Contact while and only while the finger is inside: random slow strokes from outside, no tick may miss.
TEST(Contact, InsideMeansContactOnConvexShapes) {
    for (const Shape& shape : convex_shapes()) {
        const TestModel model(shape);
        Finger finger(model);
        Wander wander(model, 0.003 * model.size(), 11);
        bool was_deep = false;
        for (int tick = 0; tick < 5000; ++tick) {
            const Vector3d x = wander.next();
            finger.to(x);
            const double gap = (x - model.nearest(x)).norm();
            if (gap < 1e-5 * model.size()) continue;
            const bool inside = model.signed_solid_angle(x) > 2 * std::numbers::pi;
            if (inside) {
                ASSERT_TRUE(finger.touches()) << shape.name << " tick " << tick << " depth " << gap;
            }
            was_deep |= inside;
        }
        EXPECT_TRUE(was_deep);
    }
}

// Any way in double that crosses the body begins a contact, whether or not it ends outside again.
TEST(Contact, OneTickThroughTheWholeBodyBeginsAContact) {
    for (const Shape& shape : all_shapes()) {
        const TestModel model(shape);
        std::mt19937 random(5);
        int through = 0;
        for (int stroke = 0; stroke < 200; ++stroke) {
            const Vector3d from = 1.5 * model.size() * random_direction(random);
            const Vector3d aim = Vector3d(model.corner(stroke % 10, 0)) + 0.2 * model.size() * random_direction(random);
            const Vector3d to = from + 2.0 * (aim - from);
            Vector3d inside = from;  // the deepest of some points on the way
            bool crosses = false;
            for (int i = 1; i < 100 && !crosses; ++i) {
                inside = from + (to - from) * i / 100.0;
                crosses = model.signed_solid_angle(inside) > 2 * std::numbers::pi;
            }
            if (!crosses) continue;
            Finger finger(model);
            finger.to(from);
            finger.to(to);
            ++through;
            ASSERT_GE(finger.counters().contacts, 1U) << shape.name << " stroke " << stroke;
        }
        EXPECT_GT(through, 30) << shape.name;
    }
}

// A thin sheet holds a finger that has passed through all of it in one tick (5 mm at 5 m/s).
TEST(Contact, AThinSheetHoldsAFastFinger) {
    const TestModel model(box_shape(8, Vector3d(0.1, 0.1, 0.001)));
    std::mt19937 random(9);
    std::uniform_real_distribution<double> over(0.01, 0.09), lateral(-0.003, 0.003);
    for (int stroke = 0; stroke < 2000; ++stroke) {
        Finger finger(model);
        const Vector3d above(over(random), over(random), 0.003);
        finger.to(above);
        const Vector3d below = above + Vector3d(lateral(random), lateral(random), -0.004);
        finger.to(below);
        ASSERT_TRUE(finger.touches());
        ASSERT_WITHIN((finger.god() - Vector3d(below.x(), below.y(), 0.001)).norm(), rounded(model));
    }
}

TEST(Contact, APressThroughAFaceBeginsAtTheCrossing) {
    const TestModel model(box_shape(4, Vector3d(0.03, 0.03, 0.03)));
    Finger finger(model);
    finger.to({0.011, 0.017, 0.040});
    EXPECT_FALSE(finger.touches());
    finger.to({0.011, 0.017, -0.020});  // through the cube and out below
    ASSERT_TRUE(finger.touches());
    EXPECT_WITHIN((finger.god() - Vector3d(0.011, 0.017, 0.030)).norm(), rounded(model));
    finger.to({0.011, 0.017, 0.0301});
    EXPECT_FALSE(finger.touches());
    EXPECT_EQ(finger.force().norm(), 0.0);
}

TEST(Contact, LetsGoOverAConvexEdgeAndHoldsInAConcaveCrease) {
    const TestModel model(l_shape(6, 0.06));  // solid for x < 0.03 or z < 0.03
    Finger finger(model);
    finger.to({0.045, 0.031, 0.035});
    finger.to({0.045, 0.031, 0.025});
    ASSERT_TRUE(finger.touches());
    // Towards the wall x = 0.03 and under it: the god-object stops in the crease (x, z) = (0.03, 0.03).
    for (int tick = 0; tick <= 100; ++tick) finger.to({0.045 - 0.0003 * tick, 0.031, 0.025});
    ASSERT_TRUE(finger.touches());
    EXPECT_WITHIN((finger.god() - Vector3d(0.03, 0.031, 0.03)).norm(), rounded(model));
    // Out over the convex edge x = 0.06 of the lower step: the finger leaves the body through its side.
    for (int tick = 0; tick <= 100; ++tick) finger.to({0.015 + 0.0005 * tick, 0.031, 0.025});
    EXPECT_FALSE(finger.touches());
}

TEST(Contact, AFingerThatStartsInsideIsNotThrownOut) {
    const TestModel model(box_shape(4, Vector3d(0.03, 0.03, 0.03)));
    Finger finger(model);
    finger.to({0.015, 0.015, 0.015});
    finger.to({0.015, 0.015, 0.020});
    EXPECT_FALSE(finger.touches());
    finger.to({0.015, 0.015, 0.040});
    finger.to({0.015, 0.015, 0.029});
    EXPECT_TRUE(finger.touches());
}

TEST(Contact, NoForceWithoutContactAndOutputsSayNone) {
    const TestModel model(box_shape(2, Vector3d(0.03, 0.03, 0.03)));
    Finger finger(model);
    const haptable_output& out = finger.to({0.1, 0.1, 0.1});
    EXPECT_EQ(out.state, HAPTABLE_FREE);
    EXPECT_EQ(out.patch, HAPTABLE_NONE);
    EXPECT_EQ(finger.god(), Vector3d(double(0.1F), double(0.1F), double(0.1F)));
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(out.vertex[c], HAPTABLE_NONE);
        EXPECT_EQ(out.alpha[c], 0.0F);
    }
    EXPECT_EQ(finger.force().norm(), 0.0);
}

/// Two boxes of 30 mm, 4 mm apart along x.
Shape two_boxes() {
    Shape both = box_shape(4, Vector3d(0.03, 0.03, 0.03));
    const Shape other = box_shape(4, Vector3d(0.03, 0.03, 0.03));
    const auto first = static_cast<std::int32_t>(both.point.size());
    for (const Vector3d& x : other.point) both.point.emplace_back(x + Vector3d(0.034, 0.0, 0.0));
    for (const auto& p : other.patch) both.patch.push_back({p[0] + first, p[1] + first, p[2] + first});
    return both;
}

// Leaving one part of a body, the finger may enter another in the same tick.
TEST(Contact, LeavingOnePartIntoAnotherInOneTick) {
    const TestModel model(two_boxes());
    Finger finger(model);
    finger.to({0.032, 0.016, 0.014});
    finger.to({0.029, 0.016, 0.014});
    ASSERT_TRUE(finger.touches());
    finger.to({0.036, 0.016, 0.014});  // out of the first, into the second
    ASSERT_TRUE(finger.touches());
    EXPECT_WITHIN((finger.god() - Vector3d(0.034, 0.016, 0.014)).norm(), rounded(model));
    EXPECT_EQ(finger.counters().contacts, 2U);
}

// Through a hole of 60 mm in one tick: the slide meets its limit, which is counted, the contact holds, and after one
// tick more the god-object is in the other arm.
TEST(Contact, ALongSlideGoesOnAtTheNextTick) {
    const TestModel model(torus_shape(48, 24, 0.05, 0.02));
    Finger finger(model);
    finger.to({0.05, 0.0, 0.03});
    finger.to({0.05, 0.0, 0.015});
    finger.to({0.045, 0.0, 0.0});
    for (int tick = 0; tick < 2; ++tick) {
        finger.to({-0.031, 0.0, 0.0});
        ASSERT_TRUE(finger.touches());
    }
    EXPECT_EQ(finger.counters().walk_limits, 1U);
    EXPECT_WITHIN((finger.god() - model.nearest({-0.031, 0.0, 0.0})).norm(), rested(model));
}

TEST(Contact, StepsOfATickStayWithinTheirBound) {
    for (const Shape& shape : {sphere_shape(4, 0.05), torus_shape(80, 32, 0.05, 0.02)}) {
        const TestModel model(shape);
        Finger finger(model);
        Wander wander(model, 0.05 * model.size(), 13);  // 5 m/s and more
        for (int tick = 0; tick < 20000; ++tick) expect_valid(model, finger.to(wander.next()));
        EXPECT_LE(finger.counters().most_steps, std::uint32_t{MOST_STEPS});
        EXPECT_LE(finger.counters().most_boxes, model.get()->box_count);
        EXPECT_GT(finger.counters().contacts, 10U);
    }
}

// A touch region has a border: the god-object stops there.
TEST(Contact, TheGodObjectStopsAtTheBorderOfTheTouchRegion) {
    Shape shape = box_shape(4, Vector3d(0.04, 0.04, 0.04));
    std::erase_if(shape.patch, [&](const auto& patch) {
        return std::any_of(patch.begin(), patch.end(),
                           [&](std::int32_t node) { return shape.point[std::size_t(node)].z() < 0.039; });
    });
    ASSERT_EQ(shape.patch.size(), 32U);  // the top
    std::vector<Vector3d> used;
    Shape top{"top", shape.point, shape.patch};
    const TestModel model(top);
    Finger finger(model);
    finger.to({0.02, 0.02, 0.05});
    for (int tick = 0; tick <= 100; ++tick) finger.to({0.02 + 0.0004 * tick, 0.02, 0.035});
    ASSERT_TRUE(finger.touches());
    EXPECT_WITHIN((finger.god() - Vector3d(0.04, 0.02, 0.04)).norm(), rounded(model));
    finger.to({0.05, 0.02, 0.041});
    EXPECT_FALSE(finger.touches());
}

}  // namespace
}  // namespace haptable::test
