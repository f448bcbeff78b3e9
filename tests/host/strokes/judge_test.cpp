// SPDX-License-Identifier: GPL-2.0-or-later
// The judge of strokes: it must be right about bodies, and it must see every fault that it looks for.
#include <gtest/gtest.h>

#include <map>
#include <memory>
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
struct SpoiledCase {
    const char* what;
    StepOfScene* step;
    Fault fault;
    GodObject god_object;
    bool friction;
    int fingers = 1;
    BodyKind body = {};
    bool tool = false;

    TouchMode mode() const { return {ForceLaw::kConsistent, god_object, friction, fingers, body, tool}; }
};

bool in_contact(const haptable_output& out) { return out.state == HAPTABLE_CONTACT; }

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
void drops_what_is_deep(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
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

void pushes_too_hard(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    if (in_contact(out[0])) out->force_n[0] += 10.0F;
}

/// As where a god-object went over an edge with one of its coordinates.
void loses_a_share(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    if (in_contact(out[0]) && scene.servo(0).counters.ticks % 16 == 0) out->alpha[0] += 1e-6F;
}

void is_a_little_soft(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (auto& nodal : out->nodal_force_n)
        for (float& component : nodal) component *= 0.9995F;
}

/// More than the contact's own: what nobody has paid for.
void is_a_little_hard(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (auto& nodal : out->nodal_force_n)
        for (float& component : nodal) component *= 1.0005F;
}

/// All on one node: the sum is right, the picture is not.
void loads_one_node(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (int axis = 0; axis < 3; ++axis)
        for (int c = 1; c < 3; ++c) {
            out->nodal_force_n[0][axis] += out->nodal_force_n[c][axis];
            out->nodal_force_n[c][axis] = 0.0F;
        }
}

void clicks(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    if (in_contact(out[0]) && scene.servo(0).counters.ticks % 16 < 8) out->force_n[1] += 0.3F;
}

/// The force of a god-object that gives energy, for one that must not.
void gives_energy(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_model nearest = *scene.scene().model;
    nearest.god_object = haptable_god_object_nearest;
    nearest.release = nullptr;
    haptable_servo_step(&nearest, &scene.servo(0), in->finger_m, us, out);
}

/// The point of a tool whose depth is greatest.
std::size_t deepest(SceneState& scene) {
    const auto depth = [&](std::size_t i) {
        if (scene.point_state(i).is_inside == 0) return -1.0F;
        const haptable_servo& servo = scene.point_servo(i);
        Eigen::Map<const Eigen::Vector3f> at(servo.finger_m), god(servo.contact.god_object_m);
        return (at - god).norm();
    };
    std::size_t found = 0;
    for (std::size_t i = 1; i < scene.tool()->points.count; ++i)
        if (depth(i) > depth(found)) found = i;
    return found;
}

/// As where a point's search had failed.
void drops_a_point(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    const std::size_t i = deepest(scene);
    haptable_point& point = scene.point_state(i);
    point.is_inside = point.presses = point.is_known = 0;
    std::fill_n(point.load_n, 3, 0.0F);
    haptable_servo& servo = scene.point_servo(i);
    const auto counters = servo.counters;
    haptable_servo_init(&servo);
    servo.counters = counters;
}

/// As where a search ended before the loads of the points that are left were solved.
void is_not_solved(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& component : scene.point_state(deepest(scene)).load_n) component *= 0.999F;
}

void pulls(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& component : scene.point_state(deepest(scene)).load_n) component *= -1.0F;
}

void twists_too_hard(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& component : reinterpret_cast<haptable_tool_output*>(out)->torque_n_m) component *= 1.001F;
}

/// As gives_energy.
void gives_energy_by_a_tool(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_tool_model nearest = *scene.tool();
    nearest.points.settle = nullptr;
    const haptable_points_scene of{scene.scene(), &nearest.points};
    haptable_step(&of.scene, scene.memory(), in, us, out);
}

