// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies that ring, held and free, under hands of every kind: nothing makes energy but what a wall of the body's
// stiffness makes of the same hands.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "host/base/mass_range.hpp"
#include "tests/bodies.hpp"
#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/moving/walk.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

constexpr std::size_t kRinging = 8, kMouse = 7;  // the mouse under one finger: its coupling takes minutes to compute

Scene ringing_scene(std::size_t body, bool is_free, ForceLaw force, const std::filesystem::path& folder) {
    static const std::array<Shaped, 7> shaped{block(), plate(), rod(), ball(), ring(), lump(), noisy_scan()};
    if (body != kMouse) return scene_of(shaped[body], is_free, 8, force, 2, folder);
    Scene scene = mouse_scene();
    scene.body_modes = BodyModes{8, 0.05, is_free ? 0.0 : 1000.0, 0.0, 1};
    if (is_free) {
        scene.fixed.clear();
        scene.free_body = FreeBody{};
        scene.free_body->density_kg_per_m3 = 1000.0;
    }
    scene.contact = {};
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.008;
    scene.device = {};
    scene.device.max_force_n = 1e6;
    scene.device.limits = {};
    return scene;
}

struct Ringer {
    std::size_t body;
    bool is_free;
};
class Ringing : public testing::TestWithParam<Ringer> {};

// HAPTABLE_SESSIONS=... of each kind, of HAPTABLE_SECONDS=... each.
TEST_P(Ringing, MakesNoMoreThanAWallDoes) {
    const int sessions = asked("HAPTABLE_SESSIONS", 1), seconds = asked("HAPTABLE_SECONDS", 2);
    int all = 0, broken = 0, contact_ticks = 0;
    double worst_j = 0.0;
    std::string worst;
    const TemporaryFolder folder;
    const auto [body, is_free] = GetParam();
    for (const ForceLaw force : kForces) {
        const MovingTables tables(ringing_scene(body, is_free, force, folder.path() / word(force)));
        for (int kind = 0; kind < 8 * sessions; ++kind) {
            std::mt19937 random(static_cast<unsigned>(kind + 2000 * int(force)));
            Touching touching;
            touching.fingers = body == kMouse ? 1 : 1 + kind % 2;
            touching.friction = kind / 2 % 2 == 0 ? 0.0 : 0.8;
            touching.god_object = kind / 4 % 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest;
            MovingSession session(tables, touching);
            Walk walk(tables, session, touching, random);
            Ledger ledger(tables.stiffness_limit_n_per_m(), is_free ? &tables.rigid() : nullptr);
            for (int tick = 0; tick < 1000 * seconds; ++tick) {
                const Motion before = is_free ? session.motion() : Motion();
                session.step(walk.next());
                session.note(ledger, before);
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
    EXPECT_GT(contact_ticks, all * 1000 * seconds / (is_free ? 40 : 10));
}

// What a release adds to a contact's force brakes the hand, also where the surface swings under it.
TEST(RingingRelease, NeverPushesTheHand) {
    const TemporaryFolder folder;
    const MovingTables tables(ringing_scene(0, false, ForceLaw::kConsistent, folder.path() / "block"));
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

// Modes at either end of what is rendered (kLeastMode_hz, half of 1 kHz): hands feel numbers, and nothing makes energy.
TEST(RingingRange, EndsMakeNoMoreThanAWallDoes) {
    const TemporaryFolder folder;
    Scene scene = ringing_scene(0, false, ForceLaw::kConsistent, folder.path() / "block");
    const MovingTables middle(scene);
    const auto& omega = middle.body_modes()->omega_rad_per_s;
    const double density = scene.body_modes->density_kg_per_m3, to_hz = 0.5 / std::numbers::pi;
    const double slowest = to_hz * omega.front() / (1.001 * kLeastMode_hz), fastest = to_hz * omega.back() / 499.0;
    for (const double slower : {slowest, fastest}) {
        scene.body_modes->density_kg_per_m3 = density * slower * slower;
        const MovingTables tables(scene);
        for (unsigned number = 0; number < 4; ++number) {
            std::mt19937 random(number);
            Touching touching;
            touching.fingers = 1 + int(number % 2);
            MovingSession session(tables, touching);
            Walk walk(tables, session, touching, random);
            Ledger ledger(tables.stiffness_limit_n_per_m(), nullptr);
            for (int tick = 0; tick < 2000; ++tick) {
                session.step(walk.next());
                session.note(ledger, {});
                ASSERT_TRUE(session.felt(0).is_sound && std::isfinite(session.modes_j())) << number << ", " << tick;
            }
            EXPECT_LE(ledger.risen_j(), 64 * kFloat * ledger.largest_j() + ledger.rounded_j()) << slower;
        }
    }
}

constexpr std::array<const char*, kRinging> kNames{"block", "plate", "rod", "ball", "ring", "lump", "scan", "mouse"};
std::vector<Ringer> every_ringer() {
    std::vector<Ringer> all;
    for (const bool is_free : {false, true})
        for (std::size_t body = 0; body < kRinging; ++body) all.push_back({body, is_free});
    return all;
}
std::string name_of(const testing::TestParamInfo<Ringer>& info) {
    return std::string(info.param.is_free ? "free_" : "") + kNames[info.param.body];
}
INSTANTIATE_TEST_SUITE_P(Bodies, Ringing, testing::ValuesIn(every_ringer()), name_of);

}  // namespace
}  // namespace haptable::test
