// SPDX-License-Identifier: GPL-2.0-or-later
// Ten million ticks, almost three hours: nothing adds up, and the clock of 32 bits wraps twice.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "codegen/laws.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {
namespace {

constexpr int kLap = 1000;

using Path = std::vector<std::array<float, 3>>;

/// A lap over the top of the cube and its rim, in and out, that closes: [kLap][3].
Path lap() {
    Path path;
    for (int tick = 0; tick < kLap; ++tick) {
        const double turn = 2.0 * 3.14159265358979323846 * tick / kLap;
        path.push_back({float(0.015 + 0.012 * std::cos(turn)), float(0.015 + 0.016 * std::sin(turn)),
                        float(0.0285 + 0.0025 * std::cos(5.0 * turn))});
    }
    return path;
}

/// A lap that stays in contact, a standing circle 3 mm below the cube's top.
Path lap_below(double radius_m) {
    Path path;
    for (int tick = 0; tick < kLap; ++tick) {
        const double turn = 2.0 * 3.14159265358979323846 * tick / kLap;
        path.push_back({float(0.015 + radius_m * std::cos(turn)), 0.015F, float(0.027 + radius_m * std::sin(turn))});
    }
    return path;
}

struct Ran {
    haptable_servo servo;
    std::uint64_t changed = 0;  ///< ticks whose force is not that of the second lap, bit for bit
    double most_given_j = 0.0, most_force_n = 0.0;
};

/// From the second lap on the servo comes to a lap's begin as it came to the last one's. `approach` goes before the
/// first.
Ran go_around(const haptable_model& model, std::uint32_t laps, const Path& path = lap(), const Path& approach = {}) {
    Path second(kLap);
    Ran ran{};
    haptable_servo_init(&ran.servo);
    haptable_output out{};
    std::uint32_t now_us = 0;
    for (const auto& x : approach) haptable_servo_step(&model, &ran.servo, x.data(), now_us += HAPTABLE_TICK_US, &out);
    for (std::uint32_t l = 0; l < laps; ++l)
        for (std::size_t tick = 0; tick < kLap; ++tick) {
            haptable_servo_step(&model, &ran.servo, path[tick].data(), now_us += HAPTABLE_TICK_US, &out);
            if (haptable_servo_watch(&ran.servo, now_us + 1, &out) != 0) ++ran.changed;  // it was not silent
            ran.most_given_j = std::max(ran.most_given_j, double(ran.servo.given_j));
            ran.most_force_n = std::max(ran.most_force_n, std::hypot(double(out.force_n[0]), double(out.force_n[1]),  //
                                                                     double(out.force_n[2])));
            if (l == 1) std::memcpy(second[tick].data(), out.force_n, sizeof out.force_n);
            if (l > 1) ran.changed += std::memcmp(second[tick].data(), out.force_n, sizeof out.force_n) != 0;
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
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        const ElasticBody cube(cube_scene(5, 0.49), force, 0.012);
        for (const GodObject god_object : every<GodObject>()) {
            SCOPED_TRACE(testing::Message() << word(force) << " " << word(god_object));
            EXPECT_EQ(go_around(cube.model(god_object), 500).changed, 0U);
        }
    }
}

// What was given less what was taken is a sum of all ticks: it is the one number that could drift. A spring that is
// held over a tick gives half its stiffness times the step's square, around a closed circle too; the brake takes it
// back.
TEST(HardDrift, NorDoesTheEnergyThatPassivityCounts) {
    constexpr double kRadius_m = 0.002;
    constexpr std::uint32_t kLaps = 1'000;
    const ElasticBody cube(cube_scene(5, 0.49), ForceLaw::kInterpolated);
    Tables options;
    options.options.set("contact.passivity", true);
    options.max_force_n = cube.tables().max_force_n;
    haptable_model model = cube.model();
    set_laws(options, model);
    const Path path = lap_below(kRadius_m);
    const Ran ran = go_around(model, kLaps, path, {{path[0][0], path[0][1], 0.031F}});
    EXPECT_EQ(ran.servo.counters.contacts, 1U);
    const double step_m = kRadius_m * 2.0 * 3.14159265358979323846 / kLap;
    EXPECT_LE(ran.most_given_j, ran.most_force_n * step_m) << "more than one tick gives before it is braked";
}

}  // namespace
}  // namespace haptable::test
