// SPDX-License-Identifier: GPL-2.0-or-later
// Ten million ticks, almost three hours: nothing adds up, and the clock of 32 bits wraps twice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "codegen/in_memory.hpp"
#include "host/session/scene.hpp"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"

namespace haptable::test {
namespace {

constexpr std::size_t kLap = 1000;

using Path = std::vector<std::array<float, 3>>;

/// A lap that closes, of the turn's place: [kLap][3].
template <typename Place>
Path lap_of(const Place& place) {
    Path path;
    for (std::size_t tick = 0; tick < kLap; ++tick)
        path.push_back(to_finger(Eigen::Vector3d(place(2.0 * std::numbers::pi * double(tick) / kLap)).data()));
    return path;
}

/// Over the top of the cube and its rim, in and out.
Path lap() {
    return lap_of([](double turn) {
        return Eigen::Vector3d(0.015 + 0.012 * std::cos(turn), 0.015 + 0.016 * std::sin(turn),
                               0.0285 + 0.0025 * std::cos(5.0 * turn));
    });
}

struct Ran {
    haptable_servo servo{};
    std::uint64_t changed = 0;  ///< ticks whose force is not that of the second lap, bit for bit
    double most_given_j = 0.0, most_force_n = 0.0;
};

/// From the second lap on the servo comes to a lap's begin as it came to the last one's. `approach` goes before the
/// first.
Ran go_around(const haptable_model& model, std::uint32_t laps, const Path& path = lap(), const Path& approach = {}) {
    Path second(kLap);
    Ran ran;
    haptable_servo_init(&ran.servo);
    haptable_output out{};
    std::uint32_t now_us = 0;
    for (const auto& x : approach) haptable_servo_step(&model, &ran.servo, x.data(), now_us += HAPTABLE_TICK_US, &out);
    for (std::uint32_t l = 0; l < laps; ++l)
        for (std::size_t tick = 0; tick < kLap; ++tick) {
            haptable_servo_step(&model, &ran.servo, path[tick].data(), now_us += HAPTABLE_TICK_US, &out);
            if (haptable_servo_watch(&ran.servo, now_us + 1, &out) != 0) ++ran.changed;  // it was not silent
            ran.most_given_j = std::max(ran.most_given_j, double(ran.servo.given_j));
            ran.most_force_n = std::max(ran.most_force_n, to_vector(out.force_n).norm());
            if (l == 1) std::memcpy(second[tick].data(), out.force_n, sizeof out.force_n);
            if (l > 1) ran.changed += !same_bits(second[tick], out.force_n);
        }
    return ran;
}

TEST(HardDrift, TenMillionTicksGiveTheSameForcesLapAfterLap) {
    const ElasticBody cube(cube_scene(5, 0.49), ForceLaw::kInterpolated);
    const Ran ran = go_around(cube.model(), 10'000);
    EXPECT_EQ(ran.changed, 0U);
    EXPECT_EQ(ran.servo.counters.ticks, 10'000'000U);
    EXPECT_GT(ran.servo.counters.contact_ticks, 5'000'000U);
    EXPECT_EQ(ran.servo.counters.contacts % 10'000, 0U) << "as many in every lap";
    EXPECT_GE(ran.servo.counters.contacts, 10'000U);
    EXPECT_EQ(ran.servo.counters.silences, 0U);
    EXPECT_EQ(ran.servo.counters.given_up, 0U);
}

TEST(HardDrift, NorDoOtherModesDrift) {
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask})
        for (const GodObject god_object : every<GodObject>())
            EXPECT_EQ(go_around(body_of_modes("cube", force).model(god_object), 500).changed, 0U)
                << word(force) << " " << word(god_object);
}

// What was given less what was taken is a sum of all ticks: it is the one number that could drift. A spring that is
// held over a tick gives half its stiffness times the step's square, around a closed circle too; the brake takes it
// back. The lap stays in contact, a standing circle 3 mm below the cube's top.
TEST(HardDrift, NorDoesTheEnergyThatPassivityCounts) {
    constexpr double kRadius_m = 0.002;
    const ElasticBody cube(cube_scene(5, 0.49), ForceLaw::kInterpolated);
    const Tables tables = cube.tables({.passivity = true, .max_force_n = cube.tables().max_force_n});
    const Path path = lap_of([](double turn) {
        return Eigen::Vector3d(0.015 + kRadius_m * std::cos(turn), 0.015, 0.027 + kRadius_m * std::sin(turn));
    });
    const Ran ran = go_around(model_in_memory(tables, cube.servo()), 1000, path, {{path[0][0], path[0][1], 0.031F}});
    EXPECT_EQ(ran.servo.counters.contacts, 1U);
    const double step_m = kRadius_m * 2.0 * std::numbers::pi / kLap;
    EXPECT_LE(ran.most_given_j, ran.most_force_n * step_m) << "more than one tick gives before it is braked";
}

}  // namespace
}  // namespace haptable::test
