// SPDX-License-Identifier: GPL-2.0-or-later
// Drivers of real devices against emulators, and Haply's own Python client against the same board.
#include "host/device/drivers.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <sstream>
#include <thread>

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

namespace haptable::test {
namespace {

// Packages of PyPI for tests that run without a network; scripts/python.sh brings them (make build/python/ready).
constexpr const char* kNoWheels = "the packages of PyPI are not there: make test installs them";
bool has_wheels() { return std::filesystem::exists(build_folder() / "python/ready"); }

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

/// What ends the ticks of a driver, which nothing else does.
std::string error_of_ticks(Driver& driver) {
    return error_of([&] { tick_until(driver, [](const Reading&) { return false; }); });
}

/// Waits a minute at most.
template <typename Done>
void expect_soon(Done done) {
    for (int i = 0; i < 60'000 && !done(); ++i) std::this_thread::sleep_for(kTick);
    EXPECT_TRUE(done());
}

std::int64_t counter(const Driver& driver, const std::string& name) {
    for (const Counter& one : driver.counters())
        if (one.name == name) return one.value;
    return -1;
}

TEST(Drivers, AreKnownByName) {
    DriverOptions of_hardware_4 = at_port("/dev/null");
    of_hardware_4.hardware = 4;
    const std::tuple<const char*, DriverOptions, const char*> wrong[] = {
        {"omni", {}, "simulated, inverse3, hapi, falcon"},
        {"hapi", {}, "--port"},
        {"falcon", {}, "--port"},
        {"falcon", at_port("/dev/no-such"), "/dev/no-such"},
        {"hapi", of_hardware_4, "--hardware"},
    };
    for (const auto& [name, options, error] : wrong)
        EXPECT_TRUE(fails_with([&] { open_driver(name, options); }, error)) << name;
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

constexpr double kFirst_deg = 130.0, kSecond_deg = 40.0;
const Vector2d kAngle = Vector2d(kFirst_deg, kSecond_deg) * kDegree;
const FiveBar kLinkage{0.07, 0.09, 0.038};

/// Ticks until the board was given another three torques; what was read last.
Reading tick_until_felt(Driver& driver, const HapiBoard& board) {
    const int before = board.torques();
    return tick_until(driver, [&](const Reading&) { return board.torques() > before + 3; });
}

class Hapi : public testing::TestWithParam<int> {
protected:
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
    HapiBoard theirs(140.0, 35.0), ours(140.0, 35.0);
    const Outcome outcome =
        run(fmt::format("{} tests/host/device/hapi_client.py {} {} 0.5 -0.25", python(), theirs.port(), GetParam()), {},
            std::chrono::seconds(120));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    std::istringstream printed(outcome.out);
    Vector3d end_m = Vector3d::Zero();
    Vector2d exact_nm;
    ASSERT_TRUE(printed >> end_m.x() >> end_m.y() >> exact_nm[0] >> exact_nm[1]) << outcome.out;

    const auto driver = open_driver("hapi", options(ours));
    driver->set_force(Vector3d(0.5, -0.25, 7e-3));
    const Reading reading = tick_until_felt(*driver, ours);
    EXPECT_EQ(ours.set_up(), theirs.set_up());
    // Angles come in float32: half a unit of 140 degrees is 7.6e-6.
    EXPECT_WITHIN((reading.position_m - end_m).norm(), .count = 4, .epsilon = kFloat, .size = 1.0);
    EXPECT_WITHIN((ours.torque_nm() - exact_nm).norm(), .count = 16, .epsilon = kFloat, .size = 0.1);
    EXPECT_WITHIN((theirs.torque_nm() - exact_nm).norm(), .count = 4, .epsilon = kFloat, .size = 0.1);
    EXPECT_GT(exact_nm.norm(), 0.01) << "the test must see a torque";
}

// Work of the torques over turned angles is that of the force over the end's way: the hand is pushed where the force
// points.
TEST_P(Hapi, TheForceIsCutAndPointsItsWay) {
    HapiBoard board(kFirst_deg, kSecond_deg);
    const FiveBar linkage{0.07, 0.09, GetParam() == 3 ? 0.038 : 0.0};
    const auto driver = open_driver("hapi", options(board));
    driver->set_force(Vector3d(40.0, 30.0, 0.0));
    EXPECT_WITHIN((driver->force_n() - Vector3d(2.4, 1.8, 0.0)).norm(), .count = 8, .size = 3.0);
    tick_until_felt(*driver, board);
    for (const int motor : {0, 1}) {
        const Vector2d step = 1e-6 * Vector2d::Unit(motor);
        const Vector2d way_m = (*linkage.end_m(kAngle + step) - *linkage.end_m(kAngle - step)) / 2e-6;
        EXPECT_WITHIN(std::abs(board.torque_nm()[motor] - Vector2d(2.4, 1.8).dot(way_m)), .count = 16,
                      .epsilon = kFloat, .size = 1.0);
    }
    driver->set_force(Vector3d(0.0, std::numeric_limits<double>::quiet_NaN(), 0.0));
    EXPECT_EQ(driver->force_n(), Vector3d::Zero());
}

INSTANTIATE_TEST_SUITE_P(Hardware, Hapi, testing::Values(2, 3));

TEST(HapiBoardTest, FollowsTheBoardAndLeavesItWithoutForce) {
    HapiBoard board(kFirst_deg, kSecond_deg);
    {
        const auto driver = open_driver("hapi", at_port(board.port()));
        driver->set_force(Vector3d(1.0, 1.0, 0.0));
        board.turn_to(131.0, 41.0);
        const Vector2d end_m = *kLinkage.end_m(Vector2d(131.0, 41.0) * kDegree);
        tick_until(*driver, [&](const Reading& r) { return (r.position_m.head<2>() - end_m).norm() < 1e-6; });
        tick_until_felt(*driver, board);
        EXPECT_GT(board.torque_nm().norm(), 0.01);
    }
    expect_soon([&] { return board.torque_nm() == Vector2d::Zero(); });
}

TEST(HapiBoardTest, GarbageIsCountedAndMovesNothing) {
    HapiBoard board(kFirst_deg, kSecond_deg);
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
            for (int i = 0; i < 2; ++i) HapiBoard::add(angle, garbage);
        }
        board.say(garbage);
        garbage.resize(1000);
        for (std::int64_t tick = 0; tick < 5; ++tick) {
            EXPECT_EQ(driver->read(tick).position_m, before_m);
            std::this_thread::sleep_for(kTick);
        }
    }
    EXPECT_GT(counter(*driver, "odd_readings"), 20);
    EXPECT_EQ(tick_until_felt(*driver, board).position_m, before_m);
}

TEST(HapiBoardTest, ABoardThatIsSilentIsAnError) {
    HapiBoard silent(kFirst_deg, kSecond_deg), mute(kFirst_deg, kSecond_deg);
    DriverOptions options = at_port(silent.port());
    options.silence_s = 0.5;
    const auto unanswered = open_driver("hapi", options);
    unanswered->set_force(Vector3d(1.0, 0.0, 0.0));
    silent.fall_silent();
    EXPECT_TRUE(says(error_of_ticks(*unanswered), "has not answered for"));
    EXPECT_EQ(unanswered->force_n(), Vector3d::Zero());
    EXPECT_GT(counter(*unanswered, "late_readings"), 1);
    expect_soon([&] { return silent.torque_nm() == Vector2d::Zero(); });  // told so, whether it listens or not
    mute.fall_silent();
    options.port = mute.port();
    options.patience_s = 0.2;
    EXPECT_TRUE(fails_with([&] { open_driver("hapi", options); }, "no reading within 0.2 s"));
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
        const Vector2d at_m = *kLinkage.end_m(angle_);
        if ((Vector2d(row.encoder_m.x(), row.encoder_m.z()) - place_m_ - at_m).norm() > 1e-6) return true;
        if (at_m.y() < begin_m_.y() - 0.003) return false;
        for (int newton = 0; newton < 4; ++newton)
            angle_ += kLinkage.jacobian(angle_)->inverse() * (at_m - Vector2d(0.0, 5e-5) - *kLinkage.end_m(angle_));
        board.turn_to(angle_[0] / kDegree, angle_[1] / kDegree);
        return true;
    }
    /// By which its motors push the end.
    Vector2d force_n() const { return kLinkage.jacobian(angle_)->transpose().inverse() * board.torque_nm(); }

