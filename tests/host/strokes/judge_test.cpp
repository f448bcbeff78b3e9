// SPDX-License-Identifier: GPL-2.0-or-later
// The judge of strokes: it must be right about bodies, and it must see every fault that it looks for.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "host/base/error.hpp"
#include "tests/bodies.hpp"
#include "tests/host/strokes/stroked.hpp"
#include "tests/shapes.hpp"

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

/// The servo, and then something wrong with what it leaves.
template <auto kSpoil>
void after(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    kSpoil(scene, out);
}

bool in_contact(const haptable_output& out) { return out.state == HAPTABLE_CONTACT; }
bool for_half_of_16_ticks(SceneState& scene) { return scene.servo(0).counters.ticks % 16 < 8; }

template <std::size_t count>
void scale(float (&values)[count], float by) {
    for (float& value : values) value *= by;
}
template <std::size_t rows, std::size_t columns>
void scale(float (&values)[rows][columns], float by) {
    for (auto& row : values) scale(row, by);
}

/// A god-object that is never let go: the contact of the last tick, and its force.
void never_lets_go(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    const haptable_contact held = scene.servo(0).contact;
    const haptable_model* model = scene.scene().model;
    scene.step(in, us, out);
    if (held.patch == HAPTABLE_NONE || in_contact(out[0])) return;
    scene.servo(0).contact = held;
    out->state = HAPTABLE_CONTACT;
    out->patch = held.patch;
    std::copy(held.alpha, held.alpha + 3, out->alpha);
    std::copy(held.god_object_m, held.god_object_m + 3, out->god_object_m);
    model->force(model, &held, in->finger_m, out->nodal_force_n, out->force_n);
}

/// In the body's frame.
void drops_what_is_deep(SceneState& scene, haptable_output out[]) {
    for (std::size_t f = 0; f < scene.fingers(); ++f) {
        haptable_servo& servo = scene.servo(f);
        Eigen::Map<const Eigen::Vector3f> finger(servo.finger_m), god(out[f].god_object_m);
        if (!in_contact(out[f]) || (finger - god).norm() < 0.002F) continue;
        const haptable_servo before = servo;
        haptable_servo_init(&servo);
        servo.counters = before.counters;
        servo.finger = before.finger;
        out[f] = {};
        out[f].state = HAPTABLE_FREE;
        std::copy_n(before.finger_m, 3, servo.finger_m);
    }
}

/// All on one node: the sum is right, the picture is not.
void loads_one_node(SceneState& /*scene*/, haptable_output out[]) {
    for (int axis = 0; axis < 3; ++axis)
        for (int c = 1; c < 3; ++c) {
            out->nodal_force_n[0][axis] += out->nodal_force_n[c][axis];
            out->nodal_force_n[c][axis] = 0.0F;
        }
}

/// The force of a god-object that gives energy, for one that must not.
void gives_energy(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_model nearest = *scene.scene().model;
    nearest.god_object = haptable_god_object_nearest;
    nearest.release = nullptr;
    haptable_servo_step(&nearest, &scene.servo(0), in->finger_m, us, out);
}

/// The point, of a tool or of many fingers, whose depth is greatest.
std::size_t deepest(SceneState& scene) {
    const auto depth = [&](std::size_t i) {
        if (scene.point_state(i).is_inside == 0) return -1.0F;
        const haptable_servo& servo = scene.point_servo(i);
        Eigen::Map<const Eigen::Vector3f> at(servo.finger_m), god(servo.contact.god_object_m);
        return (at - god).norm();
    };
    std::size_t found = 0;
    for (std::size_t i = 1; i < scene.scene_points()->count; ++i)
        if (depth(i) > depth(found)) found = i;
    return found;
}

/// As where a point's search had failed.
void drops_a_point(SceneState& scene, haptable_output /*out*/[]) {
    const std::size_t i = deepest(scene);
    haptable_point& point = scene.point_state(i);
    point.is_inside = point.presses = point.is_known = 0;
    std::fill_n(point.load_n, 3, 0.0F);
    haptable_servo& servo = scene.point_servo(i);
    const auto counters = servo.counters;
    haptable_servo_init(&servo);
    servo.counters = counters;
}

