// SPDX-License-Identifier: GPL-2.0-or-later
// A body that is not held, against closed forms of its motion, and its energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bodies.hpp"
#include "tests/moving_body.hpp"
#include "tests/scene_session.hpp"

namespace haptable::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// What the issue asks for: of the motion itself.
constexpr double kForm = 1e-4;
// Sums of float32 over n ticks that are kept with their rest: a few roundings of what is summed.
constexpr double kSum = 64.0 * kFloat;

class BodyTest : public testing::Test {
protected:
    void begin() { haptable_body_init(&body, &state); }
    void move(int ticks = 1) {
        for (int i = 0; i < ticks; ++i) haptable_body_move(&body, &state);
    }
    void push(const Vector3d& at, const Vector3d& force) {
        const Eigen::Vector3f at_m = at.cast<float>(), force_n = force.cast<float>();
        haptable_body_kick(&body, &state, at_m.data(), force_n.data());
        move();
    }
    /// Body axes.
    void spin(const Vector3d& rad_per_s) {
        Eigen::Matrix3d inertia;
        const float* j = body.inertia_kg_m2;
        inertia << double(j[0]), double(j[3]), double(j[5]), double(j[3]), double(j[1]), double(j[4]), double(j[5]),
            double(j[4]), double(j[2]);
        const Vector3d momentum = turn_of(state) * (inertia * rad_per_s);
        for (int c = 0; c < 3; ++c) {
            state.momentum_n_m_s[c] = static_cast<float>(momentum[c]);
            state.spin_rad_per_s[c] = static_cast<float>(rad_per_s[c]);
        }
    }
    double energy() const { return energy_of(body, state); }
    Vector3d moved() const { return position_of(state) - to_vector(body.centre_m); }
    double angle() const { return 2.0 * std::atan2(turn_of(state).vec().norm(), turn_of(state).w()); }

    haptable_body body = cube_body();
    haptable_body_state state{};
};

TEST_F(BodyTest, FallsFreely) {
    add_gravity(body);
    begin();
    for (int tick = 1; tick <= 1000; ++tick) {
        move();
        const double t = tick * kTick_s;
        ASSERT_NEAR(moved().z(), -0.5 * 9.81 * t * t, kForm * 0.5 * 9.81 * t * t) << tick;
    }
    EXPECT_NEAR(double(state.velocity_m_per_s[2]), -9.81, kForm * 9.81);
    EXPECT_EQ(angle(), 0.0);
}

// m x'' + d x' + k x = 0
TEST_F(BodyTest, SwingsOnItsSuspension) {
    const double w0 = 2.0 * std::numbers::pi, zeta = 0.05, x0 = 0.01;
    body.stiffness_n_per_m[0] = static_cast<float>(kMass_kg * w0 * w0);
    body.damping_n_s_per_m[0] = static_cast<float>(2.0 * zeta * w0 * kMass_kg);
    begin();
    state.position_m[0] += static_cast<float>(x0);
    const double wd = w0 * std::sqrt(1.0 - zeta * zeta);
    for (int tick = 1; tick <= 2000; ++tick) {
        move();
        const double t = tick * kTick_s;
        const double x = x0 * std::exp(-zeta * w0 * t) * (std::cos(wd * t) + zeta * w0 / wd * std::sin(wd * t));
        ASSERT_NEAR(moved().x(), x, kForm * x0) << tick;
    }
}

// J angle'' = -k sin(angle): the suspension's moment is a pendulum's. With sin(angle / 2) = m sin(phi), m = sin(first /
// 2), the way from phi to 0 takes F(phi, m) / w0 (Whittaker, Analytical Dynamics, 44).
TEST_F(BodyTest, SwingsAsAPendulum) {
    const double w0 = 2.0 * std::numbers::pi, first = 1.0, m = std::sin(first / 2.0);
    body.turn_stiffness_n_m[1] = static_cast<float>(double(body.inertia_kg_m2[1]) * w0 * w0);
    begin();
    state.turn[0] = static_cast<float>(std::cos(first / 2.0));
    state.turn[2] = static_cast<float>(m);
    const double quarter = std::comp_ellint_1(m) / w0;
    for (int tick = 1; tick * kTick_s < 1.9 * quarter; ++tick) {
        move();
        const double s = turn_of(state).y() / m;
        if (std::abs(s) > 0.95) continue;  // near the turning point an angle tells no time
        ASSERT_NEAR(std::ellint_1(m, std::asin(s)) / w0, quarter - tick * kTick_s, kForm * 4.0 * quarter) << tick;
    }
    EXPECT_LT(turn_of(state).y(), 0.0);
}

