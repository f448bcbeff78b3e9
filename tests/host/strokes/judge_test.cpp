// SPDX-License-Identifier: GPL-2.0-or-later
// The judge of strokes: it must be right about bodies, and it must see every fault that it looks for.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "host/base/error.hpp"
#include "host/strokes/campaign.hpp"
#include "host/strokes/shrink.hpp"
#include "tests/bodies.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

// ---- inside, outside, in sight ----

TEST(Solid, KnowsInsideFromOutsideAsSolidAnglesDo) {
    for (const Shape& shape :
         {box_shape(3, {0.03, 0.02, 0.01}), sphere_shape(2, 0.02), torus_shape(24, 12, 0.03, 0.01), l_shape(4, 0.03),
          hollow_shape(4, 0.03), hinge_shape(4, 0.03), spindle_shape(7, 0.01, 0.03)}) {
        const TestModel model(shape);
        const Solid solid(model.servo().vertex_m, model.servo().patch);
        std::mt19937 dice(5);
        std::uniform_real_distribution<double> any(-0.05, 0.05);
        int inside = 0;
        for (int k = 0; k < 2000; ++k) {
            const Vector3d x(any(dice), any(dice), any(dice));
            const bool holds = model.signed_solid_angle(x) > 2.0 * std::numbers::pi;
            EXPECT_EQ(solid.holds(x), holds) << shape.name;
            EXPECT_NEAR(solid.gap_m(x), (model.nearest(x) - x).norm(), 1e-12) << shape.name;
            inside += holds ? 1 : 0;
        }
        EXPECT_GT(inside, 5) << shape.name;
    }
}

TEST(Solid, SeesWhatNoTriangleHides) {
    const TestModel model(l_shape(4, 0.03));
    const Solid solid(model.servo().vertex_m, model.servo().patch);
    const Vector3d notch(0.025, 0.015, 0.025), beside(0.025, 0.015, 0.04), behind(-0.01, 0.015, 0.005);
    EXPECT_TRUE(solid.sees(notch, beside));
    EXPECT_FALSE(solid.sees(notch, behind));
    ASSERT_EQ(solid.entries(beside, Vector3d(0.025, 0.015, 0.005), 1e-9).size(), 1U);
    EXPECT_NEAR(solid.entries(beside, Vector3d(0.025, 0.015, 0.005), 1e-9)[0].point_m.z(), 0.015, 1e-9);
    EXPECT_TRUE(solid.entries(Vector3d(0.025, 0.015, 0.005), beside, 1e-9).empty()) << "out is not in";
    EXPECT_TRUE(solid.sees(notch, notch));
    EXPECT_TRUE(solid.entries(notch, notch, 1e-9).empty());
}

TEST(Solid, RefusesAnOpenSurface) {
    const TestModel model(box_shape(2, {0.03, 0.03, 0.03}));
    auto patches = model.servo().patch;
    patches.pop_back();
    EXPECT_THROW(Solid(model.servo().vertex_m, patches), Error);
}

// ---- faults ----

/// The servo with something wrong.
using Step = decltype(&haptable_servo_step);

struct SpoiledCase {
    const char* what;
    Step step;
    Fault fault;
    GodObject god_object;
    bool friction;
};

bool in_contact(const haptable_output* out) { return out->state == HAPTABLE_CONTACT; }

/// A god-object that is never let go: the contact of the last tick, and its force.
void never_lets_go(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                   haptable_output* out) {
    const haptable_contact held = servo->contact;
    haptable_servo_step(model, servo, x, us, out);
    if (held.patch == HAPTABLE_NONE || in_contact(out)) return;
    servo->contact = held;
    out->state = HAPTABLE_CONTACT;
    out->patch = held.patch;
    std::copy(held.alpha, held.alpha + 3, out->alpha);
    std::copy(held.god_object_m, held.god_object_m + 3, out->god_object_m);
    model->force(model, &held, x, out->nodal_force_n, out->force_n);
}

void drops_what_is_deep(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                        haptable_output* out) {
    haptable_servo_step(model, servo, x, us, out);
    Eigen::Map<const Eigen::Vector3f> finger(x), god(out->god_object_m);
    if (!in_contact(out) || (finger - god).norm() < 0.002F) return;
    const haptable_counters counters = servo->counters;
    haptable_servo_init(servo);
    servo->counters = counters;
    *out = {};
    out->state = HAPTABLE_FREE;
}

void pushes_too_hard(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                     haptable_output* out) {
    haptable_servo_step(model, servo, x, us, out);
    if (in_contact(out)) out->force_n[0] += 10.0F;
}

void is_a_little_soft(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                      haptable_output* out) {
    haptable_servo_step(model, servo, x, us, out);
    for (auto& nodal : out->nodal_force_n)
        for (float& component : nodal) component *= 0.9995F;
}

/// All on one node: the sum is right, the picture is not.
void loads_one_node(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                    haptable_output* out) {
    haptable_servo_step(model, servo, x, us, out);
    for (int axis = 0; axis < 3; ++axis)
        for (int c = 1; c < 3; ++c) {
            out->nodal_force_n[0][axis] += out->nodal_force_n[c][axis];
            out->nodal_force_n[c][axis] = 0.0F;
        }
}

