// SPDX-License-Identifier: GPL-2.0-or-later
// modes, under one finger and under two: the force that is held, what a knock leaves, and what modes and contacts gain
// of a hand; and a body that nothing holds, with modes and without, in two hands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

#include "host/strokes/law.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Jelly: 10 kPa, 1000 kg/m^3. Its lowest mode has some 15 Hz.
Scene jelly(ForceLaw force, int modes, bool is_free = false) {
    Scene scene = cube_scene(5, 0.45);
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.012;
    if (is_free) set_free(scene);
    if (modes > 0) scene.body_modes = BodyModes{modes, 0.05, is_free ? 0.0 : 1000.0, 0.0, 1};
    scene.device.max_force_n = 20.0;
    scene.tables.columns = ColumnRows::kNone;
    return scene;
}

/// The tables of one that nothing holds, or that rings for long; made once.
const SceneFiles& jelly_of(int modes, bool is_free = false, double damping_ratio = 0.05) {
    static std::map<std::tuple<int, bool, double>, SceneFiles> made;
    const std::tuple which{modes, is_free, damping_ratio};
    if (const auto one = made.find(which); one != made.end()) return one->second;
    Scene scene = for_two(jelly(ForceLaw::kConsistent, modes, is_free));
    if (scene.body_modes) scene.body_modes->damping_ratio = damping_ratio;
    return made.emplace(which, files_of(scene)).first->second;
}

SceneFiles touched(SceneFiles files, GodObject god_object, double friction) {
    files.tables.god_object = god_object;
    files.tables.static_friction = files.tables.kinetic_friction = friction;
    return files;
}

/// A jelly under one finger or two, with its modes or still; body: null where it is held.
struct JellySession : LoadedScene, SceneSession {
    JellySession(const SceneFiles& jelly, std::size_t count, GodObject god_object, double friction = 0.0,
                 const haptable_body* body = nullptr)
        : LoadedScene(touched(jelly, god_object, friction)),
          SceneSession(model(), count == 2 ? pair() : nullptr, body, modes()),
          fingers(count) {}
    void step_both(const Vector3d& first_m, const Vector3d& second_m) {
        step(first_m, fingers == 2 ? std::optional(second_m) : std::nullopt);
    }
    /// Down to `depth` at 20 mm/s, the second less deep, and for so long there.
    void press(const Vector3d& first_m, const Vector3d& second_m, double depth_m, int ticks) {
        for (int i = 0; i < ticks; ++i) {
            const Vector3d down(0, 0, std::max(-depth_m, 0.002 - 2e-5 * i));
            step_both(first_m + down, second_m + 0.8 * down);
        }
    }
    void press(const Vector3d& at_m, double depth_m, int ticks) { press(at_m, at_m, depth_m, ticks); }
    bool all_touch() const { return touches(0) && (fingers == 1 || touches(1)); }
    VectorXd forces() const {
        VectorXd all(3 * fingers);
        for (std::size_t f = 0; f < fingers; ++f) all.segment<3>(Eigen::Index(3 * f)) = force(f);
        return all;
    }
    /// As the servo saw them.
    VectorXd places() const {
        VectorXd all(3 * fingers);
        for (std::size_t f = 0; f < fingers; ++f)
            all.segment<3>(Eigen::Index(3 * f)) = to_vector(state.account().past[f].finger_m);
        return all;
    }
    const haptable_modes_state& swung() { return *state.modes(); }

    const std::size_t fingers;
};

/// S of the contacts in double, by the tables.
MatrixXd stiffness_of(const JellySession& session) {
    std::vector<SurfacePoint> at;
    for (std::size_t f = 0; f < session.fingers; ++f)
        at.push_back({session.contact(f).patch, to_vector(session.contact(f).alpha)});
    return dense::inverse(Law(session.tables(), session.servo()).compliance(*session.pair(), at));
}

/// How the first mode moves the contacts.
VectorXd first_mode_at(const JellySession& session) {
    VectorXd phi = VectorXd::Zero(Eigen::Index(3 * session.fingers));
    for (std::size_t f = 0; f < session.fingers; ++f) {
        const haptable_contact& contact = session.contact(f);
        for (int c = 0; c < 3; ++c) {
            const std::uint16_t vertex = session.model().patch[contact.patch][c];
            if (vertex < session.model().free_count)
                phi.segment<3>(Eigen::Index(3 * f)) +=
                    double(contact.alpha[c]) * to_vector(session.modes()->shape[vertex]);
        }
    }
    return phi;
}

