// SPDX-License-Identifier: GPL-2.0-or-later
// A target behind two pipes as the servo of a device: what is published, asked again, refused, and when it gives up.
#include "host/session/bridge/line_stepper.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <thread>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/error_of.hpp"
#include "tests/host/session/bridge/fake_target.hpp"

namespace haptable::test {
namespace {

constexpr std::int64_t kSimulated = 0, kReal = 2'000'000'000'000;

/// Asks again whenever it may.
LineOptions impatient(std::chrono::microseconds hold = LineOptions().hold) {
    return {.retry = std::chrono::microseconds(1), .hold = hold};
}

/// A box at the other end of a line.
struct BoxBehind : SoftBox, Behind {
    BoxBehind() : Behind(scene()) {}
};

/// A bridge to a line, and what it publishes.
struct Bridge {
    explicit Bridge(SerialTarget& line, const LineOptions& options = impatient()) : stepper(line, options) {
        connection.subscribe<servo_force>(channel_of<servo_force>(),
                                          [this](const servo_force& force, std::int64_t) { forces.push_back(force); });
    }
    void publish(const device_state& state) {
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    }
    void take_answers() {
        session.take_answers();
        handle_all(connection);
    }
    /// A millisecond later, when it asks again.
    void ask_again() {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        session.watch(Clock::now());
    }

    Connection connection{"memq://"};
    std::vector<std::string> told;  ///< events, a line each
    LineStepper stepper;
    Session session{stepper, connection, nullptr, [this](const std::string& text) { told.push_back(text); }};
    std::vector<servo_force> forces;
};

class BridgeSessionTest : public testing::Test, protected BoxBehind, protected Bridge {
protected:
    explicit BridgeSessionTest(const LineOptions& options = impatient()) : Bridge(line, options) {
        session.take_answers();  // its hello
    }
    /// Pressed deeper with every state; `seq` 0 is outside.
    void publish(std::int64_t seq, std::int64_t begin_us = kSimulated) {
        device_state state = simulated_state(seq, begin_us + seq * 1000);
        if (begin_us == kReal) state.mode = device_state::REAL_TIME;
        state.session = session_id;
        state.position_m[0] = 0.011;
        state.position_m[1] = 0.017;
        state.position_m[2] = 0.0301 - 1e-4 * double(seq);
        Bridge::publish(state);
    }
    void exchange() {
        target.answer();
        take_answers();
    }
    void press_in_real_time() {
        for (std::int64_t seq = 0; seq < 9; ++seq) {
            publish(seq, kReal);
            exchange();
        }
        ASSERT_EQ(int{forces.back().servo_state}, HAPTABLE_CONTACT);
        ASSERT_NE(forces.back().force_n[2], 0.0);
    }

