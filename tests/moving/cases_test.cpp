// SPDX-License-Identifier: GPL-2.0-or-later
// The cases of ../shared/moving: scenes and paths of other people on which momentum, energy or the surface was lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/link/finger_path.hpp"
#include "tests/moving/adapter.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

const fs::path kCases = "../shared/moving";

class MovingCase : public testing::Test {
protected:
    void SetUp() override {
        if (!fs::exists(kCases)) GTEST_SKIP() << "no ../shared/moving";
    }

    /// Reads the scene NAME and the path NAME, or another one.
    void open(const std::string& name, const std::string& path = "") {
        tables = std::make_unique<MovingTables>(read_scene(kCases / (name + ".toml")));
        touching.by_scene = true;
        touching.fingers = tables->scene().contact.fingers;
        session = std::make_unique<MovingSession>(*tables, touching);
        at = read(path.empty() ? name : path);
    }
    static std::vector<std::array<Vector3d, 2>> read(const std::string& path) {
        std::vector<std::array<Vector3d, 2>> fingers;
        for (const FingerTick& tick : read_finger_ticks(kCases / (path + ".csv"), Positions::any)) {
            const auto second = tick.others.empty() ? std::array<double, 3>{} : tick.others[0].position_m;
            fingers.push_back({Vector3d(tick.position_m.data()), Vector3d(second.data())});
        }
        return fingers;
    }
    Motion before() const { return tables->is_free() ? session->motion() : Motion(); }
    bool touches() const { return session->felt(0).touches || session->felt(1).touches; }
    Vector3d force() const { return session->felt(0).force_n + session->felt(1).force_n; }

    std::unique_ptr<MovingTables> tables;
    std::unique_ptr<MovingSession> session;
    std::vector<std::array<Vector3d, 2>> at;
    Touching touching;
};

/// On the hand, of the contact that a finger felt.
Vector3d force_at(const haptable_model& model, const Felt& felt) {
    haptable_contact contact{};
    contact.patch = static_cast<std::uint16_t>(felt.patch);
    float finger_m[3], nodal_n[3][3], force_n[3];
    for (int c = 0; c < 3; ++c) {
        contact.alpha[c] = static_cast<float>(felt.alpha[c]);
        contact.god_object_m[c] = static_cast<float>(felt.god_m[c]);
        finger_m[c] = static_cast<float>(felt.at_m[c]);
    }
    model.force(&model, &contact, finger_m, nodal_n, force_n);
    return to_vector(force_n);
}

// The body has what the finger gave: F T, summed. What a finger has flicked moves on.
TEST_F(MovingCase, PushedOrFlickedBodyHasWhatTheHandGave) {
    for (const char* name : {"push", "flick"}) {
        open(name);
        Vector3d given = Vector3d::Zero();
        double roundings = 0.0;
        int contact_ticks = 0;
        for (const auto& finger : at) {
            session->step(finger);
            given -= kTick_s * force();
            roundings += kTick_s * force().norm() + session->motion().momentum.norm();
            contact_ticks += touches();
        }
        const Vector3d has = session->motion().momentum;
        EXPECT_WITHIN((has - given).norm(), .count = 16, .epsilon = kFloat, .size = roundings)
            << name << ": the finger gave " << 1e3 * given.norm() << " mN s, the body has " << 1e3 * has.norm();
        EXPECT_GT(contact_ticks, 0) << name;
        EXPECT_GT(has.norm(), name == std::string("push") ? 1e-3 : 0.0);
    }
}

// What is carried evenly needs no force along the way: the mean over the last 4 s is what the body's momentum can have
// changed by, which swings between the fingers, at its most from rest to twice their speed.
TEST_F(MovingCase, CarriedEvenlyNeedsNoForce) {
    open("carry");
    constexpr std::size_t kLast = 4000;
    double along = 0.0, roundings = 0.0;
    double from = 0.0;
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        if (tick + kLast == at.size()) from = session->motion().momentum.x();
        session->step(at[tick]);
        if (tick + kLast < at.size()) continue;
        along += force().x();
        roundings += force().norm() + session->felt(0).force_n.norm() + session->felt(1).force_n.norm();
        ASSERT_TRUE(session->felt(0).touches && session->felt(1).touches) << "tick " << tick;
    }
    const double weight = 9.81 * tables->rigid().mass_kg, speed = 0.1;
    const double gained = session->motion().momentum.x() - from;
    EXPECT_WITHIN(std::abs(kTick_s * along + gained), .count = 16, .epsilon = kFloat,
                  .size = kTick_s * roundings + double(kLast) * tables->rigid().mass_kg * speed);
    EXPECT_LE(std::abs(along / double(kLast)), 2.0 * tables->rigid().mass_kg * speed / (double(kLast) * kTick_s))
        << 1e3 * along / double(kLast) << " mN along the way, the weight is " << 1e3 * weight << " mN";
}