/// A force, a number each tick, swings about its last one by omega and falls off by exp(-decay t). A midpoint step is
/// slow by (omega T)^2 / 12. By how much omega may be off, rad/s.
double expect_ring(const std::vector<double>& force, double omega, double decay) {
    const double last = force.back();
    std::vector<double> crossing;  // upwards
    for (std::size_t i = 1; i < 400; ++i)
        if (force[i - 1] < last && force[i] >= last)
            crossing.push_back(kTick_s * (double(i) - (force[i] - last) / (force[i] - force[i - 1])));
    const double within = (std::pow(omega * kTick_s, 2.0) / 12.0 + 2e-3) * omega;
    EXPECT_GT(crossing.size(), 3U);
    if (crossing.size() < 2) return within;
    const double period = (crossing.back() - crossing.front()) / double(crossing.size() - 1);
    EXPECT_NEAR(2.0 * std::numbers::pi / period, omega, within);
    const auto most = [&](std::size_t from) {
        double size = 0.0;
        for (std::size_t i = from; i < from + 60; ++i) size = std::max(size, std::abs(force[i] - last));
        return size;
    };
    EXPECT_NEAR(std::log(most(0) / most(200)) / 0.2, decay, 0.1 * decay);
    return within;
}

const Vector3d kOnTop{0.0137, 0.0168, 0.03};
/// At nodes, for the interpolated force is exact there alone; and between them.
const Vector3d kAtNodes[2] = {{0.0075, 0.015, 0.03}, {0.0225, 0.015, 0.03}};
const Vector3d kBetweenNodes[2] = {{0.0067, 0.0168, 0.03}, {0.0227, 0.0131, 0.03}};

Vector3d up(double z_m) { return {0.0, 0.0, z_m}; }

class ModesUnder : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Fingers, ModesUnder, testing::Values(1, 2));

// Forces that are held come to those of the body without modes, at the same points of the surface, which friction
// keeps: L_rest and the modes make up L in all blocks of the pair.
TEST_P(ModesUnder, FingersThatStayIsFeltAsTheStaticForce) {
    for (const ForceLaw force : every<ForceLaw>()) {
        SCOPED_TRACE(word(force));
        const SceneFiles ringing = files_of(for_two(jelly(force, 8))), whole = files_of(for_two(jelly(force, 0)));
        const Vector3d* at = force == ForceLaw::kInterpolated ? kAtNodes : kBetweenNodes;
        JellySession session(ringing, GetParam(), GodObject::kNearest, 10.0),
            still(whole, GetParam(), GodObject::kNearest, 10.0);
        SceneSession rest(session.model(), GetParam() == 2 ? session.pair() : nullptr, nullptr, nullptr);
        session.press(at[0], at[1], 0.003, 4000);
        still.press(at[0], at[1], 0.003, 4000);
        ASSERT_TRUE(session.all_touch());
        for (int tick = 0; tick < 400; ++tick) {
            const Vector3d down = up(std::max(-0.003, 0.002 - 2e-5 * tick));
            rest.step(at[0] + down, GetParam() == 2 ? std::optional<Vector3d>(at[1] + 0.8 * down) : std::nullopt);
        }
        for (std::size_t f = 0; f < GetParam(); ++f) {
            ASSERT_EQ(to_vector(session.out[f].god_object_m), to_vector(still.out[f].god_object_m));
            const Vector3d wanted = still.force(f);
            // What rings yet: exp(-0.05 omega t) of it; and the rest's tables are floats of which the modes are a part.
            EXPECT_LT((session.force(f) - wanted).norm(), 2e-5 * wanted.norm()) << f;
            EXPECT_GT((rest.force(f) - wanted).norm(), 0.05 * wanted.norm()) << "the modes are a part of it";
        }
    }
}

