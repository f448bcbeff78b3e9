// SPDX-License-Identifier: GPL-2.0-or-later
// The mechanisms of the 2diy and of the Falcon: closed forms, differences, and numbers of other people's formulas.
#include <gtest/gtest.h>

#include <numbers>
#include <optional>
#include <random>

#include "host/device/falcon.hpp"
#include "host/device/five_bar.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kRadPerDegree = std::numbers::pi / 180.0;

TEST(FiveBar, KeepsTheLengthsOfItsArms) {
    for (const double apart_m : {0.0, 0.038})
        for (double first = 90.0; first <= 200.0; first += 7.0)
            for (double second = -20.0; second <= 90.0; second += 7.0) {
                SCOPED_TRACE(testing::Message() << apart_m << " " << first << " " << second);
                const Vector2d angle = Vector2d(first, second) * kRadPerDegree;
                const auto end = FiveBar{0.07, 0.09, apart_m}.end_m(angle);
                if (!end) continue;
                Vector2d elbow[2];
                for (const int motor : {0, 1}) {
                    elbow[motor] = {apart_m * motor + 0.07 * std::cos(angle[motor]), 0.07 * std::sin(angle[motor])};
                    EXPECT_WITHIN(std::abs((*end - elbow[motor]).norm() - 0.09), .count = 256, .size = 0.2);
                }
                const Vector2d across = elbow[1] - elbow[0], up(-across.y(), across.x());
                EXPECT_GE((*end - elbow[0]).dot(up), -1e-12) << "of two places the one that the hand holds";
            }
    EXPECT_FALSE((FiveBar{0.07, 0.03, 0.038}.end_m(Vector2d(180.0, 0.0) * kRadPerDegree)));
    EXPECT_FALSE((FiveBar{0.07, 0.03, 0.038}.jacobian(Vector2d(180.0, 0.0) * kRadPerDegree)));
    EXPECT_FALSE(FiveBar{}.end_m(Vector2d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

/// Each column of a Jacobian against a central difference of the end over one angle, which `off_m` makes wrong.
template <typename Vector, typename Jacobian, typename End>
void expect_differences(const Vector& angle, const std::optional<Jacobian>& jacobian, const End& end, double off_m) {
    ASSERT_TRUE(jacobian);
    for (Eigen::Index k = 0; k < angle.size(); ++k) {
        const Vector step = 1e-6 * Vector::Unit(k);
        const Vector difference = (*end(angle + step) - *end(angle - step)) / 2e-6;
        // Rounding over the step, and its square.
        EXPECT_WITHIN((jacobian->col(k) - difference).norm(), .epsilon = off_m / 1e-6 + 1e-8);
    }
}

TEST(FiveBar, TheJacobianIsThatOfDifferences) {
    const FiveBar linkage{0.07, 0.09, 0.038};
    for (const Vector2d& degrees : {Vector2d(168.0, 12.0), Vector2d(120.0, 30.0), Vector2d(150.0, 80.0)}) {
        const Vector2d angle = degrees * kRadPerDegree;
        expect_differences(
            angle, linkage.jacobian(angle), [&](const Vector2d& a) { return linkage.end_m(a); }, 0.0);
    }
}

// libnifalcon's inverse kinematics (its FalconKinematicStamper.cpp, evaluated apart from this project), rad.
TEST(Falcon, LegsStandAsLibnifalconSays) {
    const std::pair<Vector3d, Vector3d> known[] = {
        {{0.0, 0.0, 0.11}, {0.25423487235941455, 0.25423487235941455, 0.25423487235941455}},
        {{0.02, -0.03, 0.12}, {0.8160860524496791, 0.1743690712477102, 0.4400593160197874}},
        {{-0.04, 0.01, 0.09}, {-0.16035472993088695, 0.6390808885763406, -0.21912672851638637}},
        {{0.03, 0.03, 0.14}, {0.5819006289000028, 0.612061147845089, 1.134240351333276}}};
    for (const auto& [grip_m, angle] : known) {
        const auto found = falcon_angles(grip_m);
        ASSERT_TRUE(found);
        // Theirs by the half angle's tangent, from squares that cancel.
        EXPECT_WITHIN((*found - angle).norm(), .epsilon = 1e-12) << grip_m.transpose();
    }
}

TEST(Falcon, TheGripIsFoundFromItsLegs) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> off(-0.04, 0.04);
    for (int i = 0; i < 1000; ++i) {
        const Vector3d grip_m(off(random), off(random), 0.11 + off(random));
        const auto angle = falcon_angles(grip_m);
        if (!angle) continue;
        const auto found = falcon_grip_m(*angle, Vector3d(0.0, 0.0, 0.11));
        ASSERT_TRUE(found) << grip_m.transpose();
        EXPECT_WITHIN((*found - grip_m).norm(), .epsilon = 1e-12) << "where Newton's steps end";
    }
    EXPECT_FALSE(falcon_angles(Vector3d(0.5, 0.0, 0.11)));
    EXPECT_FALSE(falcon_grip_m(Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()), Vector3d(0.0, 0.0, 0.11)));
}

TEST(Falcon, TheJacobianIsThatOfDifferences) {
    for (const Vector3d& grip_m :
         {Vector3d(0.0, 0.0, 0.11), Vector3d(0.02, -0.03, 0.12), Vector3d(-0.04, 0.01, 0.09)}) {
        const Vector3d angle = falcon_angles(grip_m).value();
        const auto grip = [&](const Vector3d& a) { return falcon_grip_m(a, grip_m); };
        expect_differences(angle, falcon_jacobian(angle, grip_m), grip, 1e-12);
    }
}

TEST(Falcon, TheReaderFindsFramesBetweenGarbage) {
    const std::string frame =
        "<BAAAPPPPEDCB\xB6"
        "A>";  // homed 7, buttons 5
    const std::string stream = "<<>x" + frame + "<BAAAPPPPEDCB" + frame + "junk" + frame.substr(0, 9);
    FalconReader reader;
    std::int64_t odd = 0;
    int frames = 0;
    for (const char c : stream) {
        const auto byte = static_cast<std::uint8_t>(c);
        const auto state = reader.add({&byte, 1}, odd);
        if (!state) continue;
        ++frames;
        EXPECT_EQ(state->encoder, (std::array<std::int16_t, 3>{1, -1, 0x1234}));
        EXPECT_EQ(state->buttons, 5);
        EXPECT_EQ(state->homed, 7);
    }
    EXPECT_EQ(frames, 2);
    EXPECT_EQ(odd, 4 + 13) << "what waits may still become one";
}

}  // namespace
}  // namespace haptable::test
