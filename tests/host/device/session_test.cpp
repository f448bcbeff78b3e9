// SPDX-License-Identifier: GPL-2.0-or-later
// The device's side of the loop over memq://, with a partner that answers as each test wants.
#include "host/device/session.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "host/base/error.hpp"
#include "host/device/simulated_driver.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kHash = 77, kServo = 9;

class DeviceSessionTest : public testing::Test {
protected:
    /// Called for every state: what it leaves in the force is published where it returns true.
    using Partner = std::function<bool(const device_state&, servo_force&)>;

    /// A poke at a simulated device, beside a partner; what was published is in `states`, the record in the folder.
    DeviceReport run(const SessionOptions& options, const Partner& answer,
                     const std::string& record_name = "device.csv", const std::string& presses = "") {
        states.clear();
        connection.emplace("memq://");
        connection->subscribe<device_state>(channel_of<device_state>(),
                                            [this, answer](const device_state& state, std::int64_t) {
                                                states.push_back(state);
                                                servo_force force = answer_to(state);
                                                if (answer(state, force)) publish(force);
                                            });
        const auto path = scripted_path("poke", PathOptions{});
        const DeviceMapping mapping(options.map);
        SimulatedDriver driver(PointDevice(Device{}, Hand{}, mapping.to_device(path->at(0.0).position_m)), *path,
                               mapping, presses_of(presses));
        DeviceRecord record(folder / record_name);
        DeviceSession session(driver, *connection, options, &record);
        const DeviceReport report = session.run();
        record.finish();
        return report;
    }
    /// What a servo that belongs to the device says of its state.
    static servo_force answer_to(const device_state& state) {
        servo_force force{};
        force.seq = state.seq;
        force.session = force.owner = state.session;
        force.servo = kServo;
        force.model_hash = kHash;
        return force;
    }
    template <typename Message>
    void publish(const Message& message) {
        connection->publish(channel_of<Message>(), message);
    }
    std::vector<Row> rows() const { return read_rows(folder / "device.csv"); }

    WorkFolder folder;
    std::optional<Connection> connection;
    std::vector<device_state> states;
};

/// A wall at z = 0.03 m of 300 N/m.
bool push_up(const device_state& state, servo_force& force) {
    force.force_n[2] = 300.0 * std::max(0.0, 0.03 - state.position_m[2]);
    force.servo_state = force.force_n[2] > 0.0 ? servo_force::CONTACT : servo_force::FREE;
    return true;
}

SessionOptions lockstep(double patience_s = 5.0) {
    SessionOptions options;
    options.lockstep = true;
    options.patience_s = patience_s;
    return options;
}

SessionOptions real_time(double seconds) {
    SessionOptions options;
    options.seconds = seconds;
    return options;
}

// A servo of other tables does not answer it: its status tells the device so, and the device its user.
TEST_F(DeviceSessionTest, AServoOfAnotherSceneIsTold) {
    const auto of_another_scene = [this](const device_state&, servo_force&) {
        servo_status status{};
        status.model_hash = 0xc0be;
        publish(status);
        return false;
    };
    SessionOptions options = real_time(0.2);
    options.patience_s = 0.0;
    options.model_hash = 0x5eed;
    std::string told;
    options.tell = [&](const std::string& line) { told += line; };
    EXPECT_EQ(run(options, of_another_scene).largest_force_n, 0.0);
    for (const device_state& state : states) EXPECT_EQ(state.model_hash, 0x5eed);
    const std::string it = "runs the tables 000000000000c0be, this scene's are 0000000000005eed";
    EXPECT_TRUE(says(told, it));
    EXPECT_EQ(told.find(it), told.rfind(it)) << "a line an event";
    options.lockstep = true;
    options.patience_s = 0.2;
    EXPECT_TRUE(fails_with([&] { run(options, of_another_scene, "again.csv"); }, it));
}

TEST_F(DeviceSessionTest, LockstepAsksEveryTickOnceInOrder) {
    const DeviceReport report = run(lockstep(), push_up);
    EXPECT_EQ(report.ticks, 800);  // 15 mm down at 50 mm/s, 0.2 s, and up again
    EXPECT_EQ(report.missed, 0);
    EXPECT_EQ(report.resent, 0);
    ASSERT_EQ(states.size(), 800U);
    for (std::size_t i = 0; i < states.size(); ++i) {
        EXPECT_EQ(states[i].seq, std::int64_t(i));
        EXPECT_EQ(states[i].utime, std::int64_t(i) * 1000);
        EXPECT_EQ(states[i].mode, +device_state::SIMULATED);  // it has no address
        EXPECT_EQ(states[i].session, states[0].session);
        EXPECT_EQ(states[i].model_hash, i == 0 ? 0 : kHash);  // after the first answer: this servo only
        EXPECT_EQ(states[i].servo, i == 0 ? 0 : kServo);
    }
    EXPECT_NE(states[0].session, 0);
    EXPECT_GT(report.contact_ticks, 100);
    // Hand and wall in series: 200 N/m * 300 N/m / 500 N/m * 5 mm = 0.6 N, but for the friction of 0.04 N.
    EXPECT_WITHIN(std::abs(report.largest_force_n - 0.6), .epsilon = 0.05);
}