// One mode under fingers that come and stay: the force swings with the frequency of the body so held, omega_c^2 =
// omega^2 + phi . S phi, and falls off as exp(-zeta omega t). A midpoint step is slow by (omega_c T)^2 / 12.
TEST_P(ModesUnder, FingersThatStayRings) {
    JellySession session(jelly_of(1), GetParam(), GodObject::kNearest, 10.0);
    const auto to = [&](const Vector3d& away) { session.step_both(kAtNodes[0] + away, kAtNodes[1] + away); };
    for (int tick = 0; tick < 4; ++tick) to(up(0.001));
    to(up(-0.002));
    std::vector<double> force;
    for (int tick = 0; tick < 2000; ++tick) {
        to({0.001, 0.0, -0.002});  // sideways is where the lowest mode goes
        const VectorXd f = session.forces();
        force.push_back(f[0] + (GetParam() == 2 ? f[3] : 0.0));
    }
    ASSERT_TRUE(session.all_touch());
    EXPECT_LE(session.state.account().owed_j, 0.0F) << "all is paid for";
    const double omega = session.body_modes()->omega_rad_per_s[0], zeta = 0.05;
    const VectorXd phi = first_mode_at(session);
    const MatrixXd s = stiffness_of(session);
    const double wanted = std::sqrt(omega * omega * (1.0 - zeta * zeta) + phi.dot(s * phi));
    const double within = expect_ring(force, wanted, zeta * omega);
    if (GetParam() == 1) return;
    const double alone =
        phi.head<3>().dot(s.block<3, 3>(0, 0) * phi.head<3>()) + phi.tail<3>().dot(s.block<3, 3>(3, 3) * phi.tail<3>());
    EXPECT_GT(std::abs(std::sqrt(omega * omega + alone) - wanted), 2.0 * within) << "what couples them is seen";
}

// Fingers that friction holds go to and fro by 10 um a tick: modes and contacts gain what they give, f . dx, and
// dx . S dx / 2 besides, but for what the modes' damping takes.
TEST_P(ModesUnder, FingersThatMoveGainsWhatTheHandsGave) {
    JellySession session(jelly_of(8, false, 1e-4), GetParam(), GodObject::kNearest, 10.0);
    session.press(kBetweenNodes[0], kBetweenNodes[1], 0.003, 400);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> part(-1e-5F, 1e-5F);
    Vector3d at[2] = {kBetweenNodes[0] - up(0.003), kBetweenNodes[1] - up(0.0024)};
    session.step_both(at[0], at[1]);
    const MatrixXd s = stiffness_of(session);
    double worst = 0.0, wall = 0.0;
    for (int tick = 0; tick < 500; ++tick) {
        const double before = session.all_j();
        const VectorXd load = -session.forces(), from = session.places();
        for (Vector3d& x : at) x += Vector3d(part(random), part(random), part(random));
        session.step_both(at[0], at[1]);
        const VectorXd moved = session.places() - from;
        const double own = 0.5 * moved.dot(s * moved);
        worst = std::max(worst, std::abs(session.all_j() - before - load.dot(moved) - own));
        wall = std::max(wall, own);
    }
    ASSERT_TRUE(session.all_touch());
    // Energies are floats of some twenty terms; damping takes 2 zeta omega of the swing's share in a tick.
    const double omega = session.body_modes()->omega_rad_per_s.back();
    EXPECT_WITHIN(worst, .count = 16, .epsilon = kFloat,
                  .size = session.all_j() * (1.0 + 2e-4 * omega * kTick_s / kFloat / 16.0));
    EXPECT_LT(worst, 0.1 * wall) << "so that the wall's part is seen";
}

// A finger that is refused, or is no number, pushes nothing: one alone leaves the modes to themselves, and the other of
// two is felt on.
TEST_P(ModesUnder, AFingerThatIsRefusedGoesOn) {
    JellySession session(jelly_of(8), GetParam(), GodObject::kLeastEnergy);
    session.press(kBetweenNodes[0], kBetweenNodes[1], 0.004, 1000);
    const VectorXd before = session.forces();
    double energy_j = HUGE_VAL;
    for (int tick = 0; tick < 2000; ++tick) {
        session.step_both(Vector3d(tick % 2 == 0 ? NAN : 1e30, 0.0, 0.0), kBetweenNodes[1] - up(0.0032));
        EXPECT_EQ(session.force(0), Vector3d::Zero());
        ASSERT_TRUE(session.forces().allFinite());
        if (GetParam() == 1) {
            EXPECT_LE(session.modes_j(), energy_j);
        }
        energy_j = session.modes_j();
    }
    EXPECT_GT(energy_j, 0.0);
    if (GetParam() == 1) return;
    EXPECT_TRUE(session.touches(1));
    EXPECT_GT(session.force(1).norm(), 0.9 * before.tail<3>().norm());
}

