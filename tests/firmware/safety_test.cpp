// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's state machine (docs/SAFETY.md): what is not believed, what is limited, what latches, what a grab holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "tests/bodies.hpp"
#include "tests/firmware/ways.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A box's model with limits, and a finger on it.
class Guarded {
public:
    explicit Guarded(const SafetyLimits& limits = {}, GodObject god_object = GodObject::kNearest)
        : box_(box_shape(4, Vector3d(0.03, 0.03, 0.03)), 0.001, god_object), model_(*box_.get()) {
        Tables tables = box_.tables();
        tables.limits = limits;
        set_laws(tables, model_);
        model_.crc = haptable_crc_of(&model_, haptable_span_of_model);
        haptable_servo_init(&servo);
        check_tables(model_, servo);
    }

    const haptable_output& to(const Vector3d& x, std::uint32_t buttons = 0, std::uint32_t after_us = 1000) {
        const Eigen::Vector3f finger = x.cast<float>();
        finger_m = finger.cast<double>();
        before_n = to_vector(out.force_n);
        haptable_servo_buttons(&servo, buttons);
        haptable_servo_step(&model_, &servo, finger.data(), now_us += after_us, &out);
        return out;
    }
    /// Down onto the top, to a depth in m, over some ticks.
    void press(double depth, int ticks = 10) {
        for (int i = 0; i <= ticks; ++i) to(at(-0.001 + i * (depth + 0.001) / ticks));
    }
    /// Over the top's middle, so deep in it.
    static Vector3d at(double depth) { return {0.0131, 0.0172, 0.030 - depth}; }
    double force() const { return to_vector(out.force_n).norm(); }
    haptable_model& model() { return model_; }
    const TestModel& box() const { return box_; }

    haptable_servo servo{};
    haptable_output out{};
    std::uint32_t now_us = 0;
    Vector3d finger_m = Vector3d::Zero(), before_n = Vector3d::Zero();

private:
    TestModel box_;
    haptable_model model_;
};

/// The force is no farther than the limit's rise in a tick from what lies between none and the one before it.
void expect_rise(const Guarded& servo, double rise_n) {
    const Vector3d now = to_vector(servo.out.force_n), before = servo.before_n;
    const double size2 = before.squaredNorm();
    const double part = size2 > 0.0 ? std::clamp(now.dot(before) / size2, 0.0, 1.0) : 0.0;
    ASSERT_WITHIN((now - part * before).norm() - rise_n, .count = 64, .epsilon = kFloat, .size = now.norm() + rise_n)
        << "at " << servo.now_us << " us";
}

// ---- what is not believed -------------------------------------------------------------------------------------------

TEST(Plausible, AGlitchOfTheEncoderGivesNoForceAndContactBeginsAnewAfterGoodTicks) {
    Guarded servo({.max_speed_m_s = 5.0});
    servo.press(0.001);
    ASSERT_EQ(servo.out.state, HAPTABLE_CONTACT);
    servo.to(Guarded::at(0.026));
    EXPECT_EQ(servo.out.state, HAPTABLE_REJECTED);
    EXPECT_EQ(servo.force(), 0.0);
    for (int tick = 0; tick <= HAPTABLE_GOOD_TICKS; ++tick) {  // the way back is the second one
        servo.to(Guarded::at(0.001));
        EXPECT_EQ(servo.out.state, HAPTABLE_REJECTED) << tick;
        EXPECT_EQ(servo.force(), 0.0);
    }
    EXPECT_EQ(servo.servo.counters.implausible, 2U);
    servo.to(Guarded::at(0.001));
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE) << "it is inside, but nobody knows how it came there";
    servo.press(0.001);
    EXPECT_EQ(servo.out.state, HAPTABLE_CONTACT);
    EXPECT_EQ(servo.servo.counters.faulted, 0U);
}

