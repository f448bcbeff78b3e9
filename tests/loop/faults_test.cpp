// SPDX-License-Identifier: GPL-2.0-or-later
// Faults on purpose: whatever goes wrong between finger and servo, what must never be felt is not.
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/loop/faulty_session.hpp"
#include "tests/loop/limited_box.hpp"

namespace haptable::test {
namespace {

class FaultySession : public testing::Test {
protected:
    Watched run(const std::string& faults, double seconds = 3.5, std::uint64_t seed = 1) {
        const FaultPlan plan = faults.empty() ? FaultPlan{} : parse_faults(faults);
        const Watched watched = run_faulty_session(box.scene(), plan, seed, seconds);
        EXPECT_EQ(watched.violation, "") << faults;
        return watched;
    }

    /// Sessions of 2 s, in simulated time, each with a mixture by lot: what they came to together.
    Watched run_mixtures(const ServoScene& scene, std::uint64_t first, std::uint64_t count) {
        Watched sum;
        for (std::uint64_t seed = first; seed < first + count; ++seed) {
            const FaultPlan plan = random_faults(seed);
            const Watched watched = run_faulty_session(scene, plan, seed, 2.0);
            EXPECT_EQ(watched.violation, "") << "--seed " << seed << " --fault " << to_text(plan);
            sum.felt_ticks += watched.felt_ticks;
            sum.silences += watched.silences;
            sum.limited += watched.limited;
            sum.faulted += watched.faulted;
        }
        return sum;
    }

    SoftBox box;
};

TEST_F(FaultySession, OfAnyMixtureHarmNobody) {
    const Watched all = run_mixtures(box.scene(), 1, 200);
    // They are no quiet sessions, nor silent ones.
    EXPECT_GT(all.felt_ticks, 200 * 200);
    EXPECT_GT(all.silences, 200);
}

// The same under every limit of a scene: no step up, faults that latch, a force that comes back by a ramp.
TEST_F(FaultySession, OfAnyMixtureUnderEveryLimitRisesSlowly) {
    const LimitedBox limited;
    const Watched all = run_mixtures(limited.scene(), 1001, 100);
    EXPECT_GT(all.felt_ticks, 100 * 100);
    EXPECT_GT(all.limited, 1000);
    EXPECT_GT(all.faulted, 100);
}

TEST_F(FaultySession, OfTheSameSeedAreTheSame) {
    const std::string mixture = "drop=0.05,double=0.05,reorder=0.05,jitter=5ms,jump=0.001,gone=0.002,nan=0.001";
    const Watched one = run(mixture, 2.0, 7), same = run(mixture, 2.0, 7), other = run(mixture, 2.0, 8);
    EXPECT_EQ(one.forces, same.forces);
    EXPECT_EQ(one.device.missed, same.device.missed);
    EXPECT_EQ(one.device.largest_force_n, same.device.largest_force_n);
    EXPECT_NE(one.forces, other.forces);
}

TEST_F(FaultySession, DropLosesItsShareOfMessagesBothWays) {
    const Watched watched = run("drop=0.1");
    const auto ticks = static_cast<double>(watched.device.ticks);
    // Of n ticks, n p miss their answer with p = 1 - 0.9^2; 5 standard deviations.
    const double share = 1.0 - 0.9 * 0.9, deviation = std::sqrt(share * (1.0 - share) * ticks);
    EXPECT_NEAR(static_cast<double>(watched.device.missed), share * ticks, 5.0 * deviation);
}

// 11 ms there and 11 back: every answer is older than 20 ms, as if none had come.
TEST_F(FaultySession, DelayMakesEveryAnswerLateAndOfMoreThanSilenceGivesNoForce) {
    const Watched late = run("delay=4ms"), stale = run("delay=11ms");
    EXPECT_EQ(late.device.missed, late.device.ticks);
    EXPECT_NEAR(late.device.latency.mean_us(), 8000.0, 80.0 + 1000.0);
    EXPECT_GT(late.felt_ticks, 1000);
    EXPECT_EQ(stale.felt_ticks, 0);
    EXPECT_GT(stale.device.stale_answers, 1000);
    EXPECT_GE(stale.device.latency.max_us(), 22'000.0);
    EXPECT_EQ(stale.device.contact_ticks, 0);
}

// A clock that is set back is silence at most.
TEST_F(FaultySession, GoneAndBackIsSilenceOnBothSides) {
    const Watched gone = run("gone=0.005:100ms"), back = run("clock-back=0.003:200ms");
    EXPECT_GT(gone.silences, 3);
    EXPECT_GT(gone.device.silences, 3);
    EXPECT_GT(back.silences, 1);
    EXPECT_GT(back.felt_ticks, 300);
}

// A state and an answer that come twice change nothing.
TEST_F(FaultySession, DoubledMessagesAreNoTicks) {
    const Watched plain = run(""), doubled = run("double=0.5");
    EXPECT_GT(plain.felt_ticks, 800);
    for (const Watched& watched : {plain, doubled}) {
        EXPECT_EQ(watched.device.missed, 0);
        EXPECT_EQ(watched.felt_ticks, plain.felt_ticks);
        EXPECT_EQ(watched.device.largest_force_n, plain.device.largest_force_n);
    }
}

// What is live after one half of a session is all that is live after the other.
TEST_F(FaultySession, TakeNoMemory) {
    std::size_t half = 0, end = 0;
    const auto look = [&](std::int64_t tick) {
        if (tick == 10'000) half = mallinfo2().uordblks;
        if (tick == 19'999) end = mallinfo2().uordblks;
    };
    const FaultPlan plan =
        parse_faults("drop=0.01,double=0.05,reorder=0.05,corrupt=0.01,jitter=5ms,jump=0.001,gone=0.001,nan=0.001");
    EXPECT_EQ(run_faulty_session(box.scene(), plan, 3, 20.0, look).violation, "");
    ASSERT_GT(half, 0U);
    // A byte a tick would be 10,000.
    EXPECT_LT(end, half + 5000);
}

}  // namespace
}  // namespace haptable::test
