// SPDX-License-Identifier: GPL-2.0-or-later
// Drivers of real devices against emulators, and Haply's own Python client against the same board.
#include "host/device/drivers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>
#include <thread>

#include "host/base/error.hpp"
#include "host/device/exchange_driver.hpp"
#include "host/device/five_bar.hpp"
#include "host/device/session.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/session.hpp"
#include "tests/error_of.hpp"
#include "tests/host/device/falcon_board.hpp"
#include "tests/host/device/hapi_board.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/soft_pair.hpp"
#include "tests/process.hpp"
#include "tests/tolerance.hpp"
#include "tests/wheels.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
// A machine under load may stop an emulator for longer than 20 ms; that a silent one is told is tested apart.
constexpr double kPatient_s = 20.0;

/// Python with the packages of scripts/python.sh.
std::string python() { return (build_folder() / "python/bin/python3").string(); }

DriverOptions at_port(const std::string& port) {
    DriverOptions options;
    options.port = port;
    options.max_force_n = 3.0;
    options.patience_s = options.silence_s = kPatient_s;
    return options;
}

/// Ticks until `done`; what was read last. A minute is given up.
template <typename Done>
Reading tick_until(Driver& driver, Done done) {
    Reading reading;
    for (std::int64_t tick = 0; tick < 60'000; ++tick) {
        reading = driver.read(tick);
        if (done(reading)) return reading;
        std::this_thread::sleep_for(kTick);
    }
    ADD_FAILURE() << "a minute has passed";
    return reading;
}

std::int64_t counter(const Driver& driver, const std::string& name) {
    for (const Counter& one : driver.counters())
        if (one.name == name) return one.value;
    return -1;
}

TEST(Drivers, AreKnownByName) {
    EXPECT_NE(error_of([] { open_driver("omni", {}); }).find("simulated, inverse3, hapi, falcon"), std::string::npos);
    EXPECT_NE(error_of([] { open_driver("hapi", {}); }).find("--port"), std::string::npos);
    EXPECT_NE(error_of([] { open_driver("falcon", {}); }).find("--port"), std::string::npos);
    EXPECT_NE(error_of([] { open_driver("falcon", at_port("/dev/no-such")); }).find("/dev/no-such"), std::string::npos);
    DriverOptions wrong = at_port("/dev/null");
    wrong.hardware = 4;
    EXPECT_NE(error_of([&] { open_driver("hapi", wrong); }).find("--hardware"), std::string::npos);
}

/// A device that is at once wherever a test says.
class Anywhere : public ExchangeDriver {
public:
    explicit Anywhere(const DriverOptions& options) : ExchangeDriver("anywhere", options) { wait_for_first(1.0, ""); }
    Vector3d position_m = Vector3d::Zero();

private:
    void send(const Vector3d&) override {}
    bool take(Reading& reading) override {
        reading.position_m = position_m;
        return true;
    }
};

TEST(Drivers, APlaceThatNoHandReachesIsLeftOut) {
    Anywhere driver(at_port(""));
    driver.position_m.x() = 5e-4;
    EXPECT_EQ(driver.read(0).position_m.x(), 5e-4);
    driver.position_m.x() = 1e6;  // 10 m/s take a day
    EXPECT_EQ(driver.read(1).position_m.x(), 5e-4);
    driver.position_m.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(driver.read(2).position_m.x(), 5e-4);
    EXPECT_EQ(counter(driver, "odd_readings"), 2);
    EXPECT_EQ(counter(driver, "late_readings"), 2);
    driver.position_m.x() = 6e-4;
    EXPECT_EQ(driver.read(3).position_m.x(), 6e-4);
}

// ---- hAPI ----------------------------------------------------------------------------------------------------------

class Hapi : public testing::TestWithParam<int> {
protected:
    FiveBar linkage() const { return {0.07, 0.09, GetParam() == 3 ? 0.038 : 0.0}; }
    DriverOptions options(const HapiBoard& board) const {
        DriverOptions options = at_port(board.port());
        options.hardware = GetParam();
        return options;
    }
};

