// SPDX-License-Identifier: GPL-2.0-or-later
// A tool of many points that one hand holds: its loads, its wrench, and what it stores.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "firmware/haptable_tool.h"
#include "host/strokes/stroke.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "tests/firmware/on_target.hpp"
#include "tests/firmware/points.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/process.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

using Points = std::vector<std::array<float, 3>>;

const Quaterniond kUpright = Quaterniond::Identity();

/// Of a tool, beside how its points touch.
struct ToolOptions {
    double max_torque_n_m = 1e6;
    double stiffness_n_per_m = 0.0, turn_stiffness_n_m_per_rad = 0.0;  ///< of a virtual coupling
};

/// A body, and a tool whose hand a test moves by hand.
class Tool : public TouchingPoints {
public:
    Tool(const ElasticBody& body, Points points, const TouchOptions& touch = {}, const ToolOptions& options = {})
        : TouchingPoints(body, points.size(), touch), points_(std::move(points)) {
        pair_model_ = pair_in_memory(coupling(), tables(), model());
        haptable_points_model_make(&pair_model_, &tool_.points);
        tool_.points.count = static_cast<std::uint16_t>(points_.size());
        haptable_tool_lay_out(&tool_.points);
        tool_.point_m = reinterpret_cast<const float(*)[3]>(points_.data());
        tool_.max_torque_n_m = static_cast<float>(options.max_torque_n_m);
        tool_.stiffness_n_per_m = static_cast<float>(options.stiffness_n_per_m);
        tool_.turn_stiffness_n_m_per_rad = static_cast<float>(options.turn_stiffness_n_m_per_rad);
        for (const auto& r : points_) tool_.reach_m = std::max(tool_.reach_m, float(to_vector(r.data()).norm()));
        begin();
    }

    void begin() { TouchingPoints::begin(nullptr, &tool_); }
    const haptable_tool_output& to(const Vector3d& p, const Quaterniond& q = kUpright) {
        haptable_tool_input in{};
        for (int c = 0; c < 3; ++c) in.hand.finger_m[c] = float(p[c]);
        in.turn[0] = float(q.w());
        for (int c = 0; c < 3; ++c) in.turn[1 + c] = float(q.vec()[c]);
        in.hand.is_there = 1;
        return to(in);
    }
    const haptable_tool_output& to(const haptable_tool_input& in) {
        state().step(in, time_us += HAPTABLE_TICK_US, out);
        return out;
    }
    Vector3d force() const { return to_vector(out.hand.force_n); }
    Vector3d torque() const { return to_vector(out.torque_n_m); }
    /// The wrench of the points' loads, by the arms from the handle in the world's axes.
    Vector3d force_of_points() const {
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < count(); ++i) sum -= load(i);
        return sum;
    }
    Vector3d torque_of_points() const {
        const float* q = static_cast<const haptable_tool_state*>(memory())->turn;
        const Quaterniond turn{double(q[0]), double(q[1]), double(q[2]), double(q[3])};
        Vector3d sum = Vector3d::Zero();
        for (std::size_t i = 0; i < count(); ++i) sum -= (turn * to_vector(points_[i].data())).cross(load(i));
        return sum;
    }
    double reach() const { return double(tool_.reach_m); }
    const haptable_tool_model& tool() const { return tool_; }

    haptable_tool_output out{};

private:
    Points points_;
    haptable_pair_model pair_model_{};
    haptable_tool_model tool_{};
};

Quaterniond turn_by(const Vector3d& way) {
    return Quaterniond(
        Eigen::AngleAxisd(way.norm(), way.norm() > 0.0 ? Vector3d(way.normalized()) : Vector3d::UnitX()));
}

/// Presses the cube's top, tick by tick.
void press(Tool& tool, const Vector3d& to, const Quaterniond& q = kUpright, int ticks = 50) {
    for (int tick = 0; tick <= ticks; ++tick) tool.to(to + Vector3d(0, 0, 2e-4 * (ticks - tick)), q);
}

/// n x n points of a square, spacing apart, its middle at the handle.
Points grid(int n, double spacing_m) {
    Points points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            points.push_back({float((i - 0.5 * (n - 1)) * spacing_m), float((j - 0.5 * (n - 1)) * spacing_m), 0.0F});
    return points;
}