/// A hand that is pushed more than the body is.
void pushes_the_hand(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (std::size_t f = 0; f < scene.fingers(); ++f)
        for (float& component : out[f].force_n) component *= 1.5F;
}

/// More on the way out than on the way in.
void pushes_what_leaves(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    Vector3d last[2];
    for (std::size_t f = 0; f < scene.fingers(); ++f) last[f] = haptable::to_vector(scene.servo(f).finger_m);
    scene.step(in, us, out);
    for (std::size_t f = 0; f < scene.fingers(); ++f)
        if (haptable::to_vector(out[f].force_n).dot(haptable::to_vector(in[f].finger_m) - last[f]) > 0.0)
            for (float& component : out[f].force_n) component *= 1.5F;
}

/// A body that is damped against the world.
void drags(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& component : scene.body()->velocity_m_per_s) component *= 0.9999F;
}

void damps_the_turn(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& component : scene.body()->momentum_n_m_s) component *= 0.9999F;
}

/// Modes that swing up by themselves.
void swings_up(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    scene.step(in, us, out);
    for (float& p : scene.modes()->p) p *= 1.1F;
}

/// Stuck where the contact began.
void never_slips(SceneState& scene, const haptable_input in[], std::uint32_t us, haptable_output out[]) {
    haptable_model sticky = *scene.scene().model;
    sticky.static_friction = sticky.kinetic_friction = 100.0F;
    haptable_servo_step(&sticky, &scene.servo(0), in->finger_m, us, out);
}

class Spoiled : public testing::TestWithParam<SpoiledCase> {};

/// The cube, precomputed once for each way that it moves.
const StrokedBody& consistent_cube(const BodyKind& kind) {
    static const TemporaryFolder folder;
    static std::map<std::string, std::unique_ptr<StrokedBody>> made;
    auto& body = made[kind.name()];
    if (!body) {
        Scene scene = cube_scene(5, 0.3);
        scene.tables.columns = ColumnRows::kNone;
        BodyTables tables(scene, folder.path());
        body = std::make_unique<StrokedBody>(tables.with({ForceLaw::kConsistent, GodObject::kNearest, false, 2, kind}));
    }
    return *body;
}

/// The spoiled servo, or one that is well.
struct SpoiledCube {
    explicit SpoiledCube(const SpoiledCase& spoiled, StepOfScene* step)
        : body(consistent_cube(spoiled.body)),
          model(body, in_mode(Scene(), spoiled.mode()).contact,
                spoiled.tool ? body.random_tools(cube_scene(5, 0.3)) : std::vector<ToolTables>{}),
          touched(model.touched()),
          maker(body.servo()) {
        touched.step = step;
    }
    Tally stroke() const {
        Workers workers(1);
        return run_strokes(touched, maker, 7, 100, workers, [](std::size_t) {});
    }

    const StrokedBody& body;
    StrokedModel model;
    Touched touched;
    StrokeMaker maker;
};

TEST_P(Spoiled, IsSeen) {
    const auto fault = static_cast<std::size_t>(GetParam().fault);
    EXPECT_EQ(SpoiledCube(GetParam(), step_scene).stroke().faulty[fault], 0U) << "a servo that is well";
    EXPECT_GT(SpoiledCube(GetParam(), GetParam().step).stroke().faulty[fault], 0U);
}

TEST_P(Spoiled, IsShrunkToFewTicks) {
    const SpoiledCube cube(GetParam(), GetParam().step);
    for (const Broken& broken : cube.stroke().broken) {
        if (!broken.verdict.has(GetParam().fault)) continue;
        const Touched touched = cube.touched.of_stroke(broken.number);
        const Stroke whole = make_stroke(touched, cube.maker, 7, broken.number);
        const Stroke least = shrink(touched, whole, GetParam().fault);
        EXPECT_TRUE(judge(touched, least).has(GetParam().fault));
        EXPECT_LT(least.size(), whole.size());
        for (std::size_t i = 0; i < least.size(); ++i) {
            Stroke fewer = least;
            fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
            double longest = 0.0;
            for (std::size_t k = 1; k < fewer.size(); ++k)
                for (std::size_t f = 0; f < 2; ++f)
                    longest = std::max(
                        longest,
                        (haptable::to_vector(fewer[k][f].data()) - haptable::to_vector(fewer[k - 1][f].data())).norm());
            if (longest > 0.005) continue;
            EXPECT_FALSE(judge(touched, fewer).has(GetParam().fault)) << "tick " << i;
        }
        return;
    }
    FAIL() << "no stroke with the fault";
}