// Haply's unmodified Python client and our driver at the same board: the same set-up byte for byte, the same place, the
// same torques for a force.
TEST_P(Hapi, TheDriverIsWhatHaplysOwnClientIs) {
    if (!has_wheels()) GTEST_SKIP() << kNoWheels;
    const Vector2d degrees(140.0, 35.0), force_n(0.5, -0.25);
    HapiBoard theirs(degrees[0], degrees[1]), ours(degrees[0], degrees[1]);
    const Outcome outcome = run(python() + " tests/host/device/hapi_client.py " + theirs.port() + " " +
                                    std::to_string(GetParam()) + " 0.5 -0.25",
                                {}, std::chrono::seconds(120));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream printed(outcome.out);
    double x = 0.0, y = 0.0, first_nm = 0.0, second_nm = 0.0;
    ASSERT_TRUE(printed >> x >> y >> first_nm >> second_nm) << outcome.out;

    const auto driver = open_driver("hapi", options(ours));
    const int before = ours.torques();
    driver->set_force(Vector3d(force_n.x(), force_n.y(), 7e-3));
    const Reading reading = tick_until(*driver, [&](const Reading&) { return ours.torques() > before + 3; });
    EXPECT_EQ(ours.set_up(), theirs.set_up());
    // Angles come in float32: half a unit of 140 degrees is 7.6e-6.
    EXPECT_WITHIN((reading.position_m - Vector3d(x, y, 0.0)).norm(), .count = 4, .epsilon = kFloat, .size = 1.0);
    const Vector2d exact_nm(first_nm, second_nm);
    EXPECT_WITHIN((ours.torque_nm() - exact_nm).norm(), .count = 16, .epsilon = kFloat, .size = 0.1);
    EXPECT_WITHIN((theirs.torque_nm() - exact_nm).norm(), .count = 4, .epsilon = kFloat, .size = 0.1);
    EXPECT_GT(exact_nm.norm(), 0.01) << "the test must see a torque";
}

// Work of the torques over turned angles is that of the force over the end's way: the hand is pushed where the force
// points.
TEST_P(Hapi, TheForceIsCutAndPointsItsWay) {
    HapiBoard board(130.0, 40.0);
    const auto driver = open_driver("hapi", options(board));
    driver->set_force(Vector3d(40.0, 30.0, 0.0));
    EXPECT_WITHIN((driver->force_n() - Vector3d(2.4, 1.8, 0.0)).norm(), .count = 8, .size = 3.0);
    const int before = board.torques();
    tick_until(*driver, [&](const Reading&) { return board.torques() > before + 3; });
    const Vector2d angle = Vector2d(130.0, 40.0) * kDegree;
    for (const int motor : {0, 1}) {
        const Vector2d step = 1e-6 * Vector2d::Unit(motor);
        const Vector2d way_m = (*linkage().end_m(angle + step) - *linkage().end_m(angle - step)) / 2e-6;
        EXPECT_WITHIN(std::abs(board.torque_nm()[motor] - Vector2d(2.4, 1.8).dot(way_m)), .count = 16,
                      .epsilon = kFloat, .size = 1.0);
    }
    driver->set_force(Vector3d(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0));
    EXPECT_EQ(driver->force_n(), Vector3d::Zero());
}

INSTANTIATE_TEST_SUITE_P(Hardware, Hapi, testing::Values(2, 3));