/// As where the search for those that press ends with none.
void lets_none_press(SceneState& scene, haptable_output /*out*/[]) {
    for (std::size_t i = 0; i < scene.scene_points()->count; ++i) {
        scene.point_state(i).presses = 0;
        std::fill_n(scene.point_state(i).load_n, 3, 0.0F);
    }
}

/// As gives_energy.
void gives_energy_by_points(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_tool_model nearest{};  // its points come first
    if (scene.tool() != nullptr) nearest = *scene.tool();
    nearest.points = *scene.scene_points();
    nearest.points.settle = nullptr;
    const haptable_points_scene of{scene.scene(), &nearest.points};
    haptable_step(&of.scene, scene.memory(), in, us, out);
}

/// More on the way out than on the way in.
void pushes_what_leaves(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    Vector3d last[2];
    for (std::size_t f = 0; f < scene.fingers(); ++f) last[f] = haptable::to_vector(scene.servo(f).finger_m);
    scene.step(in, us, out);
    for (std::size_t f = 0; f < scene.fingers(); ++f)
        if (haptable::to_vector(out[f].force_n).dot(haptable::to_vector(in[f].finger_m) - last[f]) > 0.0)
            scale(out[f].force_n, 1.5F);
}

/// Stuck where the contact began.
void never_slips(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_model sticky = *scene.scene().model;
    sticky.static_friction = sticky.kinetic_friction = 100.0F;
    haptable_servo_step(&sticky, &scene.servo(0), in->finger_m, us, out);
}

struct SpoiledCase {
    const char* what;
    TouchMode mode;
    Fault fault;
    StepOfScene* step;
};

class Spoiled : public testing::TestWithParam<SpoiledCase> {
protected:
    /// The cube under a servo that is well, or this one.
    Stroked cube(StepOfScene* step) const {
        static StrokedTables tables = [] {
            Scene scene = cube_scene(5, 0.3);
            scene.tables.columns = ColumnRows::kNone;
            return StrokedTables(scene);
        }();
        return Stroked(tables, GetParam().mode, step);
    }
};

TEST_P(Spoiled, IsSeen) {
    const auto fault = static_cast<std::size_t>(GetParam().fault);
    EXPECT_EQ(cube(step_scene).tally(7, 100).faulty[fault], 0U) << "a servo that is well";
    EXPECT_GT(cube(GetParam().step).tally(7, 100).faulty[fault], 0U);
}

/// The longest way of a finger, or of a tool's handle and turn, in a tick.
double longest_motion(const Stroke& stroke) {
    double longest = 0.0;
    for (std::size_t k = 1; k < stroke.size(); ++k)
        for (std::size_t f = 0; f < stroke[k].size(); ++f)
            longest = std::max(
                longest,
                (haptable::to_vector(stroke[k][f].data()) - haptable::to_vector(stroke[k - 1][f].data())).norm());
    return longest;
}

TEST_P(Spoiled, IsShrunkToFewTicks) {
    const Stroked spoiled = cube(GetParam().step);
    for (const Broken& broken : spoiled.tally(7, 100).broken) {
        if (!broken.verdict.has(GetParam().fault)) continue;
        const Touched touched = spoiled.touched.of_stroke(broken.number);
        const Stroke whole = spoiled.stroke(7, broken.number);
        const Stroke least = shrink(touched, whole, GetParam().fault);
        EXPECT_TRUE(judge(touched, least).has(GetParam().fault));
        EXPECT_LT(least.size(), whole.size());
        for (std::size_t i = 0; i < least.size(); ++i) {
            Stroke fewer = least;
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
            if (longest_motion(fewer) > 0.005) continue;
            EXPECT_FALSE(judge(touched, fewer).has(GetParam().fault)) << "tick " << i;
        }
        return;
    }
    FAIL() << "no stroke with the fault";
}