TEST(Plausible, AFingerHasTheTimeBetweenTwoPositions) {
    Guarded servo({.max_speed_m_s = 5.0});
    servo.to(Guarded::at(-0.009));
    servo.to(Guarded::at(-0.0041));
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE) << "4.9 m/s";
    servo.to(Guarded::at(0.004), 0, 2000);
    EXPECT_EQ(servo.out.state, HAPTABLE_CONTACT) << "8.1 mm in 2 ms";
    servo.to(Guarded::at(-0.0012));
    EXPECT_EQ(servo.out.state, HAPTABLE_REJECTED) << "5.2 m/s";
}

// Two glitches within a second: there and back, twice.
TEST(Plausible, ASensorThatGlitchesAgainAndAgainIsAFaultThatLatches) {
    Guarded servo({.max_speed_m_s = 5.0});
    for (const double depth : {0.001, 0.021, 0.001}) servo.to(Guarded::at(depth));
    for (int tick = 0; tick < 30; ++tick) servo.to(Guarded::at(0.001));
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE);
    for (const double depth : {0.021, 0.001}) servo.to(Guarded::at(depth));
    for (int tick = 0; tick < 3000; ++tick) servo.to(Guarded::at(-0.001), HAPTABLE_BUTTON_ACKNOWLEDGE);
    EXPECT_EQ(servo.out.state, HAPTABLE_FAULTED) << "a button that is held down from before acknowledges nothing";
    EXPECT_EQ(int{servo.out.faults}, HAPTABLE_FAULT_POSITIONS);
    haptable_servo_watch(&servo.servo, servo.now_us += HAPTABLE_SILENCE_US, &servo.out);
    servo.press(0.001);
    EXPECT_EQ(servo.out.state, HAPTABLE_FAULTED) << "silence acknowledges nothing";
    EXPECT_EQ(servo.force(), 0.0);
    servo.to(Guarded::at(0.001), HAPTABLE_BUTTON_ACKNOWLEDGE);
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE);
    servo.press(0.001);
    EXPECT_EQ(servo.out.state, HAPTABLE_CONTACT);
    EXPECT_EQ(servo.servo.counters.faulted, 1U);
}

TEST(Plausible, AForceThatIsNoNumberLatches) {
    Guarded servo;
    std::vector<std::array<float, 6>> stiffness(servo.box().servo().stiffness_n_per_m);
    servo.press(0.001);
    for (auto& block : stiffness) block.fill(std::numeric_limits<float>::quiet_NaN());
    servo.model().stiffness_n_per_m = reinterpret_cast<const haptable_float6*>(stiffness.data());
    servo.to(Guarded::at(0.001));
    EXPECT_EQ(servo.force(), 0.0);
    servo.to(Guarded::at(0.001));
    EXPECT_EQ(servo.out.state, HAPTABLE_FAULTED);
    EXPECT_EQ(int{servo.out.faults}, HAPTABLE_FAULT_FORCE);
}

// ---- what is limited ------------------------------------------------------------------------------------------------

TEST(ForceRate, NoForceRisesFasterAndAllFallAtOnce) {
    Guarded servo({.max_force_rate_n_per_s = 100.0}), bare;
    for (Guarded* each : {&servo, &bare}) {
        each->to(Guarded::at(-0.0001));
        each->to(Guarded::at(0.004));
    }
    ASSERT_GT(bare.force(), 0.15) << "or nothing is limited";
    EXPECT_EQ(servo.out.state, HAPTABLE_LIMITED);
    for (int tick = 1; tick < 200; ++tick) {
        expect_rise(servo, 0.1);
        servo.to(Guarded::at(0.004 + 2e-5 * tick));
    }
    EXPECT_GT(servo.servo.counters.rate_limits, 0U);
    EXPECT_EQ(servo.servo.counters.limited_ticks, 200U);
    servo.to(Guarded::at(-0.001));
    EXPECT_EQ(servo.force(), 0.0);
    servo.press(0.0004, 40);
    EXPECT_EQ(servo.out.state, HAPTABLE_CONTACT) << "after leaving the whole force is there again";
}

