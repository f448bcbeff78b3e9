// SPDX-License-Identifier: GPL-2.0-or-later
// The pointer's finger in a page moves as the simulated device does.
#include <gtest/gtest.h>

#include <random>

#include "host/device/point_device.hpp"
#include "tests/tolerance.hpp"

extern "C" {
#include "host/page/wasm/hand.h"
}

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kStep_s = 1e-3 / 20;

page_hand same_as(const Device& device, const Hand& hand) {
    page_hand page{};
    page.mass_kg = device.mass_kg[0];  // the same along every axis
    page.damping_n_s_per_m = device.damping_n_s_per_m;
    page.friction_n = device.friction_n;
    page.max_force_n = device.max_force_n;
    page.encoder_step_m = device.encoder_step_m;
    page.stiffness_n_per_m = hand.stiffness_n_per_m;
    page.hand_damping_n_s_per_m = hand.damping_n_s_per_m;
    return page;
}

// Goals and forces that change every tick, forces beyond the limit among them, friction that sticks and slips.
TEST(PageHand, MovesAsTheSimulatedDevice) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto any = [&](double size) {
        return Vector3d(size * Vector3d(uniform(random), uniform(random), uniform(random)));
    };
    constexpr int kTicks = 2000;
    Device device;
    const Vector3d start_m = any(0.01);
    PointDevice host(device, Hand{}, start_m);
    page_hand page = same_as(device, Hand{});
    page_hand_place(&page, start_m.data());
    int stuck = 0;
    for (int tick = 0; tick < kTicks; ++tick) {
        const bool rests = tick % 500 > 100;
        const Vector3d goal_m = rests ? start_m : any(0.02), goal_m_s = rests ? Vector3d::Zero().eval() : any(0.1);
        const Vector3d force_n = rests ? Vector3d::Zero().eval() : any(tick % 7 == 0 ? 20.0 : 1.0);
        host.set_force(force_n);
        page_hand_force(&page, force_n.data());
        for (int step = 0; step < 20; ++step) {
            host.advance({goal_m, goal_m_s}, kStep_s);
            page_hand_advance(&page, goal_m.data(), goal_m_s.data(), kStep_s);
        }
        stuck += host.velocity_m_s().squaredNorm() == 0.0 ? 1 : 0;
        // 20 steps a tick of some 30 operations; the spring's own time forgets what is older than 100 ms.
        EXPECT_WITHIN((Vector3d(page.position_m) - host.position_m()).norm(), .count = 245, .size = 0.05);
        EXPECT_WITHIN((Vector3d(page.velocity_m_s) - host.velocity_m_s()).norm(), .count = 245, .size = 1.0);
        EXPECT_WITHIN((Vector3d(page.force_n) - host.force_n()).norm(), .count = 8, .size = device.max_force_n);
        float encoder_m[3];
        page_hand_encoders(&page, encoder_m);
        EXPECT_LT((Eigen::Vector3f(encoder_m).cast<double>() - host.position_m()).norm(), device.encoder_step_m);
    }
    EXPECT_GT(stuck, 100);
}

}  // namespace
}  // namespace haptable::test
