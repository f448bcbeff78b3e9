// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies that ring, held, under hands of every kind: nothing makes energy but what a wall of the body's
// stiffness makes of the same hands.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "tests/bodies.hpp"
#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/moving/walk.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

constexpr auto kForces = every<ForceLaw>();
constexpr std::size_t kBodies = 8, kMouse = 7;  // the mouse under one finger: its coupling takes minutes to compute

Scene ringing_scene(std::size_t body, ForceLaw force, const std::filesystem::path& folder) {
    static const std::array<Shaped, 7> shaped{block(), plate(), rod(), ball(), ring(), lump(), noisy_scan()};
    if (body != kMouse) return scene_of(shaped[body], false, 8, force, 2, folder);
    Scene scene = mouse_scene();
    scene.vibration = Vibration{8, 0.05, 1000.0, 0.0, 1};
    scene.contact = {};
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.008;
    scene.device = {};
    scene.device.max_force_n = 1e6;
    scene.device.limits = {};
    return scene;
}

class Ringing : public testing::TestWithParam<std::size_t> {};

// HAPTABLE_SESSIONS=... of each kind, of HAPTABLE_SECONDS=... each.
TEST_P(Ringing, MakesNoMoreThanAWallDoes) {
    const int sessions = asked("HAPTABLE_SESSIONS", 1), seconds = asked("HAPTABLE_SECONDS", 2);
    int all = 0, broken = 0, contact_ticks = 0;
    double worst_j = 0.0;
    std::string worst;
    const TemporaryFolder folder;
    for (const ForceLaw force : kForces) {
        const MovingTables tables(ringing_scene(GetParam(), force, folder.path() / word(force)));
        for (int kind = 0; kind < 8 * sessions; ++kind) {
            std::mt19937 random(static_cast<unsigned>(kind + 2000 * int(force)));
            Touching touching;
            touching.fingers = GetParam() == kMouse ? 1 : 1 + kind % 2;
            touching.friction = kind / 2 % 2 == 0 ? 0.0 : 0.8;
            touching.god_object = kind / 4 % 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest;
            MovingSession session(tables, touching);
            Walk walk(tables, session, touching, random);
            Ledger ledger(tables.stiffness_limit_n_per_m(), nullptr);
            for (int tick = 0; tick < 1000 * seconds; ++tick) {
                session.step(walk.next());
                session.note(ledger, {});
                contact_ticks += session.felt(0).touches || session.felt(1).touches;
            }
            ++all;
            if (ledger.risen_j() <= 64 * kFloat * ledger.largest_j() + ledger.rounded_j()) continue;
            ++broken;
            if (ledger.risen_j() <= worst_j) continue;
            worst_j = ledger.risen_j();
            worst = std::string(word(force)) + ", " + word(touching.god_object) +
                    (touching.friction > 0.0 ? ", friction" : "") + (touching.fingers == 2 ? ", two fingers" : "") +
                    ", session " + std::to_string(kind) + ", tick " + std::to_string(ledger.risen_tick());
        }
    }
    EXPECT_EQ(broken, 0) << "of " << all << " sessions; the most was " << 1e3 * worst_j << " mJ: " << worst;
    EXPECT_GT(contact_ticks, all * 1000 * seconds / 10);
}

// What a release adds to a contact's force brakes the hand, also where the surface swings under it.
TEST(RingingRelease, NeverPushesTheHand) {
    const TemporaryFolder folder;
    const MovingTables tables(ringing_scene(0, ForceLaw::kConsistent, folder.path() / "block"));
    int held_ticks = 0;
    for (unsigned number = 0; number < 40; ++number) {
        std::mt19937 random(number);
        Touching touching;
        touching.fingers = 1 + int(number % 2);
        touching.friction = number / 2 % 2 == 0 ? 0.0 : 0.8;
        touching.release_n_per_ms = 0.01;
        MovingSession session(tables, touching);
        Walk walk(tables, session, touching, random);
        std::array<Felt, 2> last{};
        for (int tick = 0; tick < 2000; ++tick) {
            session.step(walk.next());
            for (int f = 0; f < touching.fingers; ++f) {
                Felt& before = last[std::size_t(f)];
                const Felt felt = session.felt(f);
                const Eigen::Vector3d released = felt.force_n + felt.load_n, way = felt.at_m - before.at_m;
                const double size = felt.force_n.norm() + felt.load_n.norm() + released.norm();
                held_ticks += felt.touches && released.norm() > 1e-3;
                if (tick > 0) {
                    ASSERT_LE(released.dot(way), 64 * kFloat * size * (way.norm() + felt.at_m.norm()))
                        << "session " << number << ", tick " << tick << ", finger " << f;
                }
                before = felt;
            }
        }
    }
    EXPECT_GT(held_ticks, 400);
}

constexpr std::array<const char*, kBodies> kNames{"block", "plate", "rod", "ball", "ring", "lump", "scan", "mouse"};
std::string name_of_body(const testing::TestParamInfo<std::size_t>& info) { return kNames[info.param]; }
INSTANTIATE_TEST_SUITE_P(Bodies, Ringing, testing::Range<std::size_t>(0, kBodies), name_of_body);

}  // namespace
}  // namespace haptable::test