// What the limit held back was not paid for, and is not given back: pressed fast, and lifted slowly.
TEST(ForceRate, GivesNoMoreEnergyThanWasPutIn) {
    Guarded servo({.max_force_rate_n_per_s = 50.0});
    double given_j = 0.0, taken_j = 0.0;
    const auto go = [&](double depth) {
        const Vector3d before_m = servo.finger_m, held_n = to_vector(servo.out.force_n);
        servo.to(Guarded::at(depth));
        const double work_j = held_n.dot(servo.finger_m - before_m);
        (work_j > 0.0 ? given_j : taken_j) += std::abs(work_j);
    };
    servo.to(Guarded::at(0.0));
    for (int tick = 1; tick <= 8; ++tick) go(0.0005 * tick);
    ASSERT_EQ(servo.out.state, HAPTABLE_LIMITED);
    for (int tick = 0; tick < 100; ++tick) go(0.004);
    for (int tick = 1; tick <= 4000; ++tick) go(0.004 - 1e-6 * tick);
    // A force that is held over a tick of the way in is half a tick's rise too small on the average.
    const double sampled_j = 0.5 * 0.0005 * (8 * 0.05);
    EXPECT_GT(given_j, 1e-5);
    EXPECT_LT(given_j, taken_j + sampled_j);
}

TEST(MeanForce, StaysBelowItsLimit) {
    const double time_s = 4.0;
    Guarded servo({.mean_force_n = 0.2, .mean_force_time_s = time_s});
    servo.press(0.004, 100);
    const double first_n = servo.force();
    ASSERT_GT(first_n, 0.3);
    double mean_n2 = 0.0;
    for (int tick = 0; tick < 20000; ++tick) {
        servo.to(Guarded::at(0.004 + 0.002 * std::sin(1e-3 * tick)));
        mean_n2 += kTick_s / time_s * (servo.force() * servo.force() - mean_n2);
        ASSERT_LE(mean_n2, 0.2 * 0.2 * (1.0 + 1e-3)) << tick;
        if (tick == 20) {
            EXPECT_GT(servo.force(), 0.9 * first_n) << "for a moment more may be given";
        }
    }
    EXPECT_LE(servo.force(), 0.2 * (1.0 + 1e-3));
    EXPECT_GT(servo.force(), 0.05);
    EXPECT_EQ(servo.out.state, HAPTABLE_LIMITED);
    EXPECT_GT(servo.servo.counters.mean_limits, 0U);
}

// ---- how a force comes back -----------------------------------------------------------------------------------------

TEST(ForceReturn, ByARampAtAStartInsideAndAfterSilence) {
    const double ramp_s = 0.1;
    Guarded servo({.ramp_s = ramp_s}), pressed;
    pressed.press(0.002, 100);
    for (int round = 0; round < 2; ++round) {
        int ticks = 0;
        for (double before_n = 0.0; servo.out.state != HAPTABLE_CONTACT; ++ticks) {
            servo.to(Guarded::at(0.002));
            ASSERT_LT(ticks, 200);
            EXPECT_GE(servo.force(), before_n);
            EXPECT_LE(servo.force() - before_n, 1.001 * pressed.force() * kTick_s / ramp_s);
            before_n = servo.force();
        }
        EXPECT_GE(ticks, 100);
        EXPECT_WITHIN(std::abs(servo.force() - pressed.force()), .count = 64, .epsilon = kFloat, .condition = 15.0,
                      .size = pressed.force());
        ASSERT_EQ(haptable_servo_watch(&servo.servo, servo.now_us += HAPTABLE_SILENCE_US, &servo.out), 1);
        EXPECT_EQ(servo.force(), 0.0);
    }
}

TEST(ForceReturn, NoRampForAFingerThatIsOutside) {
    for (const Vector3d& x : {Vector3d(0.0131, 0.0172, 0.0301), Vector3d(-0.001, 0.015, 0.015),
                              Vector3d(0.0301, 0.0301, 0.0301), Vector3d(0.2, 0.1, -0.3)}) {
        Guarded servo({.ramp_s = 0.1});
        for (int tick = 0; tick < 300; ++tick) {
            servo.to(x);
            ASSERT_EQ(servo.out.state, HAPTABLE_FREE);
            ASSERT_EQ(servo.force(), 0.0);
        }
    }
}

