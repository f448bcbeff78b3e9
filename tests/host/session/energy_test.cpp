// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

constexpr float kStiffness_n_per_m = 100.0F;

/// A contact with a spring of 100 N/m whose end stands at `rest_z`.
haptable_output spring(float z, float rest_z) {
    haptable_output out{};
    out.state = HAPTABLE_CONTACT;
    out.god_object_m[2] = rest_z;
    out.nodal_force_n[1][2] = 0.25F * kStiffness_n_per_m * (z - rest_z);
    out.nodal_force_n[2][2] = 0.75F * kStiffness_n_per_m * (z - rest_z);
    out.force_n[2] = -kStiffness_n_per_m * (z - rest_z);
    return out;
}

// A spring that is pressed and let go in n ticks gives k (depth / n)^2 n: what a sampled spring makes (Colgate).
TEST(EnergyAccount, OfASampledSpringIsItsLeak) {
    const int n = 50;
    const double depth_m = 0.005;
    EnergyAccount account;
    for (int tick = 0; tick <= 2 * n; ++tick) {
        const auto z = static_cast<float>(-depth_m * (1.0 - std::abs(tick - n) / double(n)));
        account.add({0.0F, 0.0F, z}, spring(z, 0.0F));
    }
    const double stored_j = 0.5 * double{kStiffness_n_per_m} * depth_m * depth_m;
    const Bound rounded{.count = 8, .epsilon = kFloat, .size = stored_j};  // of forces and positions in float
    EXPECT_WITHIN(std::abs(account.most_stored_j() - stored_j), rounded);
    EXPECT_WITHIN(std::abs(account.given_j() - 2.0 * stored_j / n), rounded);
    EXPECT_EQ(account.stored_j(), 0.0);
    EXPECT_EQ(account.most_given_j(), account.given_j());
}

// Pressed where it is stiff and let go where it is soft, a body has taken the difference.
TEST(EnergyAccount, WhatIsLostIsNotGiven) {
    EnergyAccount account;
    account.add({0, 0, 0}, spring(0.0F, 0.0F));
    for (int tick = 1; tick <= 100; ++tick) {
        const float z = -1e-5F * static_cast<float>(tick);
        account.add({0, 0, z}, spring(z, 0.0F));
    }
    haptable_output free{};
    free.state = HAPTABLE_FREE;
    account.add({0, 0, -1e-3F}, free);
    account.add({0, 0, 0}, free);
    const double taken_j = 0.5 * 99 * 100 * 1e-10 * double{kStiffness_n_per_m};
    EXPECT_WITHIN(std::abs(account.given_j() + taken_j), .count = 16, .epsilon = kFloat, .size = taken_j);
    EXPECT_EQ(account.most_given_j(), 0.0);
    EXPECT_EQ(account.stored_j(), 0.0);
}

// After silence or a position that is none, nobody knows the way: nothing is counted for it.
TEST(EnergyAccount, CountsNoWayThatItDoesNotKnow) {
    for (const auto state : {HAPTABLE_SILENT, HAPTABLE_REJECTED}) {
        EnergyAccount account;
        haptable_output nothing{};
        nothing.state = static_cast<std::uint8_t>(state);
        account.add({0, 0, -0.001F}, spring(-0.001F, 0.0F));
        account.add({0, 0, std::numeric_limits<float>::quiet_NaN()}, nothing);
        account.add({0, 0, 0.5F}, spring(-0.001F, 0.0F));
        EXPECT_EQ(account.given_j(), 0.0);
        EXPECT_EQ(account.most_stored_j() > 0.0, true);
    }
    EnergyAccount account;
    haptable_output fault = spring(-0.001F, 0.0F);
    fault.nodal_force_n[0][0] = std::numeric_limits<float>::infinity();
    account.add({0, 0, -0.001F}, fault);
    EXPECT_EQ(account.stored_j(), 0.0);
}

}  // namespace
}  // namespace haptable::test
