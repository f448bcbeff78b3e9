// SPDX-License-Identifier: GPL-2.0-or-later
// Three fingers and more on one body: each feels the dents that the others make.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "host/target/image.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/firmware/points.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A body, and as many fingers as a test says, which it moves by hand.
class Hands : public TouchingPoints {
public:
    Hands(const ElasticBody& body, std::size_t count, const TouchOptions& options = {})
        : TouchingPoints(body, count, options), out(count) {
        coupling().finger_count = static_cast<std::uint16_t>(count);
        pair_model_ = pair_in_memory(coupling(), tables(), model());
        begin(&pair_model_, nullptr);
    }
    /// One tick; a finger of which a number is none is not there.
    void to(const std::vector<Vector3d>& x) {
        std::vector<haptable_input> in(x.size());
        for (std::size_t i = 0; i < x.size(); ++i) {
            for (int c = 0; c < 3; ++c) in[i].finger_m[c] = float(x[i][c]);
            in[i].is_there = std::isnan(x[i].sum()) ? 0 : 1;
        }
        to(in);
    }
    void to(const std::vector<haptable_input>& in) { state().step(in.data(), time_us += HAPTABLE_TICK_US, out.data()); }
    Vector3d force(std::size_t i) const { return to_vector(out[i].force_n); }
    const haptable_pair_model& pair() const { return pair_model_; }
    int sets() { return state().points().sets; }

    std::vector<haptable_output> out;

private:
    haptable_pair_model pair_model_{};
};

const Vector3d kAway = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

/// Fingers around the cube, each so deep in its side; negative: outside.
std::vector<Vector3d> around(std::size_t count, double depth_m, double turn = 0.0, double up_m = 0.0) {
    std::vector<Vector3d> x;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = turn + 2.0 * std::numbers::pi * double(i) / double(count);
        const Vector3d out(std::cos(angle), std::sin(angle), 0.0);
        const double reach_m = (0.015 - depth_m) / std::max(std::abs(out.x()), std::abs(out.y()));
        x.push_back(Vector3d(0.015, 0.015, 0.019 + up_m) + reach_m * out);
    }
    return x;
}

void press(Hands& hands, std::size_t count, double depth_m, double turn = 0.0) {
    for (int tick = 0; tick <= 60; ++tick) hands.to(around(count, depth_m * tick / 60.0 - 1e-4 * (60 - tick), turn));
}

TEST(Hands, FingersThatAreSwappedFeelTheSame) {
    for (const GodObject god_object : every<GodObject>()) {
        const std::size_t count = 5;
        Hands hands(coupled_cube(ForceLaw::kPressureMask), count, {.god_object = god_object});
        Hands swapped(coupled_cube(ForceLaw::kPressureMask), count, {.god_object = god_object});
        double worst = 0.0, largest = 0.0;
        for (int tick = 0; tick <= 300; ++tick) {
            std::vector<Vector3d> x = around(count, 1e-5 * tick - 5e-4, 2e-3 * tick, 1e-5 * tick);
            x[2] += Vector3d(0, 0, 2e-5 * tick);
            hands.to(x);
            std::vector<Vector3d> other(x.rbegin(), x.rend());
            swapped.to(other);
            for (std::size_t i = 0; i < count; ++i) {
                worst = std::max(worst, (hands.force(i) - swapped.force(count - 1 - i)).norm());
                largest = std::max(largest, hands.force(i).norm());
            }
        }
        // The same system in another order: what C's condition leaves of a float's rounding. With least energy the
        // walks end within the tolerance of the model, over the depth.
        const double walked = god_object == GodObject::kLeastEnergy ? 4 * 0x1p-20 * 0.05 / 2.5e-3 : 0.0;
        EXPECT_LT(worst, (64 * 100 * kFloat + walked) * largest) << god_object;
        EXPECT_GT(largest, 0.01);
    }
}

// Also where one lets go, and the surface that it had raised under another falls on that one. Where many leap at once,
// who presses may be found in the next tick.
TEST(Hands, ThoseThatRestFeelTheSameInEveryTick) {
    for (const std::size_t count : {3U, 8U}) {
        Hands hands(coupled_cube(ForceLaw::kPressureMask), count);
        std::mt19937 random(1);
        std::uniform_real_distribution<double> depth_m(-0.001, 0.006);
        int raised = 0, late = 0;
        for (int leap = 0; leap < 400; ++leap) {
            std::vector<Vector3d> x;
            for (std::size_t i = 0; i < count; ++i) x.push_back(around(count, depth_m(random), 0.3)[i]);
            hands.to(x);
            for (int more = 0; more < 3 && hands.sets() > HAPTABLE_POINTS_SETS / 2; ++more, ++late) hands.to(x);
            const std::vector<haptable_output> before = hands.out;
            hands.to(x);
            for (std::size_t i = 0; i < count; ++i) {
                raised += hands.point(i).raised_m > 0.0F ? 1 : 0;
                EXPECT_LE((hands.force(i) - to_vector(before[i].force_n)).norm(), 64 * kFloat * hands.force(i).norm())
                    << count << " fingers, leap " << leap << ", finger " << i;
            }
        }
        EXPECT_GT(raised, 0);
        EXPECT_LE(late, 400 / 3);
    }
}