// ---- the grab -------------------------------------------------------------------------------------------------------

class Grab : public testing::TestWithParam<GodObject> {};
INSTANTIATE_TEST_SUITE_P(GodObjects, Grab, testing::ValuesIn(every<GodObject>()),
                         [](const auto& of) { return test_name(word(of.param)); });

TEST_P(Grab, HoldsThePointAndPullsUntilItIsReleased) {
    Guarded servo({.grab = true}, GetParam());
    servo.to(Guarded::at(-0.001), HAPTABLE_BUTTON_GRAB);
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE) << "there is nothing to hold";
    servo.press(0.001);
    const Vector3d held = to_vector(servo.out.god_object_m);
    for (int tick = 1; tick <= 40; ++tick) {
        const Vector3d aside(1e-4 * tick, 0.0, 0.0);
        servo.to(Guarded::at(0.001 - 1e-4 * tick) + aside, HAPTABLE_BUTTON_GRAB);
        ASSERT_EQ(servo.out.state, HAPTABLE_CONTACT) << tick;
        ASSERT_EQ(to_vector(servo.out.god_object_m), held);
        Vector3d wanted = Vector3d::Zero();
        for (int c = 0; c < 3; ++c)
            wanted -=
                double(servo.out.alpha[c]) * (servo.box().stiffness(servo.out.vertex[c]) * (servo.finger_m - held));
        ASSERT_WITHIN((to_vector(servo.out.force_n) - wanted).norm(), .count = 64, .epsilon = kFloat, .condition = 30.0,
                      .size = wanted.norm() + 0.01);
    }
    EXPECT_LT(servo.out.force_n[2], -0.05F) << "it pulls down";
    EXPECT_EQ(servo.servo.counters.grabbed_ticks, 40U);
    servo.to(servo.finger_m);
    EXPECT_EQ(servo.out.state, HAPTABLE_FREE);
    EXPECT_EQ(servo.force(), 0.0);
    servo.press(0.001);
    EXPECT_EQ(servo.out.state, HAPTABLE_CONTACT);
}

// A god-object of least energy hands its load to the force: that is to be of this finger, not of the last one.
TEST(GrabOfACompliance, PullsTwiceAsHardTwiceAsFar) {
    const ElasticBody& body = body_of_modes("cube", ForceLaw::kConsistent);
    WithLaws grabbed(body.model(GodObject::kLeastEnergy),
                     body.tables({.god_object = GodObject::kLeastEnergy, .limits = {.grab = true}}));
    Finger finger(grabbed.model());
    const auto to = [&](const Vector3d& x, std::uint32_t buttons = 0) {
        haptable_servo_buttons(&finger.servo(), buttons);
        finger.to(x);
        return finger.force();
    };
    to({0.0131, 0.0142, 0.0305});
    to({0.0131, 0.0142, 0.0299});
    ASSERT_TRUE(finger.touches());
    const Vector3d god = finger.god(), up(0.0, 0.0, 0.001);
    const Vector3d once = to(god + up, HAPTABLE_BUTTON_GRAB), twice = to(god + 2.0 * up, HAPTABLE_BUTTON_GRAB);
    ASSERT_TRUE(finger.touches());
    EXPECT_LT(once.z(), -0.05);
    // The finger's heights above the god-object are differences of positions thirty times as large.
    EXPECT_WITHIN((twice - 2.0 * once).norm(), .count = 32, .epsilon = kFloat, .condition = 30.0, .size = twice.norm());
}

// ---- everything at once ---------------------------------------------------------------------------------------------

/// What happens to one servo, by seed.
class Mixture {
public:
    Mixture(Guarded& servo, std::mt19937& random) : servo_(servo), random_(random) {}