constexpr BodyKind kFree{1, false}, kRings{0, true};
constexpr auto kNearest = GodObject::kNearest, kLeast = GodObject::kLeastEnergy;

INSTANTIATE_TEST_SUITE_P(
    Servo, Spoiled,
    testing::Values(
        SpoiledCase{"NeverLetsGo", never_lets_go, Fault::kOutside, GodObject::kNearest, false},
        SpoiledCase{"DropsWhatIsDeep", drops_what_is_deep, Fault::kLost, GodObject::kNearest, false},
        SpoiledCase{"PushesTooHard", pushes_too_hard, Fault::kForce, GodObject::kNearest, false},
        SpoiledCase{"IsALittleSoft", is_a_little_soft, Fault::kLaw, GodObject::kNearest, false},
        SpoiledCase{"LoadsOneNode", loads_one_node, Fault::kDrawn, GodObject::kNearest, false},
        SpoiledCase{"Clicks", clicks, Fault::kJump, GodObject::kLeastEnergy, false},
        SpoiledCase{"GivesEnergy", gives_energy, Fault::kEnergy, GodObject::kLeastEnergy, false},
        SpoiledCase{"NeverSlips", never_slips, Fault::kCone, GodObject::kNearest, true},
        SpoiledCase{"LosesAShare", loses_a_share, Fault::kArea, kNearest, false},
        SpoiledCase{"LosesAShareOfTwo", loses_a_share, Fault::kArea, kLeast, true, 2},
        SpoiledCase{"DropsWhatIsDeepOfTwo", drops_what_is_deep, Fault::kLost, kNearest, false, 2},
        SpoiledCase{"DropsWhatIsDeepInAFreeBody", drops_what_is_deep, Fault::kLost, kLeast, false, 1, kFree},
        SpoiledCase{"PushesWhatLeavesOfTwo", pushes_what_leaves, Fault::kEnergy, kLeast, false, 2},
        SpoiledCase{"PushesWhatLeavesWhatRings", pushes_what_leaves, Fault::kEnergy, kLeast, false, 1, kRings},
        SpoiledCase{"SwingsUp", swings_up, Fault::kEnergy, kLeast, false, 1, kRings},
        SpoiledCase{"IsHardOnWhatRings", is_a_little_hard, Fault::kLaw, kLeast, false, 1, kRings},
        SpoiledCase{"PushesTheHandNotTheBody", pushes_the_hand, Fault::kMomentum, kLeast, false, 1, kFree},
        SpoiledCase{"Drags", drags, Fault::kMomentum, kLeast, false, 2, kFree},
        SpoiledCase{"DampsTheTurn", damps_the_turn, Fault::kMomentum, kNearest, false, 1, kFree},
        SpoiledCase{"DropsAPointOfATool", drops_a_point, Fault::kLost, kNearest, false, 1, {}, true},
        SpoiledCase{"IsNoSolutionOfATool", is_not_solved, Fault::kLaw, kLeast, true, 1, {}, true},
        SpoiledCase{"PullsByATool", pulls, Fault::kPull, kNearest, false, 1, {}, true},
        SpoiledCase{"TwistsTooHard", twists_too_hard, Fault::kForce, kLeast, false, 1, {}, true},
        SpoiledCase{"GivesEnergyByATool", gives_energy_by_a_tool, Fault::kEnergy, kLeast, false, 1, {}, true}),
    [](const auto& one) { return std::string(one.param.what); });

}  // namespace
}  // namespace haptable::test