TEST_F(DeviceSessionTest, VelocityIsThatOfTheEncoders) {
    run(lockstep(), [](const device_state&, servo_force&) { return true; });
    for (std::size_t i = 10; i < states.size(); ++i)
        for (int a = 0; a < 3; ++a) {
            const double moved_m = states[i].position_m[a] - states[i - 10].position_m[a];
            EXPECT_WITHIN(std::abs(states[i].velocity_m_s[a] - moved_m / 0.01), .count = 8, .size = 0.05 / 0.01);
        }
    EXPECT_LT(states[150].velocity_m_s[2], -0.05);  // half way down: the peak of the movement, 94 mm/s
}

TEST_F(DeviceSessionTest, LockstepGivesUpWithAnError) {
    const auto five_answers = [](const device_state& state, servo_force&) { return state.seq < 5; };
    EXPECT_TRUE(fails_with([&] { run(lockstep(0.25), five_answers); }, "no answer to state 5"));
    EXPECT_EQ(folder.file_count(), 0U);  // no half-written record
    SessionOptions endless = lockstep();
    endless.seconds = 1e300;
    EXPECT_TRUE(fails_with([&] { run(endless, five_answers); }, "--seconds: 1e+300 s are more than"));
    EXPECT_TRUE(fails_with([&] { run(lockstep(1e300), five_answers); }, "--patience: 1e+300 s are more than"));
    const auto of_anothers = [](const device_state&, servo_force& force) {
        force.owner = 0xABCD;
        force.force_n[0] = 3.0;
        return true;
    };
    EXPECT_TRUE(fails_with([&] { run(lockstep(0.25), of_anothers); }, "session 000000000000abcd"));
}

TEST_F(DeviceSessionTest, IgnoresASecondServo) {
    SessionOptions loud = lockstep();
    std::string told;
    loud.tell = [&told](const std::string& line) { told += line + "\n"; };
    const DeviceReport report = run(loud, [this](const device_state& state, servo_force& force) {
        for (const std::int64_t hash : {std::int64_t{5}, kHash}) {
            servo_force foreign = force;
            foreign.servo = 10;
            foreign.model_hash = hash;
            foreign.force_n[0] = 3.0;
            if (state.seq > 0) publish(foreign);
        }
        return push_up(state, force);
    });
    EXPECT_GE(report.foreign_answers, 2 * 798);  // the last ones may come after the end
    EXPECT_LT(report.largest_force_n, 1.0);
    EXPECT_TRUE(says(told, "a second servo, or one of another scene, is on the channel"));
    EXPECT_EQ(told.find("a second servo"), told.rfind("a second servo")) << "once: " << told;
}

// Nor does an answer change anything that was overtaken by a newer one.
TEST_F(DeviceSessionTest, IgnoresWhatIsAnotherDevicesAndWhatWasOvertaken) {
    const DeviceReport report = run(lockstep(), [this](const device_state& state, servo_force& force) {
        servo_force theirs = force;
        theirs.session = theirs.owner = state.session + 1;
        theirs.force_n[0] = 3.0;
        publish(theirs);
        push_up(state, force);
        publish(force);
        --force.seq;
        force.force_n[0] = 3.0;
        return state.seq > 0;
    });
    EXPECT_GE(report.other_device_answers, 799);
    EXPECT_EQ(report.foreign_answers, 0);
    EXPECT_LT(report.largest_force_n, 1.0);
}

// A bridge or a servo that is started anew is another one: in lockstep the device asks for any after a second.
TEST_F(DeviceSessionTest, LockstepGoesOnWithAnotherServo) {
    std::int64_t unanswered = 0;
    SessionOptions options = lockstep();
    options.seconds = 0.01;
    const DeviceReport report = run(options, [&](const device_state& state, servo_force& force) {
        if (state.seq < 5) return push_up(state, force);
        force.servo = 10;
        if (state.servo == kServo) ++unanswered;
        return state.servo != kServo;
    });
    EXPECT_EQ(report.ticks, 10);
    EXPECT_EQ(report.missed, 0);
    EXPECT_GE(unanswered, 10);
}

// After silence the servo begins without contact: what it said before of the one that was is over.
TEST_F(DeviceSessionTest, RealTimeTakesNoAnswerOfBeforeTheSilence) {
    std::int64_t released_at = -1, last_named = -1;
    const DeviceReport report = run(real_time(0.06), [&](const device_state& state, servo_force& force) {
        if (state.servo == kServo) last_named = state.seq;
        if (state.seq > 10 && state.servo == 0 && released_at < 0) released_at = state.seq;
        if (released_at < 0) return state.seq <= 10;
        force.seq = last_named;
        force.force_n[0] = 3.0;
        return state.seq == released_at;
    });
    ASSERT_GT(released_at, 0);
    EXPECT_EQ(report.largest_force_n, 0.0);
    EXPECT_EQ(report.stale_answers, 1);
}