TEST(Tool, LoadsAreThoseOfDirectSolvesOfAllPointsThatPress) {
    for (const ForceLaw force : kCompliances) {
        const ElasticBody& body = coupled_cube(force);
        Tool tool(body, grid(3, 0.006));
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        double worst = 0.0;
        std::size_t most = 0;
        for (int trial = 0; trial < 200; ++trial) {
            tool.begin();
            const Vector3d p(0.015 + 0.003 * any(random), 0.015 + 0.003 * any(random), 0.030 - 0.0015);
            const Quaterniond q = Quaterniond(1.0, 0.08 * any(random), 0.08 * any(random), any(random)).normalized();
            tool.to(p + Vector3d(0, 0, 0.01), q);
            for (int tick = 1; tick <= 14; ++tick) tool.to(p + Vector3d(0, 0, 1e-3 * std::max(0, 10 - tick)), q);
            const std::vector<std::size_t> in = tool.pressing_points();
            worst = std::max(worst, tool.off_direct_loads());
            most = std::max(most, in.size());
            // A point out of T is outside of the surface as the others dent it.
            for (std::size_t i = 0; i < tool.count() && !in.empty(); ++i) {
                if (tool.point(i).presses || !tool.point(i).is_inside) continue;
                Vector3d gap = tool.dent(i);
                for (const std::size_t j : in) gap -= body.coupling(tool.point(i).at, tool.point(j).at) * tool.load(j);
                if (gap.dot(tool.normal(i)) > -1e-6 * body.size()) continue;
                // Or where one would have to pull if it were in T.
                std::vector<std::size_t> with = in;
                with.push_back(i);
                const VectorXd all = tool.direct_loads(with);
                bool pulls = false;
                for (std::size_t j = 0; j < with.size(); ++j)
                    pulls = pulls || all.segment<3>(3 * Eigen::Index(j)).dot(tool.normal(with[j])) > 0.0;
                EXPECT_TRUE(pulls) << trial << " " << i;
            }
        }
        RecordProperty(std::string("worst, ") + word(force), std::to_string(1e6 * worst) + "e-6");
        EXPECT_LT(worst, 1e-5) << force;
        EXPECT_GE(most, 6U);
    }
}

// C is kept from tick to tick, and only what couples a point that presses is written: whatever the points did on their
// way, steps that were taken back and points that friction holds among it, their loads are those of where they are.
TEST(Tool, LoadsStayThoseOfDirectSolvesOnTheWay) {
    for (const ForceLaw force : kCompliances)
        for (const double friction : {0.0, 0.3}) {
            Tool tool(coupled_cube(force), grid(3, 0.006),
                      {.god_object = GodObject::kLeastEnergy, .friction = friction});
            std::mt19937 random(5);
            std::normal_distribution<double> any;
            Vector3d p(0.015, 0.015, 0.030), way = Vector3d::Zero(), turn = Vector3d::Zero();
            double worst = 0.0;
            int pressed = 0, changed = 0;
            std::size_t last = 0;
            for (int tick = 0; tick < 4000; ++tick) {
                way = 0.98 * way + 1e-5 * Vector3d(any(random), any(random), any(random));
                p += way + 0.02 * (Vector3d(0.015, 0.015, 0.029) - p);
                turn = 0.995 * turn + 0.008 * Vector3d(any(random), any(random), any(random));
                tool.to(p, turn_by(turn));
                const std::size_t in = tool.pressing();
                if (in > 0) worst = std::max(worst, tool.off_direct_loads());
                pressed += in > 1;
                changed += in != last;
                last = in;
            }
            EXPECT_LT(worst, 1e-5) << force << " " << friction;
            EXPECT_GT(pressed, 1000) << force << " " << friction;
            EXPECT_GT(changed, 100) << force << " " << friction;
        }
}

struct ToolPose {
    Vector3d at;
    Quaterniond turn = kUpright;
};

/// What the hand got over a loop of poses, as a part of the most that was stored, and how many points pressed.
struct ToolLoop {
    double share = -1.0;
    std::size_t pressing = 0;
};

