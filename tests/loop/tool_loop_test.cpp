// SPDX-License-Identifier: GPL-2.0-or-later
// A tool from its scene to its pictures: a hand that turns it, messages, records, replay, frames.
#include <gtest/gtest.h>

#include <memory>

#include "codegen/loaded_scene.hpp"
#include "codegen/loads.hpp"
#include "host/base/progress.hpp"
#include "host/device/session.hpp"
#include "host/precompute/precompute.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "host/view/servo_csv.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

constexpr double kReach_m = 0.0;  // a disc's face is at its handle

/// A disc of 12 mm over the paper's cube.
Scene disc_over_cube(const std::filesystem::path& folder) {
    write_file(folder / "disc.toml", R"(name = "disc"
[mesh]
generate = "cube"
[material]
young = 1e4
poisson = 0.3
[[fixed]]
below = 0
[contact]
force = "pressure-mask"
mask_radius = 0.003
[tool]
shape = "disc"
radius = 0.006
points = 7
)");
    return read_scene(folder / "disc.toml");
}

class ToolLoop : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<WorkFolder>();
        Progress progress(true);
        precompute(disc_over_cube(folder_->path()), *folder_ / "tables", progress);
        loaded_ = std::make_unique<LoadedScene>(TablesFolder(*folder_ / "tables"));
    }
    static void TearDownTestSuite() {
        loaded_.reset();
        folder_.reset();
    }

    ServoScene scene() const {
        return {&loaded_->model(), loaded_->node().data(), "disc", nullptr, nullptr, nullptr, loaded_->tool()};
    }

    /// One session in lockstep, recorded by both sides.
    DeviceReport run(const std::string& names, const std::string& tag) {
        PathOptions geometry;
        geometry.reach_m = kReach_m;
        const auto path = scripted_path(names, geometry);
        ServoRecord servo_record(scene(), folder / ("servo_" + tag + ".csv"));
        DeviceRecord device_record(folder / ("device_" + tag + ".csv"), true);
        SessionOptions options;
        options.lockstep = true;
        options.has_tool = true;
        LocalStepper stepper(scene());
        Connection connection("memq://");
        Session servo(stepper, connection, &servo_record);
        connection.subscribe<contact>(channel_of<contact>(),
                                      [&](const contact& m, std::int64_t) { contacts.push_back(m); });
        connection.subscribe<tool_wrench>(channel_of<tool_wrench>(),
                                          [&](const tool_wrench& m, std::int64_t) { wrenches.push_back(m); });
        DeviceSession session(PointDevice(Device{}, Hand{}, path->at(0.0).position_m), *path, connection, options,
                              &device_record);
        const DeviceReport report = session.run();
        servo_record.finish();
        device_record.finish();
        return report;
    }

    static std::unique_ptr<WorkFolder> folder_;
    static std::unique_ptr<LoadedScene> loaded_;
    WorkFolder folder;
    std::vector<contact> contacts;
    std::vector<tool_wrench> wrenches;
};

std::unique_ptr<WorkFolder> ToolLoop::folder_;
std::unique_ptr<LoadedScene> ToolLoop::loaded_;

/// Pressed flat, then turned to and fro: the torque turns it back, about the axis that it is turned about.
TEST_F(ToolLoop, AHandFeelsItsTorque) {
    const DeviceReport report = run("roll", "a");
    EXPECT_EQ(report.missed, 0);
    EXPECT_GT(report.contact_ticks, 500);
    EXPECT_GT(report.largest_force_n, 0.2);
    EXPECT_GT(report.largest_torque_n_m, 1e-4);
    double with = 0.0, against = 0.0;
    for (const Row& row : read_rows(folder / "device_a.csv")) {
        const double work = row.at("torque_x") * row.at("qx");
        (work > 0.0 ? with : against) += std::abs(work);
        EXPECT_NEAR(row.at("qy"), 0.0, 0.02);
    }
    EXPECT_GT(against, 5.0 * with);
}