TEST(HapiBoardTest, FollowsTheBoardAndLeavesItWithoutForce) {
    HapiBoard board(130.0, 40.0);
    {
        const auto driver = open_driver("hapi", at_port(board.port()));
        driver->set_force(Vector3d(1.0, 1.0, 0.0));
        board.turn_to(131.0, 41.0);
        const FiveBar linkage{0.07, 0.09, 0.038};
        const Vector2d end_m = *linkage.end_m(Vector2d(131.0, 41.0) * kDegree);
        tick_until(*driver, [&](const Reading& r) { return (r.position_m.head<2>() - end_m).norm() < 1e-6; });
        const int before = board.torques();
        tick_until(*driver, [&](const Reading&) { return board.torques() > before + 3; });
        EXPECT_GT(board.torque_nm().norm(), 0.01);
    }
    for (int i = 0; i < 60'000 && board.torque_nm() != Vector2d::Zero(); ++i) std::this_thread::sleep_for(kTick);
    EXPECT_EQ(board.torque_nm(), Vector2d::Zero());
}

TEST(HapiBoardTest, GarbageIsCountedAndMovesNothing) {
    HapiBoard board(130.0, 40.0);
    const auto driver = open_driver("hapi", at_port(board.port()));
    const Vector3d before_m = driver->read(0).position_m;
    std::vector<std::uint8_t> garbage(1000);
    unsigned seed = 1;
    for (int round = 0; round < 20; ++round) {
        for (auto& byte : garbage) byte = static_cast<std::uint8_t>((seed = seed * 1664525U + 1013904223U) >> 24);
        // Without a checksum what begins with the device's number may be an answer: here none does but those below.
        std::replace(garbage.begin(), garbage.end(), std::uint8_t{5}, std::uint8_t{6});
        for (const float angle : {1e30F, std::numeric_limits<float>::quiet_NaN(), 400.0F}) {
            garbage.push_back(5);
            for (int i = 0; i < 2; ++i)
                for (int shift = 0; shift < 32; shift += 8)
                    garbage.push_back(static_cast<std::uint8_t>(std::bit_cast<std::uint32_t>(angle) >> shift));
        }
        board.say(garbage);
        garbage.resize(1000);
        for (std::int64_t tick = 0; tick < 5; ++tick) {
            EXPECT_EQ(driver->read(tick).position_m, before_m);
            std::this_thread::sleep_for(kTick);
        }
    }
    EXPECT_GT(counter(*driver, "odd_readings"), 20);
    const int before = board.torques();
    tick_until(*driver, [&](const Reading& r) { return r.position_m == before_m && board.torques() > before + 3; });
}

TEST(HapiBoardTest, ABoardThatIsSilentOrGoneIsAnError) {
    HapiBoard board(130.0, 40.0);
    DriverOptions options = at_port(board.port());
    const auto driver = open_driver("hapi", options);
    driver->set_force(Vector3d(1.0, 0.0, 0.0));
    board.unplug();
    const std::string gone = error_of([&] { tick_until(*driver, [](const Reading&) { return false; }); });
    EXPECT_NE(gone.find(options.port), std::string::npos) << gone;

    HapiBoard silent(130.0, 40.0);
    options = at_port(silent.port());
    options.silence_s = 0.5;
    const auto unanswered = open_driver("hapi", options);
    unanswered->set_force(Vector3d(1.0, 0.0, 0.0));
    silent.fall_silent();
    const std::string told = error_of([&] { tick_until(*unanswered, [](const Reading&) { return false; }); });
    EXPECT_NE(told.find("has not answered for"), std::string::npos) << told;
    EXPECT_EQ(unanswered->force_n(), Vector3d::Zero());
    EXPECT_GT(counter(*unanswered, "late_readings"), 1);
    for (int i = 0; i < 60'000 && silent.torque_nm() != Vector2d::Zero(); ++i) std::this_thread::sleep_for(kTick);
    EXPECT_EQ(silent.torque_nm(), Vector2d::Zero()) << "it was told so, whether it listens or not";
    options.patience_s = 0.2;
    HapiBoard mute(130.0, 40.0);
    mute.fall_silent();
    options.port = mute.port();
    const std::string never = error_of([&] { open_driver("hapi", options); });
    EXPECT_NE(never.find("no reading within 0.2 s"), std::string::npos) << never;
}

// The whole session: a wall in the plate's plane is felt by the board's motors, and a board that goes ends it.
TEST(HapiBoardTest, ASessionFeelsAWallThroughIt) {
    WorkFolder folder;
    HapiBoard board(130.0, 40.0);
    Connection connection("memq://");
    const double y_m = FiveBar{0.07, 0.09, 0.038}.end_m(Vector2d(130.0, 40.0) * kDegree)->y();
    std::int64_t ticks = 0;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state& state, std::int64_t) {
        servo_force force{};
        force.seq = state.seq;
        force.session = force.owner = state.session;
        force.servo = 1;
        force.model_hash = 1;
        // The body's z is the plate's y: a wall 2 mm above the finger pushes it down.
        force.force_n[2] = -500.0 * (state.position_m[2] - (y_m - 0.002));
        force.servo_state = servo_force::CONTACT;
        connection.publish(channel_of<servo_force>(), force);
        if (++ticks == 50) board.unplug();
    });
    const auto driver = open_driver("hapi", at_port(board.port()));
    SessionOptions options;
    options.seconds = 60.0;
    options.map.rotation_deg = {90.0, 0.0, 0.0};
    DeviceRecord record(folder / "device.csv");
    DeviceSession session(*driver, connection, options, &record);
    const std::string gone = error_of([&] { session.run(); });
    EXPECT_NE(gone.find(board.port()), std::string::npos) << gone;
    const Vector2d angle = Vector2d(130.0, 40.0) * kDegree;
    const Vector2d torque_nm = FiveBar{0.07, 0.09, 0.038}.jacobian(angle)->transpose() * Vector2d(0.0, -1.0);
    EXPECT_WITHIN((board.torque_nm() - torque_nm).norm(), .count = 64, .epsilon = kFloat, .size = 1.0);
}