/// The work is that of the mean of two ticks' wrenches.
template <typename Pose>
ToolLoop go_around(Tool& tool, const Pose& pose) {
    constexpr int kTicks = 2000;
    ToolLoop loop;
    Work work;
    double turned_j = 0.0, stored_j = 0.0;
    Vector3d m0 = Vector3d::Zero();
    Quaterniond q0 = pose(LoopPhase(0.0)).turn;
    tool.begin();
    for (int tick = 0; tick <= kTicks; ++tick) {
        const ToolPose to = pose(LoopPhase(double(tick) / kTicks));
        tool.to(to.at, to.turn);
        work.add(to.at, tool.force());
        const Quaterniond by = to.turn * q0.conjugate();
        turned_j += (tool.torque() + m0).dot((by.w() < 0 ? -1.0 : 1.0) * by.vec());
        stored_j = std::max(stored_j, tool.energy());
        loop.pressing = std::max(loop.pressing, tool.pressing());
        q0 = to.turn;
        m0 = tool.torque();
    }
    loop.share = (work.given_j + turned_j) / stored_j;
    return loop;
}

TEST(Tool, ClosedLoopsOfThePoseGainNothingWithLeastEnergy) {
    for (const ForceLaw force : kCompliances) {
        Tool tool(coupled_cube(force), grid(3, 0.005), {.god_object = GodObject::kLeastEnergy});
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        double worst = -1.0;
        for (int trial = 0; trial < 20; ++trial) {
            const double a = 0.004 * any(random), b = 0.004 * any(random), tilt = 0.2 * any(random),
                         roll = 0.2 * any(random), yaw = 0.5 * any(random);
            const ToolLoop loop = go_around(tool, [&](const LoopPhase& at) {
                return ToolPose{{0.015 + a * (2 * at.slide - 1), 0.015 + b * (2 * at.slide - 1), 0.031 - 0.004 * at.in},
                                turn_by({tilt * at.swing, roll * at.swing, yaw * at.slide})};
            });
            worst = std::max(worst, loop.share);
        }
        RecordProperty(std::string("worst, ") + word(force), std::to_string(worst));
        EXPECT_LT(worst, 1e-3) << force;
    }
}

TEST(Tool, FrictionHoldsEachPointWithinItsConeAndLosesEnergy) {
    const double mu = 0.4;
    Tool tool(coupled_cube(ForceLaw::kPressureMask), grid(2, 0.008),
              {.god_object = GodObject::kLeastEnergy, .friction = mu});
    Tool free(coupled_cube(ForceLaw::kPressureMask), grid(2, 0.008), {.god_object = GodObject::kLeastEnergy});
    const Vector3d p(0.013, 0.015, 0.0285);
    press(tool, p);
    press(free, p);
    const double along0 = free.force().x();
    // Held: a small way aside is answered elastically, against it.
    for (int tick = 1; tick <= 20; ++tick) tool.to(p + Vector3d(5e-6 * tick, 0, 0));
    EXPECT_LT(tool.force().x(), along0 - 1e-3);
    // Slipping: every point's load lies in its cone.
    double most = 0.0;
    for (int tick = 1; tick <= 400; ++tick) {
        tool.to(p + Vector3d(1e-4 + 1e-5 * tick, 0, 0));
        if (tick >= 200) most = std::max(most, tool.steepest());
    }
    EXPECT_LT(most, mu * 1.1);
    EXPECT_GT(most, mu * 0.5);
    const ToolLoop loop = go_around(tool, [](const LoopPhase& at) {
        return ToolPose{{0.015 + 0.004 * std::sin(2 * M_PI * at.slide), 0.015, 0.031 - 0.003 * at.in}};
    });
    EXPECT_LT(loop.share, -0.1);
}