    HapiBoard board{kFirst_deg, kSecond_deg};

private:
    std::size_t finger_;
    Vector2d angle_ = kAngle;
    Vector2d begin_m_ = *kLinkage.end_m(angle_);
    Vector2d place_m_ = Vector2d(finger_ == 0 ? 0.0102 : 0.0197, 0.032) - begin_m_;  // of the plate's origin, x and z
};

// Two boards, each with a session of its own: the first presses and rests, and feels the second come. A board that goes
// ends both.
TEST(HapiBoardTest, TwoBoardsAreTheFingersOfOneBody) {
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
        if (rests < 200 || second.goes_on(row) || ++rests != 400) return;
        beside_n = first.force_n().y();
        second.board.unplug();
    };
    DeviceSession sessions[] = {{*one, connection, of_first, nullptr}, {*other, connection, of_second, nullptr}};
    EXPECT_TRUE(fails_with([&] { run_together({&sessions[0], &sessions[1]}); }, second.board.port()));
    EXPECT_GT(alone_n, 0.01);
    EXPECT_LT(beside_n, 0.98 * alone_n) << "the second's dent takes the surface away";
    EXPECT_GT(second.force_n().y(), 0.01);
    EXPECT_GT(stepper.report(1).counters.contact_ticks, 100U);
}