TouchMode consistent(GodObject god_object, bool friction, int fingers = 1, BodyKind body = {}) {
    return {ForceLaw::kConsistent, god_object, friction, fingers, body};
}
TouchMode by_tool(GodObject god_object, bool friction = false) {
    return {ForceLaw::kConsistent, god_object, friction, 1, {}, true};
}

TouchMode by_hands(GodObject god_object, bool friction = false) {
    return consistent(god_object, friction, HAPTABLE_HANDS);
}

// As where a god-object went over an edge with one of its coordinates.
constexpr auto kLosesAShare = [](SceneState& scene, haptable_output out[]) {
    if (in_contact(out[0]) && scene.servo(0).counters.ticks % 16 == 0) out->alpha[0] += 1e-6F;
};
constexpr auto kIsALittleSoft = [](SceneState&, haptable_output out[]) { scale(out->nodal_force_n, 0.9995F); };
// More than the contact's own: what nobody has paid for.
constexpr auto kIsALittleHard = [](SceneState&, haptable_output out[]) { scale(out->nodal_force_n, 1.0005F); };
constexpr auto kPushesTooHard = [](SceneState&, haptable_output out[]) {
    if (in_contact(out[0])) out->force_n[0] += 10.0F;
};
constexpr auto kClicks = [](SceneState& scene, haptable_output out[]) {
    if (in_contact(out[0]) && for_half_of_16_ticks(scene)) out->force_n[1] += 0.3F;
};
// A hand that is pushed more than the body is.
constexpr auto kPushesTheHand = [](SceneState& scene, haptable_output out[]) {
    for (std::size_t f = 0; f < scene.fingers(); ++f) scale(out[f].force_n, 1.5F);
};
// A body that is damped against the world; modes that swing up by themselves.
constexpr auto kDrags = [](SceneState& scene, haptable_output*) { scale(scene.body()->velocity_m_per_s, 0.9999F); };
constexpr auto kDampsTheTurn = [](SceneState& scene, haptable_output*) {
    scale(scene.body()->momentum_n_m_s, 0.9999F);
};
constexpr auto kSwingsUp = [](SceneState& scene, haptable_output*) { scale(scene.modes()->p, 1.1F); };
// As where a search ended before the loads of the points that are left were solved.
constexpr auto kIsNotSolved = [](SceneState& scene, haptable_output*) {
    scale(scene.point_state(deepest(scene)).load_n, 0.999F);
};
// And what is given is of those loads.
constexpr auto kIsNotSolvedOfHands = [](SceneState& scene, haptable_output out[]) {
    const std::size_t i = deepest(scene);
    scale(scene.point_state(i).load_n, 0.999F);
    scale(out[i].force_n, 0.999F);
    scale(out[i].nodal_force_n, 0.999F);
};
constexpr auto kPulls = [](SceneState& scene, haptable_output*) {
    scale(scene.point_state(deepest(scene)).load_n, -1.0F);
};
// A load that the body is not pressed by, and one that its hand does not feel.
constexpr auto kIsNotGiven = [](SceneState&, haptable_output out[]) { scale(out[2].force_n, 0.999F); };
constexpr auto kIsNotDrawn = [](SceneState&, haptable_output out[]) { scale(out[2].nodal_force_n, 0.999F); };
constexpr auto kTwistsTooHard = [](SceneState&, haptable_output out[]) {
    scale(reinterpret_cast<haptable_tool_output*>(out)->torque_n_m, 1.001F);
};