// After a slide, along which the modes moved each place of the surface otherwise, too: within a second to a hundredth
// of it, far below the fifth that a hand tells apart.
TEST(Modes, AForceAfterASlideComesToTheStaticOne) {
    const LoadedScene whole(jelly_of(0));
    const Vector3d from{0.0087, 0.0168, 0.03};
    for (const GodObject god_object : every<GodObject>())
        for (const double step_m : {3e-5, 3e-4}) {
            JellySession session(jelly_of(8), 1, god_object, 0.5);
            session.press(from, 0.003, 1500);
            const Vector3d end = from + Vector3d(0.006, 0.0, -0.003);
            for (double way_m = 0.0; way_m < 0.006; way_m += step_m) session.step(end - Vector3d(0.006 - way_m, 0, 0));
            session.step(end);
            const auto off = [&] {
                const Vector3d wanted = force_at(whole.model(), session.contact(), end);
                return (session.force() - wanted).norm() / wanted.norm();
            };
            EXPECT_GT(off(), 0.01) << "it swings";
            for (int tick = 0; tick < 1000; ++tick) session.step(end);
            EXPECT_LT(off(), 0.01) << "at " << step_m / kTick_s << " m/s";
        }
}

// What is left after a knock: each mode by itself, a damped cosine. The softer one has 0.4 Hz: a tick changes q by less
// than its rounding, now and then.
TEST(Modes, AKnockRingsAsTheClosedForm) {
    for (const auto& [young_pa, ticks] : {std::pair{1e4, 1000}, {10.0, 6000}}) {
        Scene scene = for_two(jelly(ForceLaw::kConsistent, 8));
        scene.material.young_pa = young_pa;
        JellySession session(files_of(scene), 1, GodObject::kLeastEnergy);
        session.press(kOnTop, 0.004, 320);
        ASSERT_TRUE(session.touches());
        session.step(kOnTop + up(0.004));
        session.step(kOnTop + up(0.006));
        ASSERT_FALSE(session.touches());
        const haptable_modes_state begin = session.swung();
        double largest = 0.0;
        for (int tick = 1; tick <= ticks; ++tick) {
            session.step(kOnTop + up(0.006));
            const double t = kTick_s * tick;
            for (int k = 0; k < 8; ++k) {
                const double omega = session.body_modes()->omega_rad_per_s[std::size_t(k)], zeta = 0.05;
                const double damped = omega * std::sqrt(1.0 - zeta * zeta);
                const double q = double(begin.q[k]), p = double(begin.p[k]);
                const double wanted =
                    std::exp(-zeta * omega * t) *
                    (q * std::cos(damped * t) + (p + zeta * omega * q) / damped * std::sin(damped * t));
                const double size = std::hypot(q, p / omega);
                largest = std::max(largest, size);
                // The tick's numbers are rounded once, and so are frequency and decay; its sums keep their rounding.
                EXPECT_WITHIN(std::abs(double(session.swung().q[k]) - wanted), .count = 2.0 * omega * t + 8.0,
                              .epsilon = kFloat, .size = size)
                    << "mode " << k << ", tick " << tick;
            }
        }
        EXPECT_GT(largest, 1e-5) << "it was knocked";
    }
}

// Out of contact the surface swings on where it was last touched, and what is told is where the finger is.
TEST(Modes, TheSurfaceIsMetWhereItSwings) {
    JellySession session(jelly_of(8), 1, GodObject::kLeastEnergy);
    session.press(kOnTop, 0.004, 300);
    const Vector3d away = kOnTop + up(0.01);
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int tick = 0; tick < 200; ++tick) {
        session.step(away);
        ASSERT_EQ(session.out[0].state, HAPTABLE_FREE);
        EXPECT_EQ(to_vector(session.out[0].god_object_m), away.cast<float>().cast<double>());
        low = std::min(low, double(session.swung().met[0].shift_m[2]));
        high = std::max(high, double(session.swung().met[0].shift_m[2]));
    }
    // The lowest mode that lifts the top has 21.9 Hz: some four swings.
    EXPECT_LT(low, -1e-4);
    EXPECT_GT(high, 1e-4);
}

TEST(Modes, OfABodyThatIsTooStiffAreRefused) {
    Scene scene = jelly(ForceLaw::kConsistent, 8);
    scene.body_modes->line = 12;
    for (const auto& [young_pa, words] :
         {std::pair{3e7, "remove modes"}, {1e-3, "0.01 Hz at least"}, {5e6, "write modes = "}}) {
        scene.material.young_pa = young_pa;
        const std::string error = error_of([&] { files_of(scene); });
        EXPECT_TRUE(says(error, words));
        EXPECT_TRUE(says(error, ":12: body.modes: mode "));
    }
}

haptable_body on_floor() {
    haptable_body body = cube_body();
    add_gravity(body);
    add_floor(body, 0.0, 0.5);
    return body;
}

