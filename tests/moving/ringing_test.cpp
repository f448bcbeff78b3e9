// SPDX-License-Identifier: GPL-2.0-or-later
// Bodies that ring, held and free, under hands of every kind: nothing makes energy but what a wall of the body's
// stiffness makes of the same hands.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "host/base/mass_range.hpp"
#include "tests/bodies.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/moving/walk.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

constexpr std::size_t kRinging = 8, kMouse = 7;  // the mouse under one finger: its coupling takes minutes to compute

Scene ringing_scene(std::size_t body, bool is_free, ForceLaw force) {
    static const std::array<Shaped, 7> shaped{block(), plate(), rod(), ball(), ring(), lump(), noisy_scan()};
    if (body != kMouse) return scene_of(shaped[body], is_free, 8, force, 2);
    Scene scene = mouse_scene();
    scene.body_modes = BodyModes{8, 0.05, is_free ? 0.0 : 1000.0, 0.0, 1};
    if (is_free) {
        set_free(scene);
    }
    scene.contact = {};
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.008;
    scene.device = {};
    scene.device.max_force_n = 1e6;
    scene.device.limits = {};
    return scene;
}

class Ringing : public testing::TestWithParam<std::tuple<std::size_t, bool>> {};  // body, whether it is free

/// A session of hands that walk; look: after each tick. What it made beyond a wall, J.
template <typename Look>
double walk(const MovingTables& tables, const Touching& touching, unsigned seed, int ticks, const Look& look) {
    std::mt19937 random(seed);
    MovingSession session(tables, touching);
    Walk walk(tables, session, touching, random);
    Ledger ledger = ledger_of(tables);
    for (int tick = 0; tick < ticks && !testing::Test::HasFatalFailure(); ++tick) {
        session.step(walk.next(), ledger);
        look(session, tick);
    }
    return made_j(ledger);
}

// HAPTABLE_SESSIONS=... of each kind, of HAPTABLE_SECONDS=... each.
TEST_P(Ringing, MakesNoMoreThanAWallDoes) {
    const int sessions = asked("HAPTABLE_SESSIONS", 1), ticks = 1000 * asked("HAPTABLE_SECONDS", 2);
    int all = 0, contact_ticks = 0;
    const auto [body, is_free] = GetParam();
    for (const ForceLaw force : kForces) {
        const MovingTables tables(ringing_scene(body, is_free, force));
        for (int kind = 0; kind < 8 * sessions; ++kind, ++all) {
            const Touching touching{.fingers = body == kMouse ? 1 : 1 + kind % 2,
                                    .god_object = kind / 4 % 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest,
                                    .friction = kind / 2 % 2 == 0 ? 0.0 : 0.8};
            SCOPED_TRACE(testing::Message() << word(force) << ", " << word(touching.god_object) << ", friction "
                                            << touching.friction << ", " << touching.fingers << " fingers");
            EXPECT_LE(walk(tables, touching, unsigned(kind + 2000 * int(force)), ticks,
                           [&](const MovingSession& session, int) { contact_ticks += session.touches(); }),
                      0.0);
        }
    }
    EXPECT_GT(contact_ticks, all * ticks / (is_free ? 40 : 10));
}

// What a release adds to a contact's force brakes the hand, also where the surface swings under it.
TEST(RingingRelease, NeverPushesTheHand) {
    const MovingTables tables(ringing_scene(0, false, ForceLaw::kConsistent));
    int held_ticks = 0;
    for (unsigned number = 0; number < 40; ++number) {
        const Touching touching{
            .fingers = 1 + int(number % 2), .friction = number / 2 % 2 == 0 ? 0.0 : 0.8, .release_n_per_ms = 0.01};
        std::array<Felt, 2> last{};
        walk(tables, touching, number, 2000, [&](const MovingSession& session, int tick) {
            for (int f = 0; f < touching.fingers; ++f) {
                const Felt& felt = session.felt(f);
                const Felt before = std::exchange(last[std::size_t(f)], felt);
                const Eigen::Vector3d released = felt.force_n + felt.load_n, way = felt.at_m - before.at_m;
                const double size = felt.force_n.norm() + felt.load_n.norm() + released.norm();
                held_ticks += felt.touches && released.norm() > 1e-3;
                if (tick == 0) continue;
                ASSERT_LE(released.dot(way), 64 * kFloat * size * (way.norm() + felt.at_m.norm()))
                    << "session " << number << ", tick " << tick << ", finger " << f;
            }
        });
    }
    EXPECT_GT(held_ticks, 400);
}

// Modes at either end of what is rendered (kLeastMode_hz, half of 1 kHz): hands feel numbers, and nothing makes energy.
TEST(RingingRange, EndsMakeNoMoreThanAWallDoes) {
    Scene scene = ringing_scene(0, false, ForceLaw::kConsistent);
    const MovingTables middle(scene);
    const auto& omega = middle.loaded().body_modes()->omega_rad_per_s;
    const double density = scene.body_modes->density_kg_per_m3, to_hz = 0.5 / std::numbers::pi;
    for (const double slower : {to_hz * omega.front() / (1.001 * kLeastMode_hz), to_hz * omega.back() / 499.0}) {
        scene.body_modes->density_kg_per_m3 = density * slower * slower;
        const MovingTables tables(scene);
        for (unsigned number = 0; number < 4; ++number)
            EXPECT_LE(walk(tables, {.fingers = 1 + int(number % 2)}, number, 2000,
                           [&](const MovingSession& session, int tick) {
                               ASSERT_TRUE(session.is_sound()) << slower << ", " << number << ", " << tick;
                           }),
                      0.0)
                << slower << ", " << number;
    }
}

constexpr std::array<const char*, kRinging> kNames{"block", "plate", "rod", "ball", "ring", "lump", "scan", "mouse"};
std::string name_of(const testing::TestParamInfo<std::tuple<std::size_t, bool>>& info) {
    const auto [body, is_free] = info.param;
    return std::string(is_free ? "free_" : "") + kNames[body];
}
INSTANTIATE_TEST_SUITE_P(Bodies, Ringing, testing::Combine(testing::Range<std::size_t>(0, kRinging), testing::Bool()),
                         name_of);

}  // namespace
}  // namespace haptable::test
