// SPDX-License-Identifier: GPL-2.0-or-later
// A tool from its scene to its pictures: a hand that turns it, messages, records, replay, frames.
#include <gtest/gtest.h>

#include "codegen/loads.hpp"
#include "host/link/log_reader.hpp"
#include "host/view/servo_csv.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/every_scene.hpp"
#include "tests/loop/recorded_loop.hpp"

namespace haptable::test {
namespace {

constexpr Parts kDisc{.has_tool = true};

class ToolLoop : public RecordedLoop {
protected:
    /// One session in lockstep, recorded by both sides.
    DeviceReport touch(const std::string& path, const std::string& tag) {
        PathOptions geometry;
        geometry.reach_m = 0.0;  // a disc's face is at its handle
        SessionOptions options;
        options.lockstep = true;
        options.has_tool = true;
        return run(scene, tag, {scripted_path(path, geometry)}, options)[0];
    }
    /// Those that were sent, of a session's log.
    template <typename Message>
    std::vector<Message> sent(const std::string& tag) const {
        std::vector<Message> messages;
        LogReader reader(log(tag));
        Message message;
        while (const auto event = reader.next())
            if (event->channel == channel_of<Message>() && decode_whole(event->data, message))
                messages.push_back(message);
        return messages;
    }

    const ServoScene scene = every_scene().scene(kDisc);
};

/// Pressed flat, then turned to and fro: the torque turns it back, about the axis that it is turned about.
TEST_F(ToolLoop, AHandFeelsItsTorque) {
    const DeviceReport report = touch("roll", "a");
    EXPECT_EQ(report.missed, 0);
    EXPECT_GT(report.contact_ticks, 500);
    EXPECT_GT(report.largest_force_n, 0.2);
    EXPECT_GT(report.largest_torque_n_m, 1e-4);
    double with = 0.0, against = 0.0;
    for (const Row& row : read_rows(device_csv("a"))) {
        const double work = row.at("torque_x") * row.at("qx");
        (work > 0.0 ? with : against) += std::abs(work);
        EXPECT_NEAR(row.at("qy"), 0.0, 0.02);
    }
    EXPECT_GT(against, 5.0 * with);
}

/// Force and torque of the device are the servo's of the same tick; the points' forces are the hand's.
TEST_F(ToolLoop, RecordsAndMessagesAgree) {
    touch("tilt", "a");
    const auto servo = read_rows(csv("a")), device = read_rows(device_csv("a"));
    const auto wrenches = sent<tool_wrench>("a");
    const auto contacts = sent<contact>("a");
    ASSERT_EQ(servo.size(), device.size());
    ASSERT_EQ(wrenches.size(), servo.size());
    ASSERT_EQ(contacts.size(), servo.size());
    std::int32_t most = 0;
    for (std::size_t i = 0; i < servo.size(); ++i) {
        for (const char* of : {"", "force_", "torque_"})
            EXPECT_LT((xyz_of(servo[i], of) - xyz_of(device[i], of)).norm(),
                      1e-6 * (1.0 + xyz_of(device[i], of).norm()));
        for (const char* q : {"qw", "qx", "qy", "qz"}) EXPECT_NEAR(servo[i].at(q), device[i].at(q), 1e-6);
        ASSERT_EQ(wrenches[i].count, 5);
        std::int32_t touching = 0;
        Eigen::Vector3d load_n = Eigen::Vector3d::Zero();
        for (const auto touches : wrenches[i].touches) touching += touches;
        for (const auto& force_n : contacts[i].force_n) load_n += Eigen::Vector3d(force_n.data());
        EXPECT_EQ(contacts[i].count, 3 * touching) << i;
        EXPECT_LT((load_n + Eigen::Vector3d(contacts[i].felt_n)).norm(), 1e-4 * (1e-3 + load_n.norm())) << i;
        most = std::max(most, touching);
    }
    EXPECT_EQ(most, 5);
}

TEST_F(ToolLoop, IsRepeatableAndReplays) {
    touch("roll", "a");
    touch("roll", "b");
    EXPECT_EQ(read_file(csv("a")), read_file(csv("b")));
    EXPECT_EQ(read_file(device_csv("a")), read_file(device_csv("b")));
    expect_same_again("a", scene);
    write_file(folder / "finger.csv", "x,y,z\n0,0,1\n");
    EXPECT_NE(error_of([&] { replay(scene, folder / "finger.csv", {}, true); }).find("x,y,z,qw,qx,qy,qz"),
              std::string::npos);
}

/// What a servo recorded is drawn: the tool where it was, and the load of all its points.
TEST_F(ToolLoop, IsDrawnFromItsCsv) {
    touch("roll", "a");
    const ContactLoads loads(every_scene().of_points(kDisc).tables());
    const auto frames = read_servo_csv(csv("a"), loads, FrameChoice{1, {}});
    const auto rows = read_rows(csv("a"));
    ASSERT_EQ(frames.size(), rows.size());
    std::size_t most = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        ASSERT_TRUE(frames[i].tool);
        EXPECT_LT((frames[i].tool->pose.translation() - frames[i].finger_m).norm(), 1e-6);
        most = std::max(most, frames[i].tool->god_object_m.size());
        Eigen::Vector3d load_n = Eigen::Vector3d::Zero();
        for (const NodalForce& load : frames[i].loads) load_n += Eigen::Vector3f(load.force_n.data()).cast<double>();
        EXPECT_LT((load_n + xyz_of(rows[i], "force_")).norm(), 1e-4 * (1e-3 + load_n.norm())) << i;
    }
    EXPECT_EQ(most, 5U);
}

/// A state whose pose did not come, or is of another state, is no tick.
TEST_F(ToolLoop, AStateWithoutItsPoseIsRefused) {
    RecordedServo servo(scene, csv("a"), log("a"));
    int answers = 0;
    servo.connection.subscribe<servo_force>(channel_of<servo_force>(),
                                            [&](const servo_force&, std::int64_t) { ++answers; });
    servo.tell(simulated_state(0, 0));
    hand_pose pose{};
    pose.session = kSession;
    pose.turn[0] = 1.0;
    servo.connection.publish(channel_of<hand_pose>(), pose);
    servo.tell(simulated_state(1, 1000));
    EXPECT_EQ(answers, 0);
    servo.tell(simulated_state(0, 0));
    EXPECT_EQ(answers, 1);
    EXPECT_EQ(servo.session.link_report().poseless_states, 2);
}

}  // namespace
}  // namespace haptable::test