TEST(Tool, WhatIsNoPoseGivesNoWrench) {
    Tool tool(coupled_cube(ForceLaw::kConsistent), grid(3, 0.005));
    const Vector3d p(0.016, 0.014, 0.0285);
    const auto gives_nothing = [&](int state) {
        EXPECT_EQ(tool.out.hand.state, state);
        EXPECT_EQ(tool.force().norm(), 0.0);
        EXPECT_EQ(tool.torque().norm(), 0.0);
        EXPECT_EQ(tool.pressing(), 0U);
    };
    const double not_a_number = std::numeric_limits<double>::quiet_NaN();
    for (const auto& [z_m, turn] : {std::pair{not_a_number, kUpright},
                                    {HUGE_VAL, kUpright},
                                    {0.0285, Quaterniond(1, 0.1, 0, 0)},
                                    {0.0285, Quaterniond(1, 0, 0, HUGE_VAL)},
                                    {0.0285, Quaterniond(not_a_number, 0, 0, 0)},
                                    {0.0285, Quaterniond(0, 0, 0, 0)},
                                    {0.0285, Quaterniond(2, 0, 0, 0)},
                                    {0.0285, Quaterniond(1, not_a_number, 0, 0)}}) {
        press(tool, p);
        ASSERT_GT(tool.force().norm(), 0.0);
        tool.to({p.x(), p.y(), z_m}, turn);
        gives_nothing(HAPTABLE_REJECTED);
    }
    press(tool, p);
    ASSERT_GT(tool.torque().norm(), 0.0);
    EXPECT_EQ(haptable_tool_watch(&tool.scene(), tool.memory(), tool.time_us + HAPTABLE_SILENCE_US, &tool.out), 1U);
    EXPECT_EQ(tool.torque().norm(), 0.0);
    EXPECT_EQ(tool.force().norm(), 0.0);
    // A hand that went silent comes back inside: no contact before it has been outside.
    tool.time_us += 2 * HAPTABLE_SILENCE_US;
    tool.to(p);
    EXPECT_EQ(tool.force().norm(), 0.0);
    haptable_tool_input gone{};
    tool.to(gone);
    gives_nothing(HAPTABLE_SILENT);
}

TEST(Tool, ATurnThatNoHandMakesIsNotBelieved) {
    Tool tool(coupled_cube(ForceLaw::kConsistent), grid(3, 0.005), {.limits = {.max_speed_m_s = 1.0}});
    const Vector3d p(0.016, 0.014, 0.0285);
    press(tool, p);
    ASSERT_GT(tool.force().norm(), 0.0);
    tool.to(p, turn_by({0, 0, 1.0}));  // 5 mm at the farthest points, in a tick
    EXPECT_EQ(tool.out.hand.state, HAPTABLE_REJECTED);
    EXPECT_EQ(tool.torque().norm(), 0.0);
    for (int again = 0; again < 4; ++again) tool.to(p, turn_by({0, 0, again % 2 == 0 ? 0.0 : 1.0}));
    EXPECT_EQ(tool.out.hand.state, HAPTABLE_FAULTED);
    EXPECT_EQ(tool.out.hand.faults, HAPTABLE_FAULT_POSITIONS);
}

TEST(Tool, ForceAndTorqueKeepTheirLimits) {
    const double max_force_n = 0.05, max_torque_n_m = 1e-4, rate = 5.0;
    Tool tool(coupled_cube(ForceLaw::kConsistent), grid(3, 0.005),
              {.max_force_n = max_force_n, .limits = {.max_force_rate_n_per_s = rate}},
              {.max_torque_n_m = max_torque_n_m});
    Vector3d f0 = Vector3d::Zero(), m0 = Vector3d::Zero();
    double most_n = 0.0, most_n_m = 0.0;
    for (int tick = 0; tick < 400; ++tick) {
        tool.to({0.018, 0.013, 0.0305 - 1e-4 * tick * (tick < 30)}, turn_by({0.1, 0, 0}));
        const Vector3d f = tool.force(), m = tool.torque();
        const double step = 1.001 * 1e-3 * rate, per_m = max_force_n / max_torque_n_m;
        if (f.norm() > f0.norm()) {
            EXPECT_LE((f - f0).norm(), step) << tick;
        }
        if (m.norm() > m0.norm()) {
            EXPECT_LE(per_m * (m - m0).norm(), step) << tick;
        }
        most_n = std::max(most_n, f.norm()), most_n_m = std::max(most_n_m, m.norm());
        f0 = f, m0 = m;
    }
    EXPECT_LE(most_n, max_force_n * (1 + 4 * kFloat));
    EXPECT_LE(most_n_m, max_torque_n_m * (1 + 4 * kFloat));
    EXPECT_GT(most_n, 0.0);
    EXPECT_GT(most_n_m, 0.0);
}

