// SPDX-License-Identifier: GPL-2.0-or-later
// The god-object, through the public header, against all-patches searches in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tests/finger.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

Shape cube() { return box_shape(4, Vector3d(0.03, 0.03, 0.03)); }

std::vector<Shape> all_shapes() {
    return {cube(), sphere_shape(3, 0.05), box_shape(3, Vector3d(0.1, 0.02, 0.005)), l_shape(6, 0.06),
            torus_shape(40, 16, 0.05, 0.02)};
}

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

// Where the god-object rests, on a face, an edge or a vertex, no patch that it lies on leads nearer to the finger.
TEST(Contact, TheGodObjectIsOnItsPatchAtALocalMinimumOfTheDistance) {
    for (const Shape& shape : all_shapes()) {
        const TestModel model(shape);
        Finger finger(model);
        Wander wander(model, 0.01 * model.size(), 23);
        std::uint32_t limits = 0;
        for (int tick = 0; tick < 20000; ++tick) {
            const Vector3d x = wander.next();
            expect_valid(model, finger.to(x));
            const bool goes_on = std::exchange(limits, finger.counters().walk_limits) != limits;
            if (!finger.touches() || goes_on) continue;
            const Vector3d nearest = nearest_around(model, finger.out(), x);
            ASSERT_WITHIN((finger.god() - nearest).norm(), rested(model)) << shape.name << " tick " << tick;
        }
        EXPECT_LE(limits, shape.name == "torus" ? 5U : 0U) << shape.name << ": but through a hole";
        EXPECT_GT(finger.counters().contact_ticks, 1000U) << shape.name;
    }
}

/// Two boxes of 30 mm, 4 mm apart along x.
Shape two_boxes() {
    Shape both = cube();
    const auto first = static_cast<std::int32_t>(both.point.size());
    for (const Vector3d& x : cube().point) both.point.emplace_back(x + Vector3d(0.034, 0.0, 0.0));
    for (const auto& p : cube().patch) both.patch.push_back({p[0] + first, p[1] + first, p[2] + first});
    return both;
}

/// The top of a box of 40 mm, which has a border.
Shape top_of_a_box() {
    Shape shape = box_shape(4, Vector3d(0.04, 0.04, 0.04));
    std::erase_if(shape.patch, [&](const auto& patch) {
        return std::any_of(patch.begin(), patch.end(),
                           [&](std::int32_t node) { return shape.point[std::size_t(node)].z() < 0.039; });
    });
    return shape;
}

struct Leg {
    Vector3d to;
    int ticks = 1;
};

/// Where a way leaves the god-object; none: it ends without contact, and without a force.
struct Way {
    const char* name;
    Shape shape;
    std::vector<Leg> legs;
    std::optional<Vector3d> god;
};

TEST(Contact, BeginsWhereASurfaceIsCrossedAndEndsWhereTheFingerLeavesIt) {
    const Shape step = l_shape(6, 0.06);  // solid for x < 0.03 or z < 0.03
    const Leg above{{0.011, 0.017, 0.040}}, below{{0.011, 0.017, -0.020}};
    const Leg over_step{{0.045, 0.031, 0.035}}, in_step{{0.045, 0.031, 0.025}};
    const Leg inside{{0.015, 0.015, 0.015}}, still_inside{{0.015, 0.015, 0.020}};
    const Leg over_top{{0.02, 0.02, 0.05}}, in_top{{0.02, 0.02, 0.035}}, beyond_top{{0.06, 0.02, 0.035}, 100};
    const Way ways[] = {
        {"through a cube", cube(), {above, below}, Vector3d(0.011, 0.017, 0.030)},
        {"and back", cube(), {above, below, {{0.011, 0.017, 0.0301}}}, {}},
        {"into a concave crease",
         step,
         {over_step, in_step, {{0.015, 0.031, 0.025}, 100}},
         Vector3d(0.03, 0.031, 0.03)},
        {"over a convex edge", step, {over_step, in_step, {{0.065, 0.031, 0.025}, 100}}, {}},
        {"from inside", cube(), {inside, still_inside}, {}},
        {"from inside and in again",
         cube(),
         {inside, still_inside, {{0.015, 0.015, 0.040}}, {{0.015, 0.015, 0.029}}},
         Vector3d(0.015, 0.015, 0.030)},
        {"out of one part into another in one tick",
         two_boxes(),
         {{{0.032, 0.016, 0.014}}, {{0.029, 0.016, 0.014}}, {{0.036, 0.016, 0.014}}},
         Vector3d(0.034, 0.016, 0.014)},
        {"to a border", top_of_a_box(), {over_top, in_top, beyond_top}, Vector3d(0.04, 0.02, 0.04)},
        {"over a border", top_of_a_box(), {over_top, in_top, beyond_top, {{0.05, 0.02, 0.041}}}, {}},
    };
    for (const Way& way : ways) {
        SCOPED_TRACE(way.name);
        const TestModel model(way.shape);
        Finger finger(model);
        Vector3d from = way.legs[0].to;
        for (const Leg& leg : way.legs) {
            walk({from, leg.to}, leg.ticks, [&](const Vector3d& x) { finger.to(x); });
            from = leg.to;
        }
        EXPECT_EQ(finger.touches(), way.god.has_value());
        if (way.god)
            EXPECT_WITHIN((finger.god() - *way.god).norm(), rounded(model));
        else
            EXPECT_EQ(finger.force().norm(), 0.0);
    }
}

}  // namespace
}  // namespace haptable::test
