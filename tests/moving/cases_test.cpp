// SPDX-License-Identifier: GPL-2.0-or-later
// The cases of ../shared/moving: scenes and paths of other people on which momentum, energy or the surface was lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/link/finger_path.hpp"
#include "tests/finger.hpp"
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
        begin(read_scene(kCases / (name + ".toml")));
        at.clear();
        for (const FingerTick& tick :
             read_finger_ticks(kCases / ((path.empty() ? name : path) + ".csv"), Positions::any)) {
            const auto second = tick.others.empty() ? std::array<double, 3>{} : tick.others[0].position_m;
            at.push_back({Vector3d(tick.position_m.data()), Vector3d(second.data())});
        }
    }
    void begin(const Scene& scene) {
        session.reset();
        tables.emplace(scene);
        begin_again();
    }
    void begin_again(bool by_scene = true) {
        session.emplace(*tables, Touching{.fingers = tables->scene().contact.fingers, .by_scene = by_scene});
    }
    /// look: after each tick.
    template <typename Look>
    void follow(const Look& look) {
        for (std::size_t tick = 0; tick < at.size() && !HasFatalFailure(); ++tick) {
            SCOPED_TRACE(testing::Message() << "tick " << tick);
            session->step(at[tick]);
            look(tick);
        }
    }

    std::optional<MovingTables> tables;
    std::optional<MovingSession> session;
    std::vector<TwoPoints> at;
};

/// On the hand, of the contact that a finger felt.
Vector3d force_at(const haptable_model& model, const MovingSession& session, int finger) {
    haptable_contact contact{};
    contact.patch = session.out(finger).patch;
    std::copy_n(session.out(finger).alpha, 3, contact.alpha);
    std::copy_n(session.out(finger).god_object_m, 3, contact.god_object_m);
    return test::force_at(model, contact, session.felt(finger).at_m);
}

// The body has what the finger gave: F T, summed. While nothing touches it nothing changes: momentum to the last bit,
// turning and energy to 100 roundings.
TEST_F(MovingCase, PushedOrFlickedBodyHasWhatTheHandGaveAndKeepsIt) {
    for (const auto& [name, least] : {std::pair{"push", 1e-3}, {"flick", 0.0}, {"tumble", 0.0}}) {
        SCOPED_TRACE(name);
        open(name);
        Vector3d given = Vector3d::Zero();
        double roundings = 0.0, left_j = 0.0;
        Motion left;
        int alone = 0;  // ticks since a touch
        follow([&](std::size_t) {
            const Motion now = session->motion();
            given -= kTick_s * session->force_n();
            roundings += kTick_s * session->force_n().norm() + now.momentum.norm();
            alone = session->touches() ? 0 : alone + 1;
            if (alone == 1) left = now, left_j = session->motion_j();
            if (alone <= 1) return;
            ASSERT_EQ(now.momentum, left.momentum);
            ASSERT_WITHIN((now.spin_momentum - left.spin_momentum).norm(), .count = 100, .epsilon = kFloat,
                          .size = left.spin_momentum.norm());
            ASSERT_WITHIN(std::abs(session->motion_j() - left_j), .count = 100, .epsilon = kFloat, .size = left_j);
        });
        EXPECT_WITHIN((left.momentum - given).norm(), .count = 16, .epsilon = kFloat, .size = roundings);
        EXPECT_GT(left.momentum.norm(), least);
        EXPECT_GT(alone, 1);
    }
}

// Contact, modes and hand: no rise beyond rounding and what a wall makes of the hand.
TEST_F(MovingCase, RingingBodyMakesNoEnergy) {
    open("ring");
    Ledger ledger = ledger_of(*tables);
    int contact_ticks = 0;
    for (const TwoPoints& finger : at) {
        session->step(finger, ledger);
        contact_ticks += session->touches();
    }
    EXPECT_GT(contact_ticks, 10);
    EXPECT_LE(made_j(ledger), 0.0);
}