// After the finger has left, nothing changes: momentum to the last bit, energy to 100 roundings.
TEST_F(MovingCase, TumblesOnAsItWasLeft) {
    open("tumble");
    std::size_t last = 0;
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        session->step(at[tick]);
        if (touches()) last = tick;
    }
    session = std::make_unique<MovingSession>(*tables, touching);
    Motion left;
    double left_j = 0.0, energy = 0.0, turning = 0.0;
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        session->step(at[tick]);
        const Motion now = session->motion();
        if (tick == last + 1) left = now, left_j = session->motion_j();
        if (tick <= last + 1) continue;
        ASSERT_EQ(now.momentum, left.momentum) << "tick " << tick;
        energy = std::max(energy, std::abs(session->motion_j() - left_j));
        turning = std::max(turning, (now.spin_momentum - left.spin_momentum).norm());
    }
    EXPECT_GT(left_j, 0.0);
    EXPECT_WITHIN(energy, .count = 100, .epsilon = kFloat, .size = left_j);
    EXPECT_WITHIN(turning, .count = 100, .epsilon = kFloat, .size = left.spin_momentum.norm());
}

// Contact, modes and hand: no rise beyond rounding and what a wall makes of the hand.
TEST_F(MovingCase, RingingBodyMakesNoEnergy) {
    open("ring");
    Ledger ledger(tables->stiffness_limit_n_per_m(), nullptr);
    int contact_ticks = 0;
    for (const auto& finger : at) {
        session->step(finger);
        session->note(ledger, {});
        contact_ticks += touches();
    }
    EXPECT_GT(contact_ticks, 10);
    EXPECT_LE(ledger.risen_j(), 64 * kFloat * ledger.largest_j() + ledger.rounded_j())
        << "made beyond a wall's, of at most " << 1e3 * ledger.largest_j() << " mJ, at tick " << ledger.risen_tick();
}

// A god-object that goes over an edge is on the next patch with all of its coordinates.
TEST_F(MovingCase, GodObjectsKeepTheirCoordinatesOverEdges) {
    for (const char* name : {"alpha", "alphafree"}) {
        open(name);
        for (std::size_t tick = 0; tick < at.size(); ++tick) {
            session->step(at[tick]);
            for (int f = 0; f < 2; ++f)
                if (session->felt(f).touches) {
                    ASSERT_WITHIN(std::abs(session->felt(f).alpha.sum() - 1.0), .count = 4, .epsilon = kFloat)
                        << name << " tick " << tick << " finger " << f;
                }
        }
    }
}

// Around the loop no energy is given, and no force steps where a finger enters the face that the other has bulged.
TEST_F(MovingCase, LoopThroughARaisedFaceGivesNothing) {
    open("pairloop");
    double given_j = 0.0, paid_j = 0.0, step_n = 0.0;
    std::array<Felt, 2> last;
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        session->step(at[tick]);
        for (std::size_t f = 0; f < 2 && tick > 0; ++f) {
            const Felt& felt = session->felt(int(f));
            given_j += 0.5 * (felt.force_n + last[f].force_n).dot(felt.at_m - last[f].at_m);
            step_n = std::max(step_n, (felt.force_n - last[f].force_n).norm());
        }
        paid_j = std::max(paid_j, -given_j);
        last = {session->felt(0), session->felt(1)};
    }
    EXPECT_LE(given_j, 1e-3 * paid_j) << "of " << 1e6 * paid_j << " uJ";
    EXPECT_LE(step_n, 2.0 * tables->stiffness_limit_n_per_m() * 5e-5) << "two ways of 25 um a tick";
    EXPECT_GT(paid_j, 1e-4);
}

