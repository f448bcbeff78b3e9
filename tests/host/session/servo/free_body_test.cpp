// SPDX-License-Identifier: GPL-2.0-or-later
// Where a body that nothing holds is: in a replay's CSV, and as HAPTABLE_BODY.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {
namespace {

class FreeBodySession : public testing::Test {
protected:
    FreeBodySession() { add_gravity(body); }
    ServoScene scene() const {
        ServoScene scene = box.scene();
        scene.body = &body;
        return scene;
    }

    SoftBox box;
    haptable_body body = cube_body();
    WorkFolder folder;
};

TEST_F(FreeBodySession, AReplayHasItsPose) {
    std::string path = "x,y,z\n";
    for (int tick = 0; tick < 200; ++tick) path += "0.015,0.015,0.1\n";
    write_file(folder / "in.csv", path);
    replay(scene(), folder / "in.csv", folder / "out.csv", true);
    EXPECT_TRUE(lines_of(read_file(folder / "out.csv"))[0].ends_with(
        ",faults,body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z"));
    const auto rows = read_rows(folder / "out.csv");
    ASSERT_EQ(rows.size(), 200U);
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const double t = 0.001 * static_cast<double>(k), fallen = 0.5 * 9.81 * t * t;
        ASSERT_EQ(rows[k].size(), 27U);
        EXPECT_NEAR(rows[k].at("body_z"), 0.015 - fallen, 1e-4 * fallen + 1e-8);
        EXPECT_EQ(rows[k].at("turn_w"), 1.0);
    }
}

// A finger that comes down on it where it was meets nothing; where it is, its surface.
TEST_F(FreeBodySession, TheFingerMeetsItWhereItIs) {
    add_gravity(body, Eigen::Vector3d::Zero());
    std::string path = "x,y,z\n";
    for (int tick = 0; tick < 400; ++tick) path += "0.0131,0.0112," + std::to_string(0.031 - 2e-5 * tick) + "\n";
    write_file(folder / "in.csv", path);
    replay(scene(), folder / "in.csv", folder / "out.csv", true);
    const auto rows = read_rows(folder / "out.csv");
    double most_n = 0.0;
    for (const auto& row : rows) most_n = std::max(most_n, row.at("force_z"));
    EXPECT_GT(most_n, 0.0);
    // Where it was the finger would be 7 mm deep; the body has gone on before it.
    EXPECT_LT(rows.back().at("body_z"), 0.015 - 0.004);
}

TEST_F(FreeBodySession, EachAnswerIsFollowedByItsPose) {
    Connection connection{"memq://"};
    LocalStepper stepper(scene());
    Session session(stepper, connection, nullptr);
    std::vector<body_pose> poses;
    connection.subscribe<body_pose>(channel_of<body_pose>(),
                                    [&](const body_pose& m, std::int64_t) { poses.push_back(m); });
    for (std::int64_t seq = 0; seq < 100; ++seq) {
        device_state state = simulated_state(seq, seq * 1000);
        state.position_m[2] = 0.1;
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    }
    ASSERT_EQ(poses.size(), 100U);
    EXPECT_EQ(poses.back().seq, 99);
    EXPECT_EQ(poses.back().utime, 99000);
    EXPECT_EQ(poses.back().session, kSession);
    EXPECT_EQ(poses.back().model_hash, static_cast<std::int64_t>(SoftBox::kHash));
    EXPECT_NEAR(poses.back().rest_centre_m[2] - poses.back().centre_m[2], 0.5 * 9.81 * 0.099 * 0.099, 1e-6);
    EXPECT_NEAR(poses.back().velocity_m_per_s[2], -0.9712, 1e-4);
    EXPECT_EQ(poses.back().turn[0], 1.0);
}

TEST_F(FreeBodySession, ABodyThatIsHeldHasNone) {
    Connection connection{"memq://"};
    LocalStepper stepper(box.scene());
    Session session(stepper, connection, nullptr);
    int poses = 0;
    connection.subscribe<body_pose>(channel_of<body_pose>(), [&](const body_pose&, std::int64_t) { ++poses; });
    connection.publish(channel_of<device_state>(), simulated_state(0, 0));
    handle_all(connection);
    EXPECT_EQ(poses, 0);
}

}  // namespace
}  // namespace haptable::test