    void run(int ticks) {
        x_ = Vector3d(uniform(-0.002, 0.032), uniform(-0.002, 0.032), uniform(0.02, 0.035));
        v_ = within(-1e-3, 1e-3);
        for (int tick = 0; tick < ticks && !testing::Test::HasFailure(); ++tick) once();
    }

private:
    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    Vector3d within(double low, double high) { return {uniform(low, high), uniform(low, high), uniform(low, high)}; }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_() % n); }
    bool one_in(std::uint32_t n) { return below(n) == 0; }

    void once() {
        if (one_in(8)) v_ = within(-2e-3, 2e-3);
        x_ += v_;
        if (one_in(40)) x_ = within(-0.01, 0.04);
        if (one_in(5)) buttons_ = below(8);
        if (one_in(25)) return silence();
        Vector3d seen = x_;
        if (one_in(30)) seen[static_cast<Eigen::Index>(random_() % 3U)] += one_in(2) ? 0.025 : -0.025;
        if (one_in(40)) seen[static_cast<Eigen::Index>(random_() % 3U)] = bad();
        servo_.to(seen, buttons_, one_in(10) ? below(30000) : 1000U);
        judge();
    }
    double bad() {
        const double bad[] = {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, 2.0};
        return bad[random_() % 5U];
    }
    void silence() {
        servo_.before_n = to_vector(servo_.out.force_n);
        servo_.now_us += 500U * below(50);
        if (haptable_servo_watch(&servo_.servo, servo_.now_us, &servo_.out) != 0) {
            EXPECT_EQ(servo_.out.state, HAPTABLE_SILENT);
            EXPECT_EQ(servo_.force(), 0.0);
        } else {
            EXPECT_LT(servo_.now_us - servo_.servo.position_us, HAPTABLE_SILENCE_US);
        }
    }
    void judge() {
        const Vector3d force_n = to_vector(servo_.out.force_n);
        const double most_n = double(servo_.model().max_force_n);
        expect_rise(servo_, double(servo_.model().rate_n));
        EXPECT_WITHIN(force_n.norm() - most_n, .count = 64, .epsilon = kFloat, .size = most_n);
        if (haptable_touches(servo_.out.state) == 0) {
            EXPECT_EQ(force_n.norm(), 0.0) << "state " << int{servo_.out.state};
        }
        EXPECT_EQ(servo_.out.faults != 0, servo_.out.state == HAPTABLE_FAULTED);
    }

    Guarded& servo_;
    std::mt19937& random_;
    Vector3d x_ = Vector3d::Zero(), v_ = Vector3d::Zero();
    std::uint32_t buttons_ = 0;
};

// No step up beyond the limit, no force above the largest, none in a state that has none, none after silence.
TEST(StateMachine, KeepsItsLimitsInAHundredThousandRandomSequences) {
    constexpr std::uint32_t haptable_counters::*kSeen[] = {
        &haptable_counters::limited_ticks, &haptable_counters::faulted, &haptable_counters::grabbed_ticks,
        &haptable_counters::rate_limits, &haptable_counters::silences};
    SafetyLimits limits{5.0, 400.0, 1.4, 5.0, 0.05, true, true};
    for (const GodObject god_object : every<GodObject>())
        for (const double ramp_s : {0.0, 0.05}) {
            limits.ramp_s = ramp_s;
            Guarded servo(limits, god_object);
            std::mt19937 random(1);
            std::uint32_t seen[std::size(kSeen)]{};
            for (int sequence = 0; sequence < 25000 && !HasFailure(); ++sequence) {
                if (random() % 4U == 0) {  // a new servo; the others go on from where they are
                    haptable_servo_init(&servo.servo);
                    check_tables(servo.model(), servo.servo);
                    servo.out = {};
                }
                Mixture(servo, random).run(40);
                for (std::size_t k = 0; k < std::size(kSeen); ++k)
                    seen[k] = std::max(seen[k], servo.servo.counters.*kSeen[k]);
            }
            for (const std::uint32_t count : seen) EXPECT_GT(count, 0U);
        }
}

}  // namespace
}  // namespace haptable::test