/// What all hands got, over the most that was stored, where all press, go around the body, each a way of its own up and
/// down, and let go.
double gained_share(Hands& hands, double way) {
    constexpr int kTicks = 2000;
    std::vector<Work> work(hands.count());
    double stored_j = 0.0, gained_j = 0.0;
    for (int tick = 0; tick <= kTicks; ++tick) {
        const LoopPhase phase(double(tick) / kTicks);
        std::vector<Vector3d> x = around(hands.count(), 0.003 * phase.in - 0.001, 0.4 + way * phase.slide);
        for (std::size_t i = 0; i < x.size(); ++i) x[i].z() += 0.003 * phase.swing * (i % 2 == 0 ? 1 : -1);
        hands.to(x);
        for (std::size_t i = 0; i < x.size(); ++i) work[i].add(x[i], hands.force(i));
        stored_j = std::max(stored_j, hands.energy());
    }
    for (const Work& one : work) gained_j += one.given_j;
    return gained_j / stored_j;
}

TEST(Hands, ClosedLoopsGainNothingWithLeastEnergy) {
    for (const ForceLaw force : kCompliances)
        for (const double way : {0.3, -0.3}) {
            Hands hands(coupled_cube(force), 4, {.god_object = GodObject::kLeastEnergy});
            const double share = gained_share(hands, way);
            RecordProperty(std::string(word(force)) + (way > 0 ? ", forward" : ", back"), std::to_string(share));
            EXPECT_LT(share, 1e-3) << force << " " << way;
        }
}

TEST(Hands, PassivityTakesBackWhatTheNearestGodObjectGives) {
    const auto most = [](bool passivity) {
        double worst = -1.0;
        for (const double way : {0.5, -0.5}) {
            Hands hands(coupled_cube(ForceLaw::kPressureMask), 4, {.passivity = passivity});
            worst = std::max(worst, gained_share(hands, way));
        }
        return worst;
    };
    const double plain = most(false);
    EXPECT_GT(plain, 1e-3);
    EXPECT_LT(most(true), 0.3 * plain);
}

TEST(Hands, FrictionHoldsEachFingerWithinItsCone) {
    const double mu = 0.4;
    const std::size_t count = 3;
    Hands hands(coupled_cube(ForceLaw::kPressureMask), count, {.god_object = GodObject::kLeastEnergy, .friction = mu});
    press(hands, count, 0.0015, 0.2);
    double most = 0.0;
    for (int tick = 1; tick <= 400; ++tick) {
        hands.to(around(count, 0.0015, 0.2, 1e-5 * tick));
        if (tick <= 200) continue;
        ASSERT_EQ(hands.pressing(), count);
        most = std::max(most, hands.steepest());
    }
    EXPECT_LT(most, mu * 1.1);
    EXPECT_GT(most, mu * 0.5);
}

TEST(Hands, EachKeepsItsLimitsAndItsFaults) {
    const std::size_t count = 3;
    const double max_force_n = 0.02;
    Hands hands(coupled_cube(ForceLaw::kConsistent), count,
                {.max_force_n = max_force_n, .limits = {.max_speed_m_s = 1.0, .max_force_rate_n_per_s = 5.0}});
    std::vector<Vector3d> before(count, Vector3d::Zero());
    for (int tick = 0; tick <= 60; ++tick) {
        hands.to(around(count, 1e-4 * tick - 1e-3));
        for (std::size_t i = 0; i < count; ++i) {
            if (hands.force(i).norm() > before[i].norm()) {
                EXPECT_LE((hands.force(i) - before[i]).norm(), 1.001 * 5e-3) << tick;
            }
            before[i] = hands.force(i);
            EXPECT_LE(before[i].norm(), max_force_n * (1 + 4 * kFloat));
        }
    }
    std::vector<Vector3d> x = around(count, 5e-3);
    std::vector<haptable_input> in(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (int c = 0; c < 3; ++c) in[i].finger_m[c] = float(x[i][c]);
        in[i].is_there = 1;
    }
    in[1].finger_m[0] = std::numeric_limits<float>::quiet_NaN();
    hands.to(in);
    EXPECT_EQ(hands.out[1].state, HAPTABLE_REJECTED);
    EXPECT_EQ(hands.force(1).norm(), 0.0);
    EXPECT_GT(hands.force(0).norm(), 0.0);
    EXPECT_GT(hands.force(2).norm(), 0.0);
    // One goes: the others press on, as if it had not been there.
    hands.to({x[0], kAway, x[2]});
    EXPECT_EQ(hands.out[1].state, HAPTABLE_SILENT);
    EXPECT_EQ(hands.pressing(), 2U);
    EXPECT_EQ(haptable_watch(&hands.scene(), hands.memory(), hands.time_us + HAPTABLE_SILENCE_US, hands.out.data()),
              7U);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(hands.force(i).norm(), 0.0);
}

}  // namespace
}  // namespace haptable::test
