// SPDX-License-Identifier: GPL-2.0-or-later
// A target behind two pipes as the servo of a device: what is published, asked again, refused, and when it gives up.
#include "host/session/bridge/line_stepper.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>

#include <numeric>
#include <thread>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/asked_session.hpp"

namespace haptable::test {
namespace {

using std::chrono::milliseconds;

/// Asks again after a millisecond.
constexpr LineOptions kImpatient{.retry = std::chrono::milliseconds(1)};

/// A bridge to a cube for one finger, and a target that answers when a test says so.
class BridgeSessionTest : public AskedSession, public testing::Test {
protected:
    explicit BridgeSessionTest(const ServoScene& of = soft_pair().scene_of_one()) : AskedSession(of, true, kImpatient) {
        answers_by_itself = false;
    }
    /// Pressed deeper with every state; `seq` 0 is outside.
    void publish(std::int64_t seq, std::int8_t mode = device_state::SIMULATED) {
        send(0, state(0, seq, 1e-4 * double(seq) - 1e-4, mode));
    }
    void publish_real(std::int64_t seq) { publish(seq, device_state::REAL_TIME); }
    void answer() {
        target.answer();
        exchange();
    }
    std::size_t answers() const { return forces[0].size(); }
    LineCounters counters() const { return dynamic_cast<const LineStepper&>(*stepper).counters(); }

    Pipes& pipes = behind->pipes;
    FakeTarget<Pipes>& target = behind->target;
};

TEST_F(BridgeSessionTest, AsksAgainAndStepsOnce) {
    publish(0);
    pipes.take();  // lost on its way
    wait(milliseconds(1));
    answer();
    ASSERT_EQ(answers(), 1U);
    publish(1);
    target.answer();
    pipes.take_answers();  // the answer was lost
    wait(milliseconds(1));
    answer();
    ASSERT_EQ(answers(), 2U);
    for (int a = 0; a < 3; ++a) EXPECT_EQ(forces[0].back().force_n[a], double(target.output().force_n[a]));
    publish(1);  // the device did not get it
    EXPECT_EQ(answers(), 3U);
    EXPECT_EQ(target.answer(), 0);
    EXPECT_EQ(session->link_report().repeated_states, 1);
    pipes.put({1, 2, 3});
    exchange();
    EXPECT_EQ(status("ticks"), 2);
    EXPECT_EQ(target.counters().ticks, 2U);
    EXPECT_EQ(status("resent_frames"), 2);
    EXPECT_EQ(status("skipped_bytes"), 3);
}

TEST_F(BridgeSessionTest, AnOvertakenAnswerIsCountedAndNotPublished) {
    publish_real(0);
    publish_real(1);
    session->watch(Clock::now() + milliseconds(10));  // longer than it is waited for at first
    answer();                                         // both answers come now
    ASSERT_EQ(answers(), 1U);
    EXPECT_EQ(forces[0].back().seq, 1);
    EXPECT_EQ(counters().lost_answers, 1);
    EXPECT_EQ(counters().stale_answers, 1);
}

// A target that answers each state 1.5 ms late: every answer is of a state that it was asked for last, and is felt.
TEST_F(BridgeSessionTest, GivesForceOfASlowTargetFromTheNewestState) {
    publish_real(0);
    std::int64_t seq = 0, answered = 0;
    for (; seq < 30; ++answered) {
        publish_real(++seq);
        if (answered % 2 == 1) publish_real(++seq);  // three states in two answers' time
        const Bytes asked = pipes.take();
        EXPECT_LE(asked.size(), std::size_t{HAPTABLE_LINE_STATE_BYTES}) << "a backlog";
        pipes.put_to_target(asked);
        answer();
        ASSERT_EQ(answers(), std::size_t(answered) + 1);
        EXPECT_LE(seq - forces[0].back().seq, 3) << "not the newest";
    }
    EXPECT_EQ(counters().stale_answers + counters().lost_answers, 0);
    EXPECT_EQ(session->link_report().skipped_states, seq - answered);
    EXPECT_GT(forces[0].back().force_n[2], 0.0);
}

// One that takes longer than the bridge waits at first: it learns so, and then waits.
TEST_F(BridgeSessionTest, ASlowerTargetIsWaitedForOnceItIsKnown) {
    for (std::int64_t seq = 0; seq < 8; ++seq) {
        publish_real(seq);
        wait(milliseconds(5));
        if (seq % 2 == 1) answer();
    }
    EXPECT_GT(counters().stale_answers, 0);
    const std::size_t before = answers();
    for (std::int64_t seq = 8; seq < 12; ++seq) {
        publish_real(seq);
        if (seq % 2 == 1) answer();
    }
    EXPECT_GT(answers(), before);
}

const haptable_model& limited() {
    static const haptable_model model = [] {
        haptable_model limited = *soft_pair().scene_of_one().model;
        limited.limit = haptable_limit_force;
        limited.rate = haptable_limit_rate;
        limited.rate_n = 0.1F * limited.max_force_n;
        return limited;
    }();
    return model;
}

class LimitedBridgeTest : public BridgeSessionTest {
protected:
    LimitedBridgeTest() : BridgeSessionTest({&limited(), soft_pair().scene_of_one().node, "limited"}) {}
};

// A target that says 8.5 N at once: what the limit allows over its ticks is published, and no more.
TEST_F(LimitedBridgeTest, AForceRisesNoFasterThanTheLimit) {
    const auto forces_after = [&](std::int64_t seq, float force_n) {
        publish(seq);
        TargetAnswer answer;  // that touches the vertex 0
        answer.output[0].state = HAPTABLE_CONTACT;
        answer.output[0].alpha[0] = 1.0F;
        answer.output[0].force_n[2] = force_n;
        pipes.put(frame_of(target.hello, answer, std::uint32_t(seq) + 1));
        exchange();
        return answers();
    };
    EXPECT_EQ(forces_after(0, 1.5F * limited().rate_n), 0U);
    EXPECT_EQ(counters().rejected_forces, 1);
    EXPECT_EQ(forces_after(1, 1.5F * limited().rate_n), 1U);  // its second tick
    EXPECT_EQ(forces_after(2, -limited().rate_n), 2U);        // through nothing to the other side
    EXPECT_EQ(forces_after(3, 0.5F * limited().rate_n), 3U);
    EXPECT_EQ(forces_after(4, limited().max_force_n), 3U);
}

/// A bridge that begins behind a line whose target has said its hello to another.
struct Bridge {
    explicit Bridge(SerialTarget& line, const LineOptions& options = kImpatient) : stepper(line, options) {}
    /// A millisecond later it asks again.
    void ask_again(SimulatedTime& time) {
        time.leap(time.now() + milliseconds(1));
        session.watch(time.now());
    }
    void publish(const device_state& state) {
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    }

