// SPDX-License-Identifier: GPL-2.0-or-later
// The search of a finger's segment by the spatial index: how many boxes it takes, and what becomes of one that takes
// more than a tick has.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/finger.hpp"
#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A plate of 2 mm with 25,000 patches: a segment along its top meets hundreds of boxes.
const TestModel& plate() {
    static const TestModel model(box_shape(46, Vector3d(0.1, 0.1, 0.002)));
    return model;
}

/// Ticks of a resting finger until it touches; 99: never.
int ticks_until_contact(Finger& finger, const Vector3d& x) {
    for (int tick = 1; tick <= 10; ++tick)
        if (finger.to(x).state == HAPTABLE_CONTACT) return tick;
    return 99;
}

// While a long segment over the plate is still searched the finger goes in and comes out, on segments of their own.
TEST(Search, MissesNothingThatHappensMeanwhile) {
    Finger finger(plate());
    finger.to({0.001, 0.002, 0.0020001});
    finger.to({0.099, 0.097, 0.0020001});
    EXPECT_FALSE(finger.touches());  // within the boxes' margin over it
    ASSERT_EQ(finger.counters().box_limits, 1U);
    EXPECT_LE(ticks_until_contact(finger, {0.099, 0.097, 0.0015}), 6);  // pressed down before the search was over
    finger.to({0.099, 0.097, 0.0012});
    EXPECT_TRUE(finger.touches());
    finger.to({0.099, 0.097, 0.0025});
    EXPECT_FALSE(finger.touches());
    EXPECT_EQ(finger.counters().contacts, 1U);
}

TEST(Search, ADroppedFingerLeavesNoSearchBehind) {
    Finger finger(plate());
    finger.to({0.001, 0.002, 0.0022});
    finger.to({0.099, 0.097, 0.0019});
    ASSERT_EQ(finger.counters().box_limits, 1U);
    finger.to(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_EQ(ticks_until_contact(finger, {0.05, 0.05, 0.001}), 99);  // inside from the first position on
    EXPECT_EQ(finger.counters().contacts, 0U);
}

// Long jumps on to the plate from everywhere: a finger that ends inside is held within a few ticks, one that ends
// outside is not.
TEST(Search, LateEntriesAreEntries) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> u(0.0, 1.0);
    std::uint32_t limits = 0;
    for (int i = 0; i < 300; ++i) {
        Finger finger(plate());
        finger.to({0.1 * u(random), 0.1 * u(random), 0.0021 + 0.0004 * u(random)});
        const Vector3d end(0.002 + 0.096 * u(random), 0.002 + 0.096 * u(random), 0.0008 + 0.0011 * u(random));
        const int ticks = ticks_until_contact(finger, end);
        EXPECT_LE(ticks, 6) << i;
        limits += finger.counters().box_limits;
    }
    EXPECT_GT(limits, 30U);
}

// Rounding puts a finger that lies on a patch to either side of it: a path that begins there enters as it goes in.
TEST(Search, APathThatBeginsWithinRoundingOfAPatchEntersIt) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> u(0.1, 0.3), height(-0.9, 0.9);
    for (const Shape& shape : {box_shape(4, Vector3d(0.03, 0.03, 0.03)), sphere_shape(3, 0.03), l_shape(4, 0.03)}) {
        const TestModel model(shape);
        const double tolerance = model.get()->tolerance_m;
        for (int i = 0; i < 200; ++i) {
            const int patch = int(random() % model.servo().patch.size());
            const Vector3d a = model.corner(patch, 0), b = model.corner(patch, 1) - a, c = model.corner(patch, 2) - a;
            const Vector3d on = a + u(random) * b + u(random) * c, outward = b.cross(c).normalized();
            Finger finger(model);
            finger.to(on + height(random) * tolerance * outward);
            finger.to(on - 0.01 * model.size() * outward);
            EXPECT_TRUE(finger.touches()) << shape.name << " patch " << patch;
        }
    }
}

// What codegen states: no segment of up to 5 mm visits more boxes; and it states not much more than there are.
TEST(Search, NoFastWayVisitsMoreBoxesThanStated) {
    for (const Shape& shape : {box_shape(4, Vector3d(0.03, 0.03, 0.03)), sphere_shape(4, 0.03),
                               torus_shape(48, 24, 0.05, 0.02), box_shape(20, Vector3d(0.03, 0.03, 0.001))}) {
        const TestModel model(shape);
        const std::size_t stated = most_boxes(model.servo(), 0.005);
        std::mt19937 random(6);
        std::normal_distribution<double> normal;
        std::uniform_real_distribution<double> u(0.0, 1.0);
        std::size_t most = 0;
        for (int i = 0; i < 20000; ++i) {
            const int patch = int(random() % model.servo().patch.size());
            const Vector3d way = Vector3d(normal(random), normal(random), normal(random)).normalized();
            const Vector3d from = model.corner(patch, 0) - 0.005 * u(random) * way;
            Finger finger(model);
            finger.to(from);
            finger.to(from + 0.00499 * way);
            if (finger.touches() || finger.counters().contacts > 0) continue;  // more ways than one
            most = std::max(most, std::size_t{finger.counters().most_boxes});
        }
        EXPECT_LE(most, stated) << shape.name;
        EXPECT_GT(3 * most, stated) << shape.name;
    }
}