void clicks(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
            haptable_output* out) {
    haptable_servo_step(model, servo, x, us, out);
    if (in_contact(out) && servo->counters.ticks % 16 < 8) out->force_n[1] += 0.3F;
}

/// The force of a god-object that gives energy, for one that must not.
void gives_energy(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                  haptable_output* out) {
    haptable_model nearest = *model;
    nearest.god_object = haptable_god_object_nearest;
    nearest.release = nullptr;
    haptable_servo_step(&nearest, servo, x, us, out);
}

/// Stuck where the contact began.
void never_slips(const haptable_model* model, haptable_servo* servo, const float x[3], std::uint32_t us,
                 haptable_output* out) {
    haptable_model sticky = *model;
    sticky.static_friction = sticky.kinetic_friction = 100.0F;
    haptable_servo_step(&sticky, servo, x, us, out);
}

class Spoiled : public testing::TestWithParam<SpoiledCase> {};

/// The cube, precomputed once for all cases with a compliance.
const StrokedBody& consistent_cube() {
    static const TemporaryFolder folder;
    static Progress progress(true);
    Scene scene = cube_scene(5, 0.3);
    scene.tables.columns = ColumnRows::kNone;
    static const StrokedBody body(in_mode(scene, {ForceLaw::kConsistent, GodObject::kNearest, false}), folder.path(),
                                  progress);
    return body;
}

Tally stroke_cube(const SpoiledCase& spoiled, Step step) {
    const StrokedBody& body = consistent_cube();
    const haptable_model model =
        body.model(in_mode(Scene(), {ForceLaw::kConsistent, spoiled.god_object, spoiled.friction}).contact);
    Touched touched = body.touched(model);
    touched.step = step;
    Workers workers(1);
    return run_strokes(touched, StrokeMaker(body.servo()), 7, 100, workers, [](std::size_t) {});
}

TEST_P(Spoiled, IsSeen) {
    const auto fault = static_cast<std::size_t>(GetParam().fault);
    EXPECT_EQ(stroke_cube(GetParam(), haptable_servo_step).faulty[fault], 0U) << "a servo that is well";
    EXPECT_GT(stroke_cube(GetParam(), GetParam().step).faulty[fault], 0U);
}

TEST_P(Spoiled, IsShrunkToFewTicks) {
    const Tally tally = stroke_cube(GetParam(), GetParam().step);
    const StrokedBody& body = consistent_cube();
    const haptable_model model =
        body.model(in_mode(Scene(), {ForceLaw::kConsistent, GetParam().god_object, GetParam().friction}).contact);
    Touched touched = body.touched(model);
    touched.step = GetParam().step;
    const StrokeMaker maker(body.servo());
    for (const Broken& broken : tally.broken) {
        if (!broken.verdict.has(GetParam().fault)) continue;
        const Stroke whole = maker.make(7, broken.number), least = shrink(touched, whole, GetParam().fault);
        EXPECT_TRUE(judge(touched, least).has(GetParam().fault));
        EXPECT_LT(least.size(), whole.size());
        for (std::size_t i = 0; i < least.size(); ++i) {
            Stroke fewer = least;
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
            double longest = 0.0;
            for (std::size_t k = 1; k < fewer.size(); ++k)
                longest = std::max(longest, double((Eigen::Map<const Eigen::Vector3f>(fewer[k].data()) -
                                                    Eigen::Map<const Eigen::Vector3f>(fewer[k - 1].data()))
                                                       .norm()));
            if (longest > 0.005) continue;
            EXPECT_FALSE(judge(touched, fewer).has(GetParam().fault)) << "tick " << i;
        }
        return;
    }
    FAIL() << "no stroke with the fault";
}

INSTANTIATE_TEST_SUITE_P(
    Servo, Spoiled,
    testing::Values(SpoiledCase{"NeverLetsGo", never_lets_go, Fault::kOutside, GodObject::kNearest, false},
                    SpoiledCase{"DropsWhatIsDeep", drops_what_is_deep, Fault::kLost, GodObject::kNearest, false},
                    SpoiledCase{"PushesTooHard", pushes_too_hard, Fault::kForce, GodObject::kNearest, false},
                    SpoiledCase{"IsALittleSoft", is_a_little_soft, Fault::kLaw, GodObject::kNearest, false},
                    SpoiledCase{"LoadsOneNode", loads_one_node, Fault::kDrawn, GodObject::kNearest, false},
                    SpoiledCase{"Clicks", clicks, Fault::kJump, GodObject::kLeastEnergy, false},
                    SpoiledCase{"GivesEnergy", gives_energy, Fault::kEnergy, GodObject::kLeastEnergy, false},
                    SpoiledCase{"NeverSlips", never_slips, Fault::kCone, GodObject::kNearest, true}),
    [](const auto& one) { return std::string(one.param.what); });

}  // namespace
}  // namespace haptable::test
