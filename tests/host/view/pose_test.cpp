// SPDX-License-Identifier: GPL-2.0-or-later
// A body that nothing holds is drawn where it is.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "host/base/file.hpp"
#include "host/view/servo_csv.hpp"
#include "host/view/surface.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A quarter turn about z.
constexpr std::array<double, 4> kQuarter{std::numbers::sqrt2 / 2.0, 0.0, 0.0, std::numbers::sqrt2 / 2.0};

TEST(ViewPose, TurnsAboutTheCentreOfMass) {
    const auto pose = pose_of({1.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, kQuarter);
    ASSERT_TRUE(pose);
    EXPECT_WITHIN((*pose * Vector3d(1.0, 0.0, 0.0) - Vector3d(5.0, 0.0, 0.0)).norm(), .count = 16);
    EXPECT_WITHIN((*pose * Vector3d(2.0, 0.0, 0.0) - Vector3d(5.0, 1.0, 0.0)).norm(), .count = 16);
    EXPECT_FALSE(pose_of({1.0, 0.0, 0.0}, {NAN, 0.0, 0.0}, kQuarter));
    EXPECT_FALSE(pose_of({1.0, 0.0, 0.0}, {5.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0}));
}

TEST(ViewPose, MovesTheDrawnSurfaceAndItsNormals) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    const Tables tables = read_tables(folder.path());
    DrawnSurface surface(tables);
    const std::vector<Eigen::Vector3f> before = surface.normal;
    const auto pose = pose_of({0.015, 0.015, 0.015}, {0.1, 0.0, 0.0}, kQuarter);
    surface.move(*pose);
    for (std::size_t i = 0; i < surface.nodes(); ++i) {
        const Vector3d drawn = (surface.rest_m[i] + surface.displacement_m[i]).cast<double>();
        EXPECT_WITHIN((drawn - *pose * surface.rest_m[i].cast<double>()).norm(), .count = 16, .epsilon = kFloat,
                      .size = 0.15);
    }
    for (std::size_t i = 0; i < before.size(); ++i)
        EXPECT_WITHIN((surface.normal[i] - pose->linear().cast<float>() * before[i]).norm(), .count = 16,
                      .epsilon = kFloat);
}

// Loads are those of the dent in the body's frame: the same press, wherever the body is.
TEST(ViewPose, OfACsvIsThatOfItsLastColumns) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    const Tables tables = read_tables(folder.path());
    const ContactLoads loads(tables);
    const auto& patch = *std::find_if(tables.patch.begin(), tables.patch.end(),
                                      [](const auto& p) { return std::find(p.begin(), p.end(), 112) != p.end(); });
    const auto row = [&](int tick, const std::string& finger, const std::string& place) {
        return std::to_string(tick) + "," + finger + ",1," + std::to_string(patch[0]) + "," + std::to_string(patch[1]) +
               "," + std::to_string(patch[2]) + ",0.5,0.25,0.25,0.015,0.014,0.03,0,0,0.3,0,2,0," + place + "\n";
    };
    write_file(folder.path() / "servo.csv",
               "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,"
               "force_z,buttons,state,faults,body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z\n" +
                   row(0, "0.015,0.015,0.028", "0.015,0.015,0.015,1,0,0,0") +
                   row(1, "1.015,0.015,0.028", "1.015,0.015,0.015,1,0,0,0"));
    const auto frames = read_servo_csv(folder.path() / "servo.csv", loads, {.every_ms = 1, .ticks = {}});
    ASSERT_EQ(frames.size(), 2U);
    ASSERT_TRUE(frames[1].pose);
    EXPECT_WITHIN((*frames[1].pose * Vector3d::Zero() - Vector3d(1.0, 0.0, 0.0)).norm(), .count = 8);
    ASSERT_EQ(frames[0].loads.size(), frames[1].loads.size());
    for (std::size_t i = 0; i < frames[0].loads.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_WITHIN(std::abs(double(frames[1].loads[i].force_n[c]) - double(frames[0].loads[i].force_n[c])),
                          .count = 16, .epsilon = kFloat, .size = 0.5);
}

// A second finger is drawn, and its load is the reaction of what it feels, in the body's frame.
TEST(ViewPose, ACsvOfTwoFingersLoadsBoth) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    const Tables tables = read_tables(folder.path());
    const ContactLoads loads(tables);
    const auto& patch = tables.patch.front();
    const std::string nodes =
        std::to_string(patch[0]) + "," + std::to_string(patch[1]) + "," + std::to_string(patch[2]);
    write_file(folder.path() / "servo.csv",
               "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,"
               "force_z,buttons,state,faults,x2,y2,z2,contact2,node_i2,node_j2,node_k2,alpha_i2,alpha_j2,alpha_k2,"
               "god_x2,god_y2,god_z2,force_x2,force_y2,force_z2,buttons2,state2,faults2\n"
               "0,0.1,0,0,0,-1,-1,-1,0,0,0,0.1,0,0,0,0,0,0,1,0,0.01,0.01,0.01,1," +
                   nodes +
                   ",0.5,0.25,0.25,0.01,0.01,0.012,0,0,0.4,0,2,0\n"
                   "1,0.1,0,0,0,-1,-1,-1,0,0,0,0.1,0,0,0,0,0,0,1,0,0.01,0.01,0.06,0,-1,-1,-1,0,0,0,0,0,0,0,0,0,0,1,0\n"
                   "2,0.1,0,0,0,-1,-1,-1,0,0,0,0.1,0,0,0,0,0,0,1,0,nan,nan,nan,0,-1,-1,-1,0,0,0,0,0,0,0,0,0,0,0,0\n");
    const auto frames = read_servo_csv(folder.path() / "servo.csv", loads, {.every_ms = 1, .ticks = {}});
    ASSERT_EQ(frames.size(), 3U);
    ASSERT_FALSE(frames[1].others.empty()) << "free, it is drawn";
    EXPECT_EQ(frames[1].others[0].finger_m.z(), 0.06);
    EXPECT_FALSE(frames[1].others[0].contact);
    EXPECT_TRUE(frames[1].loads.empty());
    EXPECT_TRUE(frames[2].others.empty()) << "nowhere";
    ASSERT_TRUE(!frames[0].others.empty() && frames[0].others[0].contact);
    EXPECT_EQ(frames[0].others[0].god_object_m.z(), 0.012);
    Vector3d sum = Vector3d::Zero();
    for (const NodalForce& load : frames[0].loads)
        for (int c = 0; c < 3; ++c) sum[c] += double(load.force_n[static_cast<std::size_t>(c)]);
    EXPECT_WITHIN((sum - Vector3d(0.0, 0.0, -0.4)).norm(), .count = 16, .epsilon = kFloat, .size = 0.4);
}

}  // namespace
}  // namespace haptable::test