/// A servo, and one that forgets at every tick what it knows of the air around the finger: so it searches every path.
struct WithAndWithoutClearance {
    explicit WithAndWithoutClearance(const TestModel& model) : with(model), without(model) {}

    /// One tick of both: true where they have the same bits of force, god-object and path.
    bool to(const Vector3d& x) {
        haptable_servo& forgets = without.servo();
        if (forgets.contact.patch == HAPTABLE_NONE && forgets.segment.unfinished == 0) forgets.segment.fraction = 0;
        const haptable_output &out = with.to(x), &searched = without.to(x);
        const haptable_segment &segment = with.servo().segment, &all = without.servo().segment;
        boxes += segment.boxes;
        searches += segment.boxes > 0 ? 1U : 0U;
        boxes_without += all.boxes;
        return out.patch == searched.patch && with.counters().contacts == without.counters().contacts &&
               std::memcmp(out.force_n, searched.force_n, sizeof out.force_n) == 0 &&
               std::memcmp(out.god_object_m, searched.god_object_m, sizeof out.god_object_m) == 0 &&
               std::memcmp(segment.to_m, all.to_m, sizeof all.to_m) == 0;
    }

    Finger with, without;
    std::size_t boxes = 0, searches = 0, boxes_without = 0;
};

const std::vector<Shape>& shapes() {
    static const std::vector<Shape> shapes{box_shape(4, Vector3d(0.03, 0.03, 0.03)),
                                           box_shape(20, Vector3d(0.03, 0.03, 0.001)),
                                           sphere_shape(4, 0.03),
                                           torus_shape(48, 24, 0.05, 0.02),
                                           l_shape(4, 0.03),
                                           hollow_shape(5, 0.03),
                                           spindle_shape(31, 0.01, 0.03),
                                           fanned_disk_shape(24, 0.02, 0.001),
                                           scaled(sphere_shape(3, 0.03), 1e-4)};
    return shapes;
}

// A finger that goes round 2 mm over a sphere of 30 mm, 0.1 mm a tick. A tick without a search visits no box.
TEST(Search, AHoveringFingerSearchesSeldom) {
    const TestModel model(sphere_shape(4, 0.03));
    WithAndWithoutClearance finger(model);
    for (int tick = 0; tick < 2000; ++tick) {
        const double angle = 0.1 / 32.0 * tick;
        ASSERT_TRUE(finger.to(0.032 * Vector3d(std::cos(angle), 0.6 * std::sin(angle), 0.8 * std::sin(angle))));
    }
    EXPECT_EQ(finger.with.counters().contact_ticks, 0U);
    EXPECT_LT(2 * finger.boxes, finger.boxes_without);
    EXPECT_LT(finger.searches, 1000U);
}

/// How far a finger goes in a tick: sizes from a thousandth of the body's on, and now and then a jump.
double stride(std::mt19937& random, double size) {
    std::uniform_real_distribution<double> u(0.0, 1.0);
    return u(random) < 0.02 ? 0.3 * size : size * std::pow(10.0, -4.5 + 2.5 * u(random));
}

// Random fingers around and through every shape: near the surface, where a clearance ends, most of the time.
TEST(Search, AClearanceChangesNoBitOfAnyStroke) {
    for (const Shape& shape : shapes())
        for (const GodObject god_object : every<GodObject>()) {
            const TestModel model(shape, -1e9, god_object);
            WithAndWithoutClearance finger(model);
            std::mt19937 random(7);
            std::normal_distribution<double> normal;
            Vector3d x = 2.0 * model.corner(0, 0), to = x;
            for (int tick = 0; tick < 20000; ++tick) {
                if (tick % 50 == 0)
                    to = model.corner(int(random() % model.servo().patch.size()), int(random() % 3)) +
                         0.02 * model.size() * Vector3d(normal(random), normal(random), normal(random));
                const Vector3d way =
                    to - x + 0.01 * model.size() * Vector3d(normal(random), normal(random), normal(random));
                x += way.normalized() * std::min(way.norm(), stride(random, model.size()));
                ASSERT_TRUE(finger.to(x)) << shape.name << " tick " << tick;
            }
            EXPECT_GT(finger.with.counters().contact_ticks, 1000U) << shape.name;
            EXPECT_LT(finger.boxes, finger.boxes_without) << shape.name;
        }
}

}  // namespace
}  // namespace haptable::test