// Taken between two fingers above its middle, so that it hangs, lifted, held for a minute, and let go: what the hands
// feel is its weight.
TEST(TwoFingers, LiftAndHoldABodyThatNothingHolds) {
    for (const auto& [modes, deep] : {std::pair{0, 0.0025}, {8, 0.005}}) {
        SCOPED_TRACE(modes);
        const haptable_body body = on_floor();
        JellySession session(jelly_of(modes, true), 2, GodObject::kLeastEnergy, 0.8, &body);
        const auto hold = [&](double in, double high) {
            session.step(Vector3d(in, 0.015, 0.02 + high), Vector3d(0.03 - in, 0.015, 0.02 + high));
        };
        const auto& state = *session.state.body();
        const auto height = [&] { return position_of(state).z() - double(body.centre_m[2]); };
        for (int tick = 0; tick < 500; ++tick) hold(-0.002 + (0.002 + deep) * tick / 500.0, 0.0);
        for (int tick = 0; tick < 1000; ++tick) hold(deep, 0.03 * tick / 1000.0);
        for (int tick = 0; tick < 20000; ++tick) hold(deep, 0.03);
        EXPECT_EQ(state.on_floor, 0);
        EXPECT_GT(height(), 0.03 - 0.003);
        const double weight = kMass_kg * 9.81;
        EXPECT_NEAR(-(session.force(0) + session.force(1)).z(), weight, 1e-3 * weight);
        const Vector3d held = position_of(state);
        const Eigen::Quaterniond turned = turn_of(state);
        VectorXd last = session.forces();
        double buzz = 0.0;
        for (int tick = 0; tick < 60000; ++tick) {
            hold(deep, 0.03);
            const VectorXd change = session.forces() - last;
            buzz = std::max({buzz, change.head<3>().norm(), change.tail<3>().norm()});
            last = session.forces();
        }
        // Far below what a hand tells apart, 10 um and 10 mN; the spacing of floats is 4 nm and 30 nN here.
        EXPECT_LT((position_of(state) - held).norm(), 1e-7);
        EXPECT_LT(turn_of(state).angularDistance(turned), 1e-6);
        EXPECT_LT(buzz, 1e-5);
        for (int tick = 0; tick < 1000; ++tick) hold(-0.005, 0.03);
        EXPECT_NE(state.on_floor, 0);
        EXPECT_LT(height(), 1e-3);
    }
}

// One of two alone does what one does in a scene with one, to the bit, and either may be that one.
TEST(TwoFingers, OneAloneIsAsInASceneWithOne) {
    const haptable_body floor = on_floor();
    for (const haptable_body* body : {static_cast<const haptable_body*>(nullptr), &floor})
        for (std::size_t number = 0; number < 2; ++number) {
            JellySession session(jelly_of(8, body != nullptr), 2, GodObject::kLeastEnergy, 0.8, body);
            SceneSession one(session.model(), nullptr, body, session.modes());
            for (int tick = 0; tick < 1000; ++tick) {
                const Vector3d at(0.0137 + 1e-5 * std::min(tick, 400), 0.0168, std::max(0.027, 0.032 - 2e-5 * tick));
                one.step(at);
                session.step(number == 0 ? std::optional(at) : std::nullopt,
                             number == 1 ? std::optional(at) : std::nullopt);
                ASSERT_EQ(session.force(number), one.force()) << tick;
                ASSERT_EQ(session.swung().q[0], one.state.modes()->q[0]) << tick;
                if (body != nullptr) {
                    ASSERT_EQ(position_of(*session.state.body()), position_of(*one.state.body())) << tick;
                }
            }
            EXPECT_GT(session.force(number).norm(), 0.05);
        }
}

TEST(TwoFingers, OneComesAndGoes) {
    JellySession session(jelly_of(8), 2, GodObject::kLeastEnergy);
    const Vector3d rests = kBetweenNodes[1] - up(0.003);
    for (int tick = 0; tick < 3000; ++tick) session.step({}, rests + up(std::max(0.0, 0.005 - 2e-5 * tick)));
    const Vector3d alone = session.force(1);
    for (int tick = 0; tick < 400; ++tick) session.step(kBetweenNodes[0] + up(0.002 - 1e-5 * tick), rests);
    ASSERT_TRUE(session.both_touch());
    EXPECT_LT(session.force(1).norm(), 0.995 * alone.norm()) << "the other dents it away";
    for (int tick = 0; tick < 4000; ++tick) session.step({}, rests);
    EXPECT_NEAR(session.force(1).norm(), alone.norm(), 0.01 * alone.norm());
}

}  // namespace
}  // namespace haptable::test