    Connection connection{"memq://"};
    LineStepper stepper;
    Session session{stepper, connection, nullptr};
};

// Its first hello was lost, and is asked for before any state is sent; a tick waits for it.
TEST_F(BridgeSessionTest, AsksATargetWhatItIs) {
    Bridge bridge(behind->line);
    bridge.publish(simulated_state(0, 0));
    EXPECT_EQ(pipes.take(), frame_of(target.hello)) << "no state";
    bridge.ask_again(*time);
    EXPECT_EQ(target.answer(), 0);
    bridge.session.take_answers();
    EXPECT_EQ(target.answer(), 1);
    bridge.session.take_answers();
    EXPECT_EQ(bridge.stepper.counters().ticks, 1);
    EXPECT_EQ(target.counters().ticks, 1U);
}

// What the line throws while liblcm calls us comes out where it can be caught.
TEST_F(BridgeSessionTest, ALineThatTakesNothingIsAnError) {
    const int full = open(pipes.to_target().c_str(), O_RDWR | O_NONBLOCK);
    while (write(full, "0123456789abcdef", 16) == 16) {
    }
    close(full);
    EXPECT_TRUE(fails_with([&] { publish(0); }, "takes no bytes for a second"));
}

TEST_F(BridgeSessionTest, GivesUpOnADeafTarget) {
    Bridge bridge(behind->line, {.retry = milliseconds(1), .patience_s = 0.05});
    bridge.publish(simulated_state(0, 0));
    target.answer();  // what it is, and nothing more
    bridge.session.take_answers();
    const auto ask_for = [&](int ms) {
        for (int i = 0; i < ms; ++i) {
            pipes.take();
            bridge.ask_again(*time);
        }
    };
    ask_for(40);
    EXPECT_THROW(ask_for(20), Error);
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
        if (got == 0) std::this_thread::sleep_for(milliseconds(1));
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