// clang-format off
const SpoiledCase kSpoiled[] = {
    {"NeverLetsGo", consistent(kNearest, false), Fault::kOutside, never_lets_go},
    {"DropsWhatIsDeep", consistent(kNearest, false), Fault::kLost, after<drops_what_is_deep>},
    {"PushesTooHard", consistent(kNearest, false), Fault::kForce, after<kPushesTooHard>},
    {"IsALittleSoft", consistent(kNearest, false), Fault::kLaw, after<kIsALittleSoft>},
    {"LoadsOneNode", consistent(kNearest, false), Fault::kDrawn, after<loads_one_node>},
    {"Clicks", consistent(kLeast, false), Fault::kJump, after<kClicks>},
    {"GivesEnergy", consistent(kLeast, false), Fault::kEnergy, gives_energy},
    {"NeverSlips", consistent(kNearest, true), Fault::kCone, never_slips},
    {"LosesAShare", consistent(kNearest, false), Fault::kArea, after<kLosesAShare>},
    {"LosesAShareOfTwo", consistent(kLeast, true, 2), Fault::kArea, after<kLosesAShare>},
    {"DropsWhatIsDeepOfTwo", consistent(kNearest, false, 2), Fault::kLost, after<drops_what_is_deep>},
    {"DropsWhatIsDeepInAFreeBody", consistent(kLeast, false, 1, kFree), Fault::kLost, after<drops_what_is_deep>},
    {"PushesWhatLeavesOfTwo", consistent(kLeast, false, 2), Fault::kEnergy, pushes_what_leaves},
    {"PushesWhatLeavesWhatRings", consistent(kLeast, false, 1, kRings), Fault::kEnergy, pushes_what_leaves},
    {"SwingsUp", consistent(kLeast, false, 1, kRings), Fault::kEnergy, after<kSwingsUp>},
    {"IsHardOnWhatRings", consistent(kLeast, false, 1, kRings), Fault::kLaw, after<kIsALittleHard>},
    {"PushesTheHandNotTheBody", consistent(kLeast, false, 1, kFree), Fault::kMomentum, after<kPushesTheHand>},
    {"Drags", consistent(kLeast, false, 2, kFree), Fault::kMomentum, after<kDrags>},
    {"DampsTheTurn", consistent(kNearest, false, 1, kFree), Fault::kMomentum, after<kDampsTheTurn>},
    {"DropsAPointOfATool", by_tool(kNearest), Fault::kLost, after<drops_a_point>},
    {"LetsNoPointOfAToolPress", by_tool(kLeast), Fault::kLost, after<lets_none_press>},
    {"IsNoSolutionOfATool", by_tool(kLeast, true), Fault::kLaw, after<kIsNotSolved>},
    {"PullsByATool", by_tool(kNearest), Fault::kPull, after<kPulls>},
    {"TwistsTooHard", by_tool(kLeast), Fault::kForce, after<kTwistsTooHard>},
    {"GivesEnergyByATool", by_tool(kLeast), Fault::kEnergy, gives_energy_by_points},
    {"DropsWhatIsDeepOfHands", by_hands(kNearest), Fault::kLost, after<drops_what_is_deep>},
    {"LetsNoHandPress", by_hands(kLeast, true), Fault::kLost, after<lets_none_press>},
    {"PushesOneHandTooHard", by_hands(kNearest), Fault::kForce, after<kPushesTooHard>},
    {"LosesAShareOfHands", by_hands(kLeast), Fault::kArea, after<kLosesAShare>},
    {"IsNoSolutionOfHands", by_hands(kLeast, true), Fault::kLaw, after<kIsNotSolvedOfHands>},
    {"IsNotGivenToItsHand", by_hands(kNearest), Fault::kLaw, after<kIsNotGiven>},
    {"IsNotDrawnOfHands", by_hands(kNearest), Fault::kLaw, after<kIsNotDrawn>},
    {"PullsByAHand", by_hands(kNearest), Fault::kPull, after<kPulls>},
    {"ClicksInAHand", by_hands(kNearest), Fault::kJump, after<kClicks>},
    {"GivesEnergyToHands", by_hands(kLeast), Fault::kEnergy, gives_energy_by_points},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Servo, Spoiled, testing::ValuesIn(kSpoiled),
                         [](const auto& one) { return std::string(one.param.what); });

}  // namespace
}  // namespace haptable::test