/// A board whose plate is stood up beside the body's top: its end goes down into it, a step of 0.05 mm at a time.
class Finger {
public:
    explicit Finger(std::size_t finger) : finger_(finger) {}

    SessionOptions options() const {
        SessionOptions options;
        options.lockstep = true;  // of the emulators, which a busy machine stops for longer than a servo waits
        options.seconds = 60.0;
        options.finger = finger_;
        options.map.rotation_deg = {90.0, 0.0, 0.0};
        options.map.position_m = {place_m_.x(), 0.0143, place_m_.y()};
        return options;
    }
    /// The next step once the last one was read: false where it has come to its end.
    bool goes_on(const DeviceRow& row) {
        const Vector2d at_m = *linkage_.end_m(angle_);
        if ((Vector2d(row.encoder_m.x(), row.encoder_m.z()) - place_m_ - at_m).norm() > 1e-6) return true;
        if (at_m.y() < begin_m_.y() - 0.003) return false;
        for (int newton = 0; newton < 4; ++newton)
            angle_ += linkage_.jacobian(angle_)->inverse() * (at_m - Vector2d(0.0, 5e-5) - *linkage_.end_m(angle_));
        board.turn_to(angle_[0] / kDegree, angle_[1] / kDegree);
        return true;
    }
    /// By which its motors push the end.
    Vector2d force_n() const { return linkage_.jacobian(angle_)->transpose().inverse() * board.torque_nm(); }

    HapiBoard board{130.0, 40.0};

private:
    std::size_t finger_;
    FiveBar linkage_{0.07, 0.09, 0.038};
    Vector2d angle_ = Vector2d(130.0, 40.0) * kDegree;
    Vector2d begin_m_ = *linkage_.end_m(angle_);
    Vector2d place_m_ = Vector2d(finger_ == 0 ? 0.0102 : 0.0197, 0.032) - begin_m_;  // of the plate's origin, x and z
};

// Two boards, each with a session of its own: the first presses and rests, and feels the second come.
TEST(HapiBoardTest, TwoBoardsAreTheFingersOfOneBody) {
    struct Done {};
    const SoftPair body;
    Connection connection("memq://");
    LocalStepper stepper(body.scene());
    Session servo(stepper, connection, nullptr);
    Finger first(0), second(1);
    double alone_n = 0.0, beside_n = 0.0;
    const auto one = open_driver("hapi", at_port(first.board.port()));
    const auto other = open_driver("hapi", at_port(second.board.port()));
    int rests = 0;
    SessionOptions of_first = first.options(), of_second = second.options();
    of_first.watch = [&](const DeviceRow& row) {
        if (!first.goes_on(row) && rests < 200 && ++rests == 200) alone_n = first.force_n().y();
    };
    of_second.watch = [&](const DeviceRow& row) {
        if (rests < 200 || second.goes_on(row) || ++rests < 400) return;
        beside_n = first.force_n().y();
        throw Done();
    };
    DeviceSession sessions[] = {{*one, connection, of_first, nullptr}, {*other, connection, of_second, nullptr}};
    EXPECT_THROW(run_together({&sessions[0], &sessions[1]}), Done);
    EXPECT_GT(alone_n, 0.01);
    EXPECT_LT(beside_n, 0.98 * alone_n) << "the second's dent takes the surface away";
    EXPECT_GT(second.force_n().y(), 0.01);
    EXPECT_GT(stepper.report(1).counters.contact_ticks, 100U);
}

// ---- Falcon --------------------------------------------------------------------------------------------------------