// In the plane of a face a finger is met once and let go once.
TEST_F(MovingCase, FingerInThePlaneOfAFaceDoesNotChatter) {
    open("chatter");
    int changes = 0, both = 0;
    double step_n = 0.0;
    std::array<Felt, 2> last;
    for (const auto& fingers : at) {
        session->step(fingers);
        for (std::size_t f = 0; f < 2; ++f) {
            changes += session->felt(int(f)).touches != last[f].touches;
            step_n = std::max(step_n, (session->felt(int(f)).force_n - last[f].force_n).norm());
        }
        last = {session->felt(0), session->felt(1)};
        both += last[0].touches && last[1].touches;
    }
    EXPECT_LE(changes, 4);
    EXPECT_LE(step_n, 2.0 * tables->stiffness_limit_n_per_m() * 5e-5);
    EXPECT_GT(both, 50);
}

// Where two fingers load one node alone, swapped ones feel swapped forces.
TEST_F(MovingCase, SwappedFingersNextToFixedNodesFeelSwappedForces) {
    open("lifted");
    std::vector<std::array<Vector3d, 2>> felt;
    for (const auto& fingers : at) {
        session->step(fingers);
        felt.push_back({session->felt(0).force_n, session->felt(1).force_n});
    }
    open("lifted", "lifted-swapped");
    int both = 0;
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        session->step(at[tick]);
        const double dents_m = (session->felt(0).inside_m - session->felt(0).god_m).norm() +
                               (session->felt(1).inside_m - session->felt(1).god_m).norm();
        for (std::size_t f = 0; f < 2; ++f)
            ASSERT_WITHIN((session->felt(int(f)).force_n - felt[tick][1 - f]).norm(), .count = 16, .epsilon = kFloat,
                          .condition = 64.0, .size = tables->stiffness_limit_n_per_m() * dents_m)
                << "tick " << tick;
        both += session->felt(0).touches && session->felt(1).touches;
    }
    EXPECT_GT(both, 50);
}

// A finger that stays comes to the force of K^-1 at its god-object, within 0.2 % and what the slowest mode still
// swings: 12 % after 2 s as the scene is (1.7 Hz, damped by a tenth of critical), nothing where it is damped by half.
TEST_F(MovingCase, HeldForceComesToThatOfTheBodyAtRest) {
    open("hold");
    Scene scene = tables->scene();
    scene.body_modes.reset();
    const MovingTables stiff(scene);
    const haptable_model model = model_in_memory(stiff.tables(), stiff.servo());
    for (const double damping : {tables->scene().body_modes->damping_ratio, 0.5}) {
        scene = tables->scene();
        scene.body_modes->damping_ratio = damping;
        session.reset();
        tables = std::make_unique<MovingTables>(scene);
        const double decay_per_s = damping * tables->body_modes()->omega_rad_per_s[0];
        for (const bool by_scene : {true, false}) {
            touching.by_scene = by_scene;  // nearest, or least energy
            touching.fingers = 1;
            session = std::make_unique<MovingSession>(*tables, touching);
            std::size_t moved = 0, compared = 0;
            for (std::size_t tick = 0; tick < at.size(); ++tick) {
                session->step(at[tick]);
                if (tick > 0 && at[tick][0] != at[tick - 1][0]) moved = tick;
                if (tick < moved + 2000 || !session->felt(0).touches) continue;
                const Vector3d felt_n = session->felt(0).force_n, rests_n = force_at(model, session->felt(0));
                const double swings = std::exp(-decay_per_s * kTick_s * static_cast<double>(tick - moved));
                ASSERT_LE((felt_n - rests_n).norm(), (2e-3 + swings) * rests_n.norm()) << "tick " << tick;
                ++compared;
            }
            EXPECT_GT(compared, 10000U);
        }
    }
}

// A mass of next to nothing is refused by name, or moves and is felt as numbers.
TEST_F(MovingCase, MassOfNextToNothingMakesNoNaN) {
    try {
        open("mass");
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("mass"), std::string::npos) << error.what();
        return;
    }
    for (std::size_t tick = 0; tick < at.size(); ++tick) {
        session->step(at[tick]);
        ASSERT_TRUE(force().allFinite() && session->motion().centre_m.allFinite() &&
                    session->motion().turn.coeffs().allFinite())
            << "tick " << tick;
    }
}

}  // namespace
}  // namespace haptable::test