// A god-object that goes over an edge is on the next patch with all of its coordinates.
TEST_F(MovingCase, GodObjectsKeepTheirCoordinatesOverEdges) {
    for (const char* name : {"alpha", "alphafree"}) {
        SCOPED_TRACE(name);
        open(name);
        follow([&](std::size_t) {
            for (int f = 0; f < 2; ++f)
                if (session->felt(f).touches) {
                    ASSERT_WITHIN(std::abs(to_vector(session->out(f).alpha).sum() - 1.0), .count = 4,
                                  .epsilon = kFloat);
                }
        });
    }
}

// Around the loop no energy is given, and no force steps where a finger enters the face that the other has bulged. In
// the plane of a face a finger is met once and let go once. Both go 25 um a tick.
TEST_F(MovingCase, LoopThroughARaisedFaceGivesNothingAndNoFaceChatters) {
    for (const char* name : {"pairloop", "chatter"}) {
        SCOPED_TRACE(name);
        open(name);
        Round round;
        int changes = 0, both = 0;
        std::array<bool, 2> touched{};
        follow([&](std::size_t) {
            round.add(*session);
            for (std::size_t f = 0; f < 2; ++f) {
                changes += session->felt(int(f)).touches != touched[f];
                touched[f] = session->felt(int(f)).touches;
            }
            both += session->both_touch();
        });
        EXPECT_LE(round.most_step_n(), 2.0 * tables->stiffness_n_per_m() * 5e-5);
        EXPECT_LE(changes, 4);
        EXPECT_GT(both, 50);
        if (name == std::string("chatter")) continue;
        EXPECT_LE(round.given_j(), 1e-3 * round.paid_j()) << "of " << 1e6 * round.paid_j() << " uJ";
        EXPECT_GT(round.paid_j(), 1e-4);
    }
}

TEST_F(MovingCase, SwappedFingersNextToFixedNodesFeelSwappedForces) {
    open("lifted");
    std::vector<TwoPoints> felt;
    follow([&](std::size_t) { felt.push_back({session->felt(0).force_n, session->felt(1).force_n}); });
    open("lifted", "lifted-swapped");
    int both = 0;
    follow([&](std::size_t tick) {
        double dents_m = 0.0;
        for (int f = 0; f < 2; ++f) dents_m += (session->felt(f).inside_m - session->felt(f).god_m).norm();
        for (std::size_t f = 0; f < 2; ++f)
            ASSERT_WITHIN((session->felt(int(f)).force_n - felt[tick][1 - f]).norm(), .count = 16, .epsilon = kFloat,
                          .condition = 64.0, .size = tables->stiffness_n_per_m() * dents_m);
        both += session->both_touch();
    });
    EXPECT_GT(both, 50);
}

// A finger that stays comes to the force of K^-1 at its god-object, within 0.2 % and what the slowest mode still
// swings: 12 % after 2 s as the scene is (1.7 Hz, damped by a tenth of critical), nothing where it is damped by half.
TEST_F(MovingCase, HeldForceComesToThatOfTheBodyAtRest) {
    open("hold");
    Scene scene = tables->scene();
    const BodyModes modes = *scene.body_modes;
    scene.body_modes.reset();
    const MovingTables stiff(scene);
    for (const double damping : {modes.damping_ratio, 0.5}) {
        scene.body_modes = modes;
        scene.body_modes->damping_ratio = damping;
        begin(scene);
        const double decay_per_s = damping * tables->loaded().body_modes()->omega_rad_per_s[0];
        for (const bool by_scene : {true, false}) {  // nearest, or least energy
            begin_again(by_scene);
            std::size_t moved = 0, compared = 0;
            follow([&](std::size_t tick) {
                if (tick > 0 && at[tick][0] != at[tick - 1][0]) moved = tick;
                if (tick < moved + 2000 || !session->touches()) return;
                const Vector3d rests_n = force_at(stiff.loaded().model(), *session, 0);
                const double swings = std::exp(-decay_per_s * kTick_s * static_cast<double>(tick - moved));
                ASSERT_LE((session->force_n() - rests_n).norm(), (2e-3 + swings) * rests_n.norm());
                ++compared;
            });
            EXPECT_GT(compared, 10000U);
        }
    }
}

}  // namespace
}  // namespace haptable::test