TEST(FalconDriver, HomesThenTellsTheGripAndPushesItTheRightWay) {
    const Vector3d grip_m(0.01, -0.02, 0.12), force_n(1.0, -0.5, 2.0);
    FalconBoard board(grip_m);
    const auto driver = open_driver("falcon", at_port(board.port()));
    EXPECT_GT(board.homing(), 0);
    EXPECT_EQ(board.motor(), (std::array<std::int16_t, 3>{0, 0, 0})) << "no force before it is homed";
    board.press(3);
    const Reading reading = tick_until(*driver, [](const Reading& r) { return r.buttons != 0; });
    EXPECT_EQ(reading.buttons, kClutchButton | kGrabButton);
    // A count of an encoder is 0.0364 degrees of a leg of 60 mm and a lower arm: some 0.05 mm.
    EXPECT_WITHIN((reading.position_m - (grip_m - Vector3d(0.0, 0.0, 0.11))).norm(), .epsilon = 1e-4);

    driver->set_force(force_n);
    tick_until(*driver, [&](const Reading&) { return board.motor() != std::array<std::int16_t, 3>{0, 0, 0}; });
    // Turn a leg a little: its torque's work is the force's.
    Vector3d angle;
    for (const int leg : {0, 1, 2}) angle[leg] = falcon_angle(board.encoder()[static_cast<std::size_t>(leg)]);
    const Vector3d at_m = *falcon_grip_m(angle, grip_m);
    for (const int leg : {0, 1, 2}) {
        const Vector3d step = 1e-6 * Vector3d::Unit(leg);
        const Vector3d way_m = (*falcon_grip_m(angle + step, at_m) - *falcon_grip_m(angle - step, at_m)) / 2e-6;
        EXPECT_WITHIN(std::abs(board.motor()[static_cast<std::size_t>(leg)] + 1e4 * force_n.dot(way_m)), .epsilon = 0.6)
            << "rounded to a value; leg " << leg;
    }
    EXPECT_EQ(board.odd(), 0);
}

TEST(FalconDriver, AForceBeyondTheMotorsKeepsItsDirection) {
    FalconBoard board(Vector3d(0.0, 0.0, 0.11));
    DriverOptions options = at_port(board.port());
    options.max_force_n = 100.0;
    const auto driver = open_driver("falcon", options);
    driver->set_force(Vector3d(0.0, 0.0, 100.0));
    tick_until(*driver, [&](const Reading&) { return board.motor()[0] != 0; });
    for (const std::int16_t value : board.motor()) EXPECT_EQ(value, -4095);
}

TEST(FalconDriver, GarbageMovesNothingAndSilenceIsAnError) {
    FalconBoard board(Vector3d(0.0, 0.0, 0.11));
    DriverOptions options = at_port(board.port());
    options.silence_s = 0.5;
    const auto driver = open_driver("falcon", options);
    const Vector3d before_m = driver->read(0).position_m;
    const std::string garbage =
        "<AAAAaAAAAAAAA\xB1"
        "A><<<>>>PPPPPPPPPPPPPPPPP";  // nearly a frame, and then not
    for (int round = 0; round < 20; ++round) {
        board.say({reinterpret_cast<const std::uint8_t*>(garbage.data()), garbage.size()});
        for (std::int64_t tick = 0; tick < 3; ++tick) {
            // Newton's steps end at 1e-12 m, from wherever they begin.
            EXPECT_WITHIN((driver->read(tick).position_m - before_m).norm(), .epsilon = 1e-12);
            std::this_thread::sleep_for(kTick);
        }
    }
    EXPECT_GT(counter(*driver, "odd_readings"), 5);
    board.fall_silent();
    const std::string told = error_of([&] { tick_until(*driver, [](const Reading&) { return false; }); });
    EXPECT_NE(told.find("has not answered for"), std::string::npos) << told;
}

// ---- Inverse3 ------------------------------------------------------------------------------------------------------

/// tests/host/device/inverse3_service.py on a port of its own.
class Service {
public:
    explicit Service(const std::string& mode, const std::string& cursor = "0.01 0.02 0.03") {
        std::vector<std::string> command{python(), "tests/host/device/inverse3_service.py", mode};
        std::istringstream in(cursor);
        for (std::string number; in >> number;) command.push_back(number);
        process_.emplace(command, Process::Place{{}, folder_ / "out.txt", folder_ / "err.txt"});
        for (int i = 0; i < 60'000 && port_.empty(); ++i, std::this_thread::sleep_for(kTick)) {
            const std::string text = said();
            if (text.starts_with("port ") && text.find('\n') != std::string::npos)
                port_ = text.substr(5, text.find('\n') - 5);
        }
        if (port_.empty()) throw std::runtime_error("no service: " + read_file(folder_ / "err.txt"));
    }