// J w = r x F dt, about an axis of the cube through its centre.
TEST_F(BodyTest, APushBesideItsCentreTurnsIt) {
    begin();
    const Vector3d arm(0.01, 0.0, 0.0), force(0.0, 0.0, 0.2);
    push(to_vector(body.centre_m) + arm, force);
    move(999);
    const Vector3d v = force * kTick_s / kMass_kg;
    const Vector3d w = arm.cross(force) * kTick_s / double(body.inertia_kg_m2[0]);
    EXPECT_NEAR((moved() - v).norm(), 0.0, kForm * v.norm());
    const Quaterniond turned(Eigen::AngleAxisd(w.norm(), w.normalized()));
    EXPECT_NEAR(turn_of(state).angularDistance(turned), 0.0, kForm * w.norm());
}

// An axially symmetric body: its spin precesses about its own axis at (J3 - J1) / J1 w3 (Euler).
TEST_F(BodyTest, AFreeTopPrecesses) {
    body.inertia_kg_m2[2] *= 1.5F;
    begin();
    spin({1.0, 0.0, 4.0});
    const double before = energy();
    const Vector3d momentum(double(body.inertia_kg_m2[0]), 0.0, 4.0 * double(body.inertia_kg_m2[2]));
    for (int tick = 1; tick <= 2000; ++tick) {
        move();
        const double turned = 0.5 * 4.0 * tick * kTick_s;
        ASSERT_NEAR((to_vector(state.spin_rad_per_s) - Vector3d(std::cos(turned), std::sin(turned), 4.0)).norm(), 0.0,
                    kForm * std::sqrt(17.0))
            << tick;
    }
    EXPECT_NEAR(energy(), before, 2000 * kFloat * before);
    const Vector3d j(double(body.inertia_kg_m2[0]), double(body.inertia_kg_m2[1]), double(body.inertia_kg_m2[2]));
    const Vector3d now = turn_of(state) * j.cwiseProduct(to_vector(state.spin_rad_per_s));
    EXPECT_NEAR((now - momentum).norm(), 0.0, kForm * momentum.norm());
}

TEST_F(BodyTest, ItsTurnKeepsItsLength) {
    body.inertia_kg_m2[1] *= 1.3F;
    body.inertia_kg_m2[2] *= 1.9F;
    begin();
    spin({5.0, 12.0, 19.0});
    const double before = energy();
    for (int tick = 0; tick < 60000; ++tick) {
        move();
        ASSERT_WITHIN(std::abs(turn_of(state).norm() - 1.0), .count = 8, .epsilon = kFloat) << tick;
    }
    EXPECT_NEAR(energy(), before, 1e-3 * before);
}

// What rounding has made of a turn's length does not stay: its error is squared each tick.
TEST_F(BodyTest, ATurnOfAnotherLengthIsMended) {
    begin();
    state.turn[0] = 0.6F * 1.001F;
    state.turn[2] = 0.8F * 1.001F;
    move(2);
    EXPECT_WITHIN(std::abs(turn_of(state).norm() - 1.0), .count = 8, .epsilon = kFloat);
}

// Undamped, and large: the step neither makes nor takes energy.
TEST_F(BodyTest, SuspendedItKeepsItsEnergy) {
    for (int c = 0; c < 3; ++c) {
        body.stiffness_n_per_m[c] = static_cast<float>(2 + c);
        body.turn_stiffness_n_m[c] = static_cast<float>(1e-3 * (1 + c));
    }
    add_gravity(body);
    begin();
    spin({3.0, 2.0, 1.0});
    const double weight = kMass_kg * 9.81, whole = energy() + weight * weight / (2.0 * 4.0);  // above the rest
    for (int tick = 0; tick < 20000; ++tick) {
        move();
        ASSERT_NEAR(energy() + weight * weight / 8.0, whole, 1e-4 * whole) << tick;
    }
}