/// Force and torque of the device are the servo's of the same tick; the points' forces are the hand's.
TEST_F(ToolLoop, RecordsAndMessagesAgree) {
    run("tilt", "a");
    const auto servo = read_rows(folder / "servo_a.csv"), device = read_rows(folder / "device_a.csv");
    ASSERT_EQ(servo.size(), device.size());
    ASSERT_EQ(wrenches.size(), servo.size());
    ASSERT_EQ(contacts.size(), servo.size());
    std::int32_t most = 0;
    for (std::size_t i = 0; i < servo.size(); ++i) {
        for (const char* of : {"", "force_", "torque_"})
            EXPECT_LT((xyz_of(servo[i], of) - xyz_of(device[i], of)).norm(),
                      1e-6 * (1.0 + xyz_of(device[i], of).norm()));
        for (const char* q : {"qw", "qx", "qy", "qz"}) EXPECT_NEAR(servo[i].at(q), device[i].at(q), 1e-6);
        ASSERT_EQ(wrenches[i].count, 7);
        std::int32_t touching = 0;
        Eigen::Vector3d load_n = Eigen::Vector3d::Zero();
        for (const auto touches : wrenches[i].touches) touching += touches;
        for (const auto& force_n : contacts[i].force_n) load_n += Eigen::Vector3d(force_n.data());
        EXPECT_EQ(contacts[i].count, 3 * touching) << i;
        EXPECT_LT((load_n + Eigen::Vector3d(contacts[i].felt_n)).norm(), 1e-4 * (1e-3 + load_n.norm())) << i;
        most = std::max(most, touching);
    }
    EXPECT_EQ(most, 7);
}

TEST_F(ToolLoop, IsRepeatableAndReplays) {
    run("roll", "a");
    run("roll", "b");
    EXPECT_EQ(read_file(folder / "servo_a.csv"), read_file(folder / "servo_b.csv"));
    EXPECT_EQ(read_file(folder / "device_a.csv"), read_file(folder / "device_b.csv"));
    replay(scene(), folder / "servo_a.csv", folder / "again.csv", true);
    EXPECT_EQ(read_file(folder / "servo_a.csv"), read_file(folder / "again.csv"));
    write_file(folder / "finger.csv", "x,y,z\n0,0,1\n");
    EXPECT_NE(error_of([&] { replay(scene(), folder / "finger.csv", {}, true); }).find("x,y,z,qw,qx,qy,qz"),
              std::string::npos);
}

/// What a servo recorded is drawn: the tool where it was, and the load of all its points.
TEST_F(ToolLoop, IsDrawnFromItsCsv) {
    run("roll", "a");
    const ContactLoads loads(loaded_->tables());
    const auto frames = read_servo_csv(folder / "servo_a.csv", loads, FrameChoice{1, {}});
    const auto rows = read_rows(folder / "servo_a.csv");
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
    EXPECT_EQ(most, 7U);
}

/// A state whose pose did not come, or is of another state, is no tick.
TEST_F(ToolLoop, AStateWithoutItsPoseIsRefused) {
    Connection connection("memq://");
    LocalStepper stepper(scene());
    Session session(stepper, connection, nullptr);
    int answers = 0;
    connection.subscribe<servo_force>(channel_of<servo_force>(), [&](const servo_force&, std::int64_t) { ++answers; });
    connection.publish(channel_of<device_state>(), simulated_state(0, 0));
    handle_all(connection);
    EXPECT_EQ(answers, 0);
    hand_pose pose{};
    pose.session = kSession;
    pose.turn[0] = 1.0;
    connection.publish(channel_of<hand_pose>(), pose);
    connection.publish(channel_of<device_state>(), simulated_state(1, 1000));
    handle_all(connection);
    EXPECT_EQ(answers, 0);
    connection.publish(channel_of<device_state>(), simulated_state(0, 0));
    handle_all(connection);
    EXPECT_EQ(answers, 1);
    EXPECT_EQ(session.link_report().poseless_states, 2);
}

}  // namespace
}  // namespace haptable::test