// ---- Falcon --------------------------------------------------------------------------------------------------------

TEST(FalconDriver, HomesThenTellsTheGripAndPushesItTheRightWay) {
    const FalconBoard::Values none{0, 0, 0};
    const Vector3d grip_m(0.01, -0.02, 0.12), force_n(1.0, -0.5, 2.0);
    FalconBoard board(grip_m);
    const auto driver = open_driver("falcon", at_port(board.port()));
    EXPECT_GT(board.homing(), 0);
    EXPECT_EQ(board.motor(), none) << "no force before it is homed";
    board.press(3);
    const Reading reading = tick_until(*driver, [](const Reading& r) { return r.buttons != 0; });
    EXPECT_EQ(reading.buttons, kClutchButton | kGrabButton);
    // A count of an encoder is 0.0364 degrees of a leg of 60 mm and a lower arm: some 0.05 mm.
    EXPECT_WITHIN((reading.position_m - (grip_m - Vector3d(0.0, 0.0, 0.11))).norm(), .epsilon = 1e-4);

    driver->set_force(force_n);
    tick_until(*driver, [&](const Reading&) { return board.motor() != none; });
    // Turn a leg a little: its torque's work is the force's.
    Vector3d angle;
    for (const int leg : {0, 1, 2}) angle[leg] = falcon_angle(board.encoder()[std::size_t(leg)]);
    const Vector3d at_m = *falcon_grip_m(angle, grip_m);
    for (const int leg : {0, 1, 2}) {
        const Vector3d step = 1e-6 * Vector3d::Unit(leg);
        const Vector3d way_m = (*falcon_grip_m(angle + step, at_m) - *falcon_grip_m(angle - step, at_m)) / 2e-6;
        EXPECT_WITHIN(std::abs(board.motor()[std::size_t(leg)] + 1e4 * force_n.dot(way_m)), .epsilon = 0.6)
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
    EXPECT_TRUE(says(error_of_ticks(*driver), "has not answered for"));
}

// ---- Inverse3 ------------------------------------------------------------------------------------------------------

/// tests/host/device/inverse3_service.py on a port of its own.
class Service {
public:
    explicit Service(const char* mode)
        : process_(
              std::in_place,
              std::vector<std::string>{python(), "tests/host/device/inverse3_service.py", mode, "0.01", "0.02", "0.03"},
              Process::Place{{}, folder_ / "out.txt", folder_ / "err.txt"}) {
        expect_soon([this] { return said().find('\n') != std::string::npos; });
    }

    DriverOptions options() const {
        DriverOptions options = at_port("");
        options.url = "ws://127.0.0.1:" + lines_of(said()).at(0).substr(5);  // "port 1234"
        return options;
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
    std::string said() const {
        return std::filesystem::exists(folder_ / "out.txt") ? read_file(folder_ / "out.txt") : "";
    }

    WorkFolder folder_;
    std::optional<Process> process_;
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
            EXPECT_EQ(driver->read(0).position_m, Vector3d(0.01, 0.02, 0.03)) << "text keeps every digit";
            driver->set_force(Vector3d(0.1, -0.2, 0.3));
            tick_until(*driver, [&](const Reading&) { return service.force_n() == Vector3d(0.1, -0.2, 0.3); });
            driver->set_force(Vector3d(0.0, 40.0, -30.0));
            EXPECT_WITHIN((driver->force_n() - Vector3d(0.0, 2.4, -1.8)).norm(), .count = 8, .size = 3.0);
            const Reading pressed = tick_until(*driver, [](const Reading& r) { return r.buttons != 0; });
            EXPECT_EQ(pressed.buttons, kClutchButton);
            EXPECT_EQ(counter(*driver, "odd_readings"), 0);
        }
        expect_soon([&] { return service.force_n() == Vector3d::Zero(); });  // at the end it is let go
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
    const Service silent("silent"), closes("closes");
    DriverOptions options = silent.options();
    options.silence_s = 0.5;
    const auto unanswered = open_driver("inverse3", options);
    EXPECT_TRUE(says(error_of_ticks(*unanswered), "has not answered for"));
    EXPECT_EQ(unanswered->force_n(), Vector3d::Zero());
    const auto closed = open_driver("inverse3", closes.options());
    EXPECT_TRUE(says(error_of_ticks(*closed), "the service has closed the connection"));

    Service empty("empty");
    options = empty.options();
    options.patience_s = 0.5;
    const auto open = [&] { open_driver("inverse3", options); };
    EXPECT_TRUE(fails_with(open, "with an Inverse3 plugged in?"));
    empty.end();
    EXPECT_TRUE(fails_with(open, "does not listen"));
    options.url = "http://localhost:1";
    EXPECT_TRUE(fails_with(open, "--url"));
}

}  // namespace
}  // namespace haptable::test