    DriverOptions options() const {
        DriverOptions options = at_port("");
        options.url = "ws://127.0.0.1:" + port_;
        return options;
    }
    std::string said() const {
        return std::filesystem::exists(folder_ / "out.txt") ? read_file(folder_ / "out.txt") : "";
    }
    /// The last force that it was given, N.
    Vector3d force_n() const {
        const std::vector<std::string> lines = lines_of(said());
        Vector3d force = Vector3d::Constant(99.0);
        std::string word;
        if (lines.size() > 1) std::istringstream(lines.back()) >> word >> force[0] >> force[1] >> force[2];
        return force;
    }
    void end() { process_.reset(); }

private:
    WorkFolder folder_;
    std::optional<Process> process_;
    std::string port_;
};

class Inverse3 : public testing::Test {
protected:
    void SetUp() override {
        if (!has_wheels()) GTEST_SKIP() << kNoWheels;
    }
};

TEST_F(Inverse3, TellsTheCursorAndTakesTheForce) {
    for (const char* mode : {"plain", "greeting"}) {
        Service service(mode);
        {
            const auto driver = open_driver("inverse3", service.options());
            const Reading reading = driver->read(0);
            EXPECT_EQ(reading.position_m, Vector3d(0.01, 0.02, 0.03)) << "text keeps every digit";
            driver->set_force(Vector3d(0.1, -0.2, 0.3));
            tick_until(*driver, [&](const Reading&) { return service.force_n() == Vector3d(0.1, -0.2, 0.3); });
            driver->set_force(Vector3d(0.0, 40.0, -30.0));
            EXPECT_WITHIN((driver->force_n() - Vector3d(0.0, 2.4, -1.8)).norm(), .count = 8, .size = 3.0);
            const Reading pressed = tick_until(*driver, [](const Reading& r) { return r.buttons != 0; });
            EXPECT_EQ(pressed.buttons, kClutchButton);
            EXPECT_EQ(counter(*driver, "odd_readings"), 0);
        }
        for (int i = 0; i < 60'000 && service.force_n() != Vector3d::Zero(); ++i) std::this_thread::sleep_for(kTick);
        EXPECT_EQ(service.force_n(), Vector3d::Zero()) << "at the end it is let go";
    }
}

TEST_F(Inverse3, GarbageIsCountedAndMovesNothing) {
    Service service("garbage");
    const auto driver = open_driver("inverse3", service.options());
    // Every kind of it, of which one is never a text.
    tick_until(*driver, [&](const Reading& reading) {
        EXPECT_EQ(reading.position_m, Vector3d(0.01, 0.02, 0.03));
        return counter(*driver, "odd_readings") > 12;
    });
}

TEST_F(Inverse3, AServiceThatIsSilentGoneOrEmptyIsAnError) {
    Service silent("silent");
    DriverOptions options = silent.options();
    options.silence_s = 0.5;
    const auto unanswered = open_driver("inverse3", options);
    const std::string told = error_of([&] { tick_until(*unanswered, [](const Reading&) { return false; }); });
    EXPECT_NE(told.find("has not answered for"), std::string::npos) << told;
    EXPECT_EQ(unanswered->force_n(), Vector3d::Zero());

    Service closes("closes");
    const auto closed = open_driver("inverse3", closes.options());
    const std::string gone = error_of([&] { tick_until(*closed, [](const Reading&) { return false; }); });
    EXPECT_NE(gone.find("the service has closed the connection"), std::string::npos) << gone;

    Service empty("empty");
    options = empty.options();
    options.patience_s = 0.5;
    const std::string none = error_of([&] { open_driver("inverse3", options); });
    EXPECT_NE(none.find("with an Inverse3 plugged in?"), std::string::npos) << none;
    empty.end();
    const std::string nobody = error_of([&] { open_driver("inverse3", options); });
    EXPECT_NE(nobody.find("does not listen"), std::string::npos) << nobody;
    options.url = "http://localhost:1";
    EXPECT_NE(error_of([&] { open_driver("inverse3", options); }).find("--url"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