TEST(Tool, PassivityTakesBackWhatTheNearestGodObjectGives) {
    // Both ways around: one of them gains.
    const auto most = [](bool passivity) {
        Tool tool(coupled_cube(ForceLaw::kPressureMask), grid(3, 0.005), {.passivity = passivity});
        double worst = 0.0;
        for (const bool back : {false, true}) {
            const ToolLoop loop = go_around(tool, [&](const LoopPhase& at) {
                const double slide = back ? 1.0 - at.slide : at.slide, aside = 0.004 * (2 * slide - 1);
                return ToolPose{{0.015 + aside, 0.015 - aside, 0.031 - 0.004 * at.in},
                                turn_by({0.2 * at.swing, 0.1 * at.swing, 0.4 * slide * at.in})};
            });
            worst = std::max(worst, loop.share);
        }
        return worst;
    };
    const double plain = most(false);
    EXPECT_GT(plain, 0.01);
    EXPECT_LT(most(true), 0.3 * plain);
}

TEST(Tool, AVirtualCouplingIsASpringBetweenHandAndTool) {
    const double k = 200.0, turn_k = 0.01;
    for (const GodObject god_object : every<GodObject>()) {
        Tool tool(coupled_cube(ForceLaw::kPressureMask), grid(3, 0.005), {.god_object = god_object},
                  {.stiffness_n_per_m = k, .turn_stiffness_n_m_per_rad = turn_k});
        const Vector3d p(0.017, 0.013, 0.0285);
        const Quaterniond q = turn_by({0.1, 0.05, 0.2});
        press(tool, p, q);
        for (int tick = 0; tick < 300; ++tick) tool.to(p, q);
        const Vector3d force = tool.force_of_points(), torque = tool.torque_of_points();
        ASSERT_GE(tool.pressing(), 3U);
        const Vector3d at = to_vector(tool.out.position_m);
        // Its wrench is the spring's, and at rest the contacts'.
        EXPECT_WITHIN((tool.force() - k * (at - p)).norm(), .count = 4,
                      .epsilon = kFloat * tool.body().size() * k / tool.force().norm(), .size = tool.force().norm());
        EXPECT_GT(at.z(), p.z() + 1e-4);
        EXPECT_LT((tool.force() - force).norm(), 1e-3 * force.norm()) << god_object;
        EXPECT_LT((tool.torque() - torque).norm(), 1e-3 * force.norm() * tool.reach()) << god_object;
        // Far from the body the tool is where the hand is.
        tool.to({0.1, 0.1, 0.1}, q);
        tool.to({0.1, 0.1, 0.1}, q);
        EXPECT_EQ(to_vector(tool.out.position_m), Vector3d(double(0.1F), double(0.1F), double(0.1F)));
        EXPECT_EQ(tool.force().norm(), 0.0);
    }
    // A loop of the hand's pose gains nothing: the tool goes where less is stored.
    Tool tool(coupled_cube(ForceLaw::kPressureMask), grid(3, 0.005), {.god_object = GodObject::kLeastEnergy},
              {.stiffness_n_per_m = k, .turn_stiffness_n_m_per_rad = turn_k});
    const ToolLoop loop = go_around(tool, [](const LoopPhase& at) {
        return ToolPose{{0.015 + 0.004 * (2 * at.slide - 1), 0.015, 0.031 - 0.004 * at.in},
                        turn_by({0.2 * at.swing, 0.1 * at.swing, 0.4 * at.slide})};
    });
    EXPECT_LT(loop.share, 1e-3);
    EXPECT_GE(loop.pressing, 3U);
}

struct ToolCase {
    const char* target;
    ForceLaw force;
    GodObject god_object;
    double friction = 0.0;
};

class ToolOnTarget : public testing::TestWithParam<ToolCase> {};