TEST_F(DeviceSessionTest, TheReportTellsOfAnswersThatAreMoreThan64TicksLate) {
    const DeviceReport report = run(real_time(0.13), [this](const device_state& state, servo_force&) {
        if (state.seq == 120) publish(answer_to(states[1]));
        return state.seq == 0;
    });
    // 119 ticks, less what the first state may have gone out late.
    EXPECT_GT(report.latency.max_us(), 64'000.0);
    EXPECT_EQ(report.stale_answers, 1);
}

TEST_F(DeviceSessionTest, RealTimeNeedsNoServoWithoutPatience) {
    const auto nobody = [](const device_state&, servo_force&) { return false; };
    SessionOptions options = real_time(0.02);
    options.patience_s = 0.0;
    const DeviceReport report = run(options, nobody);
    EXPECT_EQ(report.ticks, 20);
    EXPECT_EQ(report.missed, 20);
    EXPECT_EQ(report.silences, 0);
    options.lockstep = true;
    EXPECT_THROW(run(options, nobody), Error);
}

// A Touch-like frame, half the motion and twice the force: the wall is met where the body has it, and the hand feels
// 1/2 x 2 x 300 N/m along its own axis.
TEST_F(DeviceSessionTest, ADeviceOfAnotherFrameMeetsTheSameWall) {
    SessionOptions options = lockstep();
    options.map.position_m = {0.0, 0.0, 0.02};
    options.map.rotation_deg = {90.0, 0.0, 0.0};
    options.map.motion_scale = 0.5;
    options.map.force_scale = 2.0;
    // 10 mm of the hand's way beyond the wall: 200 x 300 / 500 x 10 mm.
    EXPECT_WITHIN(std::abs(run(options, push_up).largest_force_n - 1.2), .epsilon = 0.05);
    const auto ticks = rows();
    ASSERT_EQ(ticks.size(), 800U);
    EXPECT_WITHIN(std::abs(ticks[0].at("z") - 0.04), .epsilon = Device().encoder_step_m) << "the path is the body's";
    // The motors' force in the body's axes, of the finger in the body's coordinates.
    const Vector3d wall_n(0.0, 0.0, 2.0 * 300.0 * (0.03 - ticks[400].at("z")));
    EXPECT_WITHIN((xyz_of(ticks[400], "force_") - wall_n).norm(), .count = 64, .size = 1.2);
}

// Held down on the wall, the clutch pressed for 0.15 s while the hand goes on: no step of the finger, of the force no
// more than the ramp's and what the finger itself makes.
TEST_F(DeviceSessionTest, TheClutchBringsTheForceDownAndBackWithoutAStep) {
    SessionOptions options = lockstep();
    options.map.ramp_s = 0.05;
    const DeviceReport report = run(options, push_up, "device.csv", "clutch:0.35:0.5");
    const auto ticks = rows();
    // From the clutch on until the ramp is whole again; the tick in which it is whole does not count.
    EXPECT_EQ(report.clutched_ticks, 150 + 49);
    EXPECT_GT(ticks[349].at("force_z"), 0.5);
    EXPECT_EQ(ticks[420].at("force_z"), 0.0);
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        const double step_m = std::abs(ticks[i].at("z") - ticks[i - 1].at("z"));
        EXPECT_LT(step_m, 1.5e-4) << "the peak of a movement at 50 mm/s, " << i;
        EXPECT_LT(std::abs(ticks[i].at("force_z") - ticks[i - 1].at("force_z")), 0.7 / 50.0 + 300.0 * 1.5e-4) << i;
    }
    EXPECT_EQ(ticks[360].at("z"), ticks[499].at("z")) << "the finger stays";
    EXPECT_EQ(states[460].velocity_m_s[2], 0.0);
}

TEST(Presses, AreTextsOfButtonsAndTimes) {
    const std::vector<Press> presses = presses_of("clutch:0.5:0.8,grab:1:2");
    ASSERT_EQ(presses.size(), 2U);
    EXPECT_EQ(presses[0].button, kClutchButton);
    EXPECT_EQ(presses[0].to_s, 0.8);
    EXPECT_EQ(presses[1].button, kGrabButton);
    EXPECT_TRUE(presses_of("").empty());
    for (const char* wrong :
         {"clutch", "clutch:1", "clutch:2:1", "clutch:1:x", "horn:1:2", "clutch:1:2:3", ",grab:1:2"})
        EXPECT_THROW(presses_of(wrong), Error) << wrong;
}

}  // namespace
}  // namespace haptable::test