    std::int64_t session_id = kSession;
};

TEST_F(BridgeSessionTest, AsksAgainAndStepsOnce) {
    publish(0);
    pipes.take();  // lost on its way
    ask_again();
    exchange();
    ASSERT_EQ(forces.size(), 1U);
    publish(1);
    target.answer();
    pipes.take_answers();  // the answer was lost
    ask_again();
    exchange();
    ASSERT_EQ(forces.size(), 2U);
    for (int a = 0; a < 3; ++a) EXPECT_EQ(forces.back().force_n[a], double(target.output().force_n[a]));
    publish(1);  // the device did not get it
    EXPECT_EQ(forces.size(), 3U);
    EXPECT_EQ(target.answer(), 0);
    EXPECT_EQ(session.link_report().repeated_states, 1);
    pipes.put({1, 2, 3});
    take_answers();

    std::map<std::string, std::int64_t> counted;
    connection.subscribe<servo_status>(channel_of<servo_status>(), [&](const servo_status& status, std::int64_t) {
        for (std::size_t i = 0; i < status.name.size(); ++i) counted[status.name[i]] = status.value[i];
    });
    session.publish_status();
    handle_all(connection);
    EXPECT_EQ(counted.at("ticks"), 2);
    EXPECT_EQ(target.counters().ticks, 2U);
    EXPECT_EQ(counted.at("resent_frames"), 2);
    EXPECT_EQ(counted.at("skipped_bytes"), 3);
}

TEST_F(BridgeSessionTest, AnOvertakenAnswerIsCountedAndNotPublished) {
    publish(0, kReal);
    publish(1, kReal);
    session.watch(Clock::now() + std::chrono::milliseconds(10));  // longer than it is waited for at first
    exchange();                                                   // both answers come now
    ASSERT_EQ(forces.size(), 1U);
    EXPECT_EQ(forces.back().seq, 1);
    EXPECT_EQ(stepper.counters().lost_answers, 1);
    EXPECT_EQ(stepper.counters().stale_answers, 1);
}

// A target that answers each state 1.5 ms late: every answer is of a state that it was asked for last, and is felt.
// Here none is overtaken, however busy this machine is.
class PatientBridgeSession : public BridgeSessionTest {
protected:
    PatientBridgeSession() : BridgeSessionTest(impatient(std::chrono::hours(1))) {}
};

TEST_F(PatientBridgeSession, GivesForceOfASlowTargetFromTheNewestState) {
    publish(0, kReal);
    std::int64_t seq = 0, answered = 0;
    for (; seq < 30; ++answered) {
        publish(++seq, kReal);
        if (answered % 2 == 1) publish(++seq, kReal);  // three states in two answers' time
        const Bytes asked = pipes.take();
        EXPECT_LE(asked.size(), std::size_t{HAPTABLE_LINE_STATE_BYTES}) << "a backlog";
        pipes.put_to_target(asked);
        exchange();
        ASSERT_EQ(forces.size(), std::size_t(answered) + 1);
        EXPECT_LE(seq - forces.back().seq, 3) << "not the newest";
    }
    EXPECT_EQ(stepper.counters().stale_answers + stepper.counters().lost_answers, 0);
    EXPECT_EQ(session.link_report().skipped_states, seq - answered);
    EXPECT_GT(forces.back().force_n[2], 0.0);
}

// One that takes longer than the bridge waits at first: it learns so, and then waits.
TEST_F(BridgeSessionTest, ASlowerTargetIsWaitedForOnceItIsKnown) {
    for (std::int64_t seq = 0; seq < 8; ++seq) {
        publish(seq, kReal);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        if (seq % 2 == 1) exchange();
    }
    EXPECT_GT(stepper.counters().stale_answers, 0);
    const std::size_t before = forces.size();
    for (std::int64_t seq = 8; seq < 12; ++seq) {
        publish(seq, kReal);
        if (seq % 2 == 1) exchange();
    }
    EXPECT_GT(forces.size(), before);
}

// A target that says 8.5 N at once: what the limit allows over its ticks is published, and no more.
TEST_F(BridgeSessionTest, AForceRisesNoFasterThanTheLimit) {
    haptable_model limited = *scene().model;
    limited.limit = haptable_limit_force;
    limited.rate = haptable_limit_rate;
    limited.rate_n = 0.1F * limited.max_force_n;
    ServoScene there = scene();
    there.model = &limited;
    Behind behind(there);
    Bridge bridge(behind.line);
    bridge.take_answers();
    const auto forces_after = [&](std::int64_t seq, float force_n) {
        bridge.publish(simulated_state(seq, seq * 1000));
        TargetAnswer answer;  // of the vertices 0, 0 and 0
        answer.output[0].state = HAPTABLE_CONTACT;
        answer.output[0].alpha[0] = 1.0F;
        answer.output[0].force_n[2] = force_n;
        behind.pipes.put(frame_of(behind.target.hello, answer, std::uint32_t(seq) + 1));
        bridge.take_answers();
        return bridge.forces.size();
    };
    EXPECT_EQ(forces_after(0, 1.5F * limited.rate_n), 0U);
    EXPECT_EQ(bridge.stepper.counters().rejected_forces, 1);
    EXPECT_EQ(forces_after(1, 1.5F * limited.rate_n), 1U);  // its second tick
    EXPECT_EQ(forces_after(2, -limited.rate_n), 2U);        // through nothing to the other side
    EXPECT_EQ(forces_after(3, 0.5F * limited.rate_n), 3U);
    EXPECT_EQ(forces_after(4, limited.max_force_n), 3U);
}

// Its first hello was lost, and is asked for before any state is sent; a tick waits for it.
TEST_F(BridgeSessionTest, AsksATargetWhatItIs) {
    Bridge bridge(line);
    bridge.publish(simulated_state(0, 0));
    EXPECT_EQ(pipes.take(), frame_of(target.hello)) << "no state";
    bridge.ask_again();
    EXPECT_EQ(target.answer(), 0);
    bridge.take_answers();
    EXPECT_EQ(target.answer(), 1);
    bridge.take_answers();
    EXPECT_EQ(bridge.forces.size(), 1U);
    EXPECT_EQ(target.counters().ticks, 1U);
}

// What the line throws while liblcm calls us comes out where it can be caught.
TEST_F(BridgeSessionTest, ALineThatTakesNothingIsAnError) {
    const Pipes stuck;
    const int full = open(stuck.to_target().c_str(), O_RDWR | O_NONBLOCK);
    while (write(full, "0123456789abcdef", 16) == 16) {
    }
    close(full);
    SerialTarget deaf(stuck.line(), scene());
    Bridge bridge(deaf);
    EXPECT_TRUE(fails_with([&] { bridge.publish(simulated_state(0, 0)); }, "takes no bytes for a second"));
}

// The target keeps its contact as long as its time runs on: for another device it must not.
TEST_F(BridgeSessionTest, AnotherSessionBeginsWithoutContact) {
    ASSERT_NO_FATAL_FAILURE(press_in_real_time());
    session_id = 5;
    std::this_thread::sleep_for(std::chrono::milliseconds(21));
    publish(9, kReal);
    exchange();
    EXPECT_EQ(forces.back().owner, 5);
    EXPECT_EQ(int{forces.back().servo_state}, HAPTABLE_FREE);
    for (std::int64_t seq = 10; seq < 12; ++seq) {
        publish(seq, kReal);
        exchange();
    }
    EXPECT_GE(target.counters().silences, 1U);
}

TEST_F(BridgeSessionTest, GivesZeroForceOnceWhenTheDeviceIsSilent) {
    std::int32_t loads = -1;
    connection.subscribe<contact>(channel_of<contact>(),
                                  [&](const contact& load, std::int64_t) { loads = load.count; });
    ASSERT_NO_FATAL_FAILURE(press_in_real_time());
    EXPECT_EQ(loads, 3);
    const std::size_t before = forces.size();
    for (int i = 0; i < 3; ++i) {
        session.watch(Clock::now() + std::chrono::milliseconds(21));
        handle_all(connection);
    }
    ASSERT_EQ(forces.size(), before + 1);
    EXPECT_EQ(forces.back().force_n[2], 0.0);
    EXPECT_EQ(int{forces.back().servo_state}, HAPTABLE_SILENT);
    EXPECT_EQ(loads, 0);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_TRUE(says(told[0], "contact dropped after a silence of"));
}

TEST_F(BridgeSessionTest, GivesUpOnADeafTarget) {
    Bridge bridge(line, {.retry = std::chrono::microseconds(1), .patience_s = 0.05});
    bridge.publish(simulated_state(0, 0));
    target.answer();  // what it is, and nothing more
    bridge.take_answers();
    const auto ask_for_long = [&] {
        for (int i = 0; i < 200; ++i) {
            pipes.take();
            bridge.ask_again();
        }
    };
    EXPECT_THROW(ask_for_long(), Error);
}

// ---- lines ---------------------------------------------------------------------------------------------------------

TEST(Line, ErrorsNameThePath) {
    WorkFolder folder;
    write_file(folder / "file", "x");
    EXPECT_TRUE(fails_with([] { Line::open("/dev/ttyNONE", 115200); }, "/dev/ttyNONE"));
    EXPECT_TRUE(fails_with([&] { Line::open(folder / "file", 115200); }, "serial port"));
    EXPECT_TRUE(fails_with([&] { Line::pipes(folder / "a", folder / "b"); }, "mkfifo"));
    EXPECT_TRUE(fails_with([] { Line::open("/dev/ptmx", 12345); }, "--baud 12345"));
}

/// Reads until `count` bytes have come or 5 s have passed.
Bytes read_from(Line& line, std::size_t count) {
    Bytes all;
    std::array<std::uint8_t, 64> some{};
    for (int tries = 0; tries < 5000 && all.size() < count; ++tries) {
        const std::size_t got = line.read(some);
        all.insert(all.end(), some.begin(), some.begin() + static_cast<std::ptrdiff_t>(got));
        if (got == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return all;
}

/// Every byte value: a terminal that is not raw would change some.
Bytes every_byte() {
    Bytes bytes(256);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

TEST(Line, ATtyHasTheSettingsThatWereAskedFor) {
    const Pty port;
    termios before{};
    ASSERT_EQ(tcgetattr(port.target(), &before), 0);
    before.c_cflag |= CSTOPB | PARENB | CRTSCTS | HUPCL;  // as a program before us may have left it
    before.c_iflag |= IXON;
    ASSERT_EQ(tcsetattr(port.target(), TCSANOW, &before), 0);
    const Line line = Line::open(port.name(), 2'000'000);
    termios now{};
    ASSERT_EQ(tcgetattr(port.target(), &now), 0);
    EXPECT_EQ(cfgetospeed(&now), speed_t{B2000000});
    EXPECT_EQ(cfgetispeed(&now), speed_t{B2000000});
    EXPECT_EQ(now.c_cflag & (CSIZE | CSTOPB | PARENB | CRTSCTS | HUPCL), tcflag_t{CS8});
    EXPECT_EQ(now.c_cflag & (CLOCAL | CREAD), tcflag_t{CLOCAL | CREAD});
    EXPECT_EQ(now.c_iflag & (IXON | ICRNL), 0U);
    EXPECT_EQ(now.c_lflag & (ICANON | ECHO | ISIG), 0U);
    EXPECT_EQ(now.c_oflag & OPOST, 0U);
}

TEST(Line, ATtyIsOursAlone) {
    const Pty port;
    const Line line = Line::open(port.name(), 115200);
    EXPECT_TRUE(fails_with([&] { Line::open(port.name(), 115200); }, "another program has it"));
}

// The cable is pulled out: reading and writing both say so, and what to do.
TEST(Line, ATtyThatVanishesIsAnErrorThatSaysWhatToDo) {
    Pty port;
    Line line = Line::open(port.name(), 115200);
    std::array<std::uint8_t, 8> some{};
    EXPECT_EQ(line.read(some), 0U) << "idle is no error";
    const std::string name = port.name();
    port.vanish();
    EXPECT_TRUE(fails_with([&] { read_from(line, 1); }, name + ": the port has gone: plug"));
    EXPECT_TRUE(fails_with([&] { line.write(every_byte()); }, name + ": the port has gone: plug"));
    EXPECT_TRUE(fails_with([&] { Line::open(name, 115200); }, "plugged in"));
}

TEST(Line, AUnixSocketIsALine) {
    WorkFolder folder;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (folder / "uart").string();
    path.copy(address.sun_path, path.size());
    const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_TRUE(fails_with([&] { Line::open(path, 115200); }, "does its other end listen"));
    ASSERT_EQ(listen(listening, 1), 0);
    Line line = Line::open(path, 115200);
    const int target = accept(listening, nullptr, nullptr);
    const Bytes bytes = every_byte();
    ASSERT_EQ(write(target, bytes.data(), bytes.size()), 256);
    EXPECT_EQ(read_from(line, 256), bytes);
    close(target);
    EXPECT_TRUE(fails_with([&] { read_from(line, 1); }, "has closed the line"));
    close(listening);
}

TEST(Line, AProgramIsALineAndItsEndIsAnError) {
    Line cat = Line::program("cat");
    cat.write(every_byte());
    EXPECT_EQ(read_from(cat, 256), every_byte());
    Line ended = Line::program("true");
    EXPECT_TRUE(fails_with([&] { read_from(ended, 1); }, "closed"));
}

}  // namespace
}  // namespace haptable::test