INSTANTIATE_TEST_SUITE_P(Modes, ToolOnTarget,
                         testing::Values(ToolCase{"cortex-m7", ForceLaw::kConsistent, GodObject::kNearest},
                                         ToolCase{"cortex-m7", ForceLaw::kPressureMask, GodObject::kNearest},
                                         ToolCase{"cortex-m7", ForceLaw::kConsistent, GodObject::kLeastEnergy},
                                         ToolCase{"cortex-m7", ForceLaw::kPressureMask, GodObject::kLeastEnergy, 0.3},
                                         ToolCase{"cortex-m4", ForceLaw::kPressureMask, GodObject::kLeastEnergy},
                                         ToolCase{"cortex-m33", ForceLaw::kConsistent, GodObject::kNearest},
                                         ToolCase{"rv32", ForceLaw::kPressureMask, GodObject::kLeastEnergy}),
                         [](const testing::TestParamInfo<ToolCase>& one) {
                             return test_name(std::string(one.param.target) + " " + word(one.param.force) + " " +
                                              word(one.param.god_object) +
                                              (one.param.friction > 0.0 ? " friction" : ""));
                         });

/// Strokes of the handle on a body whose image holds all pairs of its places, and of its turn.
TargetPath<6> tool_path(const ElasticBody& body, int strokes) {
    const StrokeMaker maker(body.servo());
    TargetPath<6> path;
    for (int number = 0; number < strokes; ++number) {
        std::mt19937_64 random(static_cast<std::uint64_t>(number));
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        const Vector3d a(any(random), any(random), any(random));
        int tick = 0;
        for (const auto& at : maker.make(23, static_cast<std::uint64_t>(number), 1)) {
            const Vector3d v = 0.4 * a * std::sin(0.01 * double(tick++));
            path.push_back({at[0][0], at[0][1], at[0][2], float(v[0]), float(v[1]), float(v[2])});
        }
    }
    return path;
}

// Four points run at 1 kHz on a Cortex-M7 at 600 MHz, at one instruction a clock (docs/COSTS.md).
TEST(ToolBound, OfFourPointsIsUnderNineTenthsOfAMillisecond) {
    for (const ForceLaw force : kCompliances)
        for (const GodObject god_object : every<GodObject>()) {
            const std::uint64_t most = most_tool_cost({force, god_object, ""}, 8, 4);
            RecordProperty(std::string(word(force)) + ", " + word(god_object), std::to_string(most));
            EXPECT_LT(most, 600'000U * 9 / 10) << force << " " << god_object;
        }
}

TEST_P(ToolOnTarget, OfFourPointsGivesTheHostsBitsInNineTenthsOfAMillisecond) {
    const ToolCase& one = GetParam();
    const TargetImage image(build_folder(), "cube", one.target);
    if (const std::string missing = image.missing(); !missing.empty()) GTEST_SKIP() << missing;
    const ElasticBody body(for_two(cube_scene(5, 0.3, one.force == ForceLaw::kPressureMask)), one.force, 0.012);
    Tool tool(body, grid(2, 0.006), {.god_object = one.god_object, .friction = one.friction});
    const TargetPath<6> path = tool_path(body, 40);
    const std::vector<TargetTick> ticks = image.measure({.model = *tool.scene().model, .tool = &tool.tool()}, path);
    tool.time_us = 0U - HAPTABLE_TICK_US;
    std::uint64_t worst = 0;
    std::size_t touching = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const haptable_tool_output& out = tool.to(pose_of(path[i]));
        const TargetTick::Finger& got = ticks[i].finger[0];
        ASSERT_TRUE(same(got, out.hand)) << i;
        ASSERT_EQ(std::memcmp(ticks[i].q.data(), out.torque_n_m, sizeof out.torque_n_m), 0) << i;
        worst = std::max(worst, ticks[i].instructions);
        touching += tool.pressing() > 1;
    }
    RecordProperty("worst_instructions", std::to_string(worst));
    const Mode mode{one.force, one.god_object, one.friction > 0.0 ? "friction" : ""};
    EXPECT_LT(worst, most_tool_cost(mode, 8, tool.count()));
    EXPECT_LT(worst, 600'000U * 9 / 10);
    EXPECT_GT(touching, path.size() / 20);
}

}  // namespace
}  // namespace haptable::test