TEST_F(BodyTest, ComesToRestOnTheFloor) {
    add_gravity(body);
    add_floor(body, -0.01, 0.5);
    begin();
    spin({3.0, 2.0, 0.0});
    state.velocity_m_per_s[0] = 0.1F;
    // What the floor gives as points enter is owed, and it takes that back.
    double before = energy();
    const double whole = before + kMass_kg * 9.81 * 0.01;
    for (int tick = 0; tick < 3000; ++tick) {
        move();
        const double now = energy() - double(state.floor_owed_j);
        ASSERT_LE(now - before, kSum * whole) << tick;
        before = now;
    }
    EXPECT_LT(double(state.floor_owed_j), kSum * whole) << "all was taken back";
    EXPECT_EQ(state.on_floor == 0x0f || __builtin_popcount(state.on_floor) == 4, true);
    const double sag = kMass_kg * 9.81 / (4.0 * double(body.floor_stiffness_n_per_m));
    EXPECT_NEAR(moved().z(), -0.01 - sag, kForm * 0.01);
    const haptable_body_state rested = state;
    move(57000);
    EXPECT_NEAR((moved() - (position_of(rested) - to_vector(body.centre_m))).norm(), 0.0, 1e-7);
    EXPECT_NEAR(turn_of(state).angularDistance(turn_of(rested)), 0.0, 1e-5);
}

// A body that is thrown up from the floor: that still pushes, for it was pressed, and does not pull.
TEST_F(BodyTest, TheFloorDoesNotPull) {
    add_gravity(body);
    add_floor(body, -0.0001, 0.5);
    begin();
    move(1000);
    ASSERT_EQ(__builtin_popcount(state.on_floor), 4);
    for (const float up : {0.1F, 1.0F}) {
        state.velocity_m_per_s[2] = up;
        move();
        EXPECT_GE(double(state.velocity_m_per_s[2]), double(up) - 9.81 * kTick_s - 4.0 * kFloat) << up;
        begin();
        move(1000);
    }
}

// What was refused, or is no number, leaves the body as if nobody touched it.
TEST_F(BodyTest, ARefusedFingerPushesNothing) {
    add_gravity(body);
    add_floor(body, 0.0, 0.5);
    begin();
    const haptable_model cube = coupled_cube(ForceLaw::kConsistent).model(GodObject::kLeastEnergy);
    SceneSession session(cube, nullptr, &body, nullptr);
    for (int tick = 0; tick < 100; ++tick) {
        session.step(Vector3d(tick % 2 == 0 ? NAN : 1e30, 0.0, 0.0));
        move();
        EXPECT_EQ(session.force().norm(), 0.0);
    }
    EXPECT_EQ(position_of(*session.state.body()), position_of(state));
    EXPECT_EQ(to_vector(session.state.body()->velocity_m_per_s), to_vector(state.velocity_m_per_s));
}

// A finger that presses the hanging cube moves it, and what it feels is what the suspension gives: action and reaction.
TEST_F(BodyTest, AFingerMovesItUntilItsSuspensionHolds) {
    for (int c = 0; c < 3; ++c) {
        body.stiffness_n_per_m[c] = 3.0F;
        body.turn_stiffness_n_m[c] = 1e-3F;
        body.damping_n_s_per_m[c] = 0.5F;
        body.turn_damping_n_m_s[c] = 1e-4F;
    }
    const haptable_model cube = coupled_cube(ForceLaw::kConsistent).model(GodObject::kLeastEnergy);
    SceneSession session(cube, nullptr, &body, nullptr);
    for (int tick = 0; tick < 4000; ++tick)
        session.step(Vector3d(0.015, 0.015, 0.03 + std::max(-0.008, 0.002 - 5e-6 * tick)));
    ASSERT_TRUE(session.touches());
    const double sunk = double(body.centre_m[2]) - position_of(*session.state.body()).z();
    EXPECT_GT(sunk, 0.004);
    EXPECT_NEAR(session.force().z(), double(body.stiffness_n_per_m[2]) * sunk, 1e-4 * session.force().z());
}

// On a slope of 20 degrees, tan = 0.364.
TEST_F(BodyTest, FrictionHoldsOnASlopeOrSlides) {
    const double slope = 20.0 * std::numbers::pi / 180.0;
    add_gravity(body, 9.81 * Vector3d(std::sin(slope), 0.0, -std::cos(slope)));
    for (const double friction : {0.45, 0.2, 0.0}) {
        add_floor(body, 0.0, friction);
        begin();
        move(1000);
        const Vector3d at = moved();
        const double v = double(state.velocity_m_per_s[0]);
        move(1000);
        const double gain = std::max(0.0, 9.81 * (std::sin(slope) - friction * std::cos(slope)));
        if (friction > 0.4) {
            EXPECT_NEAR((moved() - at).norm(), 0.0, 1e-7);
        } else {
            EXPECT_NEAR(moved().x() - at.x(), v + 0.5 * gain, 1e-3 * gain) << friction;
        }
    }
}

}  // namespace
}  // namespace haptable::test
