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
#include <thread>

#include "host/base/error.hpp"
#include "host/session/session.hpp"
#include "tests/error_of.hpp"
#include "tests/host/session/bridge/fake_target.hpp"

namespace haptable::test {
namespace {

constexpr std::int64_t kSimulated = 0, kReal = 2'000'000'000'000;

class BridgeSessionTest : public testing::Test {
protected:
    explicit BridgeSessionTest(std::chrono::microseconds hold = LineOptions().hold) : options{impatient(hold)} {
        connection.subscribe<servo_force>(channel_of<servo_force>(),
                                          [this](const servo_force& force, std::int64_t) { forces.push_back(force); });
        connection.subscribe<contact>(channel_of<contact>(),
                                      [this](const contact& load, std::int64_t) { loads.push_back(load); });
        connection.subscribe<servo_status>(channel_of<servo_status>(),
                                           [this](const servo_status& status, std::int64_t) { last_status = status; });
        session.take_answers();  // its hello
    }
    static LineOptions impatient(std::chrono::microseconds hold = LineOptions().hold) {
        LineOptions options;
        options.hold = hold;
        options.retry = std::chrono::microseconds(1);
        options.patience_s = 0.05;
        return options;
    }

    /// Pressed deeper with every state; `seq` 0 is outside.
    void publish(std::int64_t seq, std::int64_t begin_us = kSimulated) {
        device_state state = simulated_state(seq, begin_us + seq * 1000);
        if (begin_us == kReal) state.mode = device_state::REAL_TIME;
        state.session = session_id;
        state.position_m[0] = 0.011;
        state.position_m[1] = 0.017;
        state.position_m[2] = 0.0301 - 1e-4 * static_cast<double>(seq);
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
    }
    void exchange() {
        target.answer();
        session.take_answers();
        handle_all(connection);
    }

    const LineOptions options;
    std::int64_t session_id = kSession;
    SoftBox box;
    Pipes pipes;
    Connection connection{"memq://"};
    SerialTarget line{pipes.line(), box.scene()};
    FakeTarget<Pipes> target{box.scene(), pipes};
    std::vector<std::string> told;  ///< events, a line each
    LineStepper stepper{line, options};
    Session session{stepper, connection, nullptr, [this](const std::string& text) { told.push_back(text); }};
    std::vector<servo_force> forces;
    std::vector<contact> loads;
    servo_status last_status{};
};

TEST_F(BridgeSessionTest, PublishesWhatTheTargetAnswers) {
    for (std::int64_t seq = 0; seq < 20; ++seq) {
        publish(seq);
        exchange();
        ASSERT_EQ(forces.size(), static_cast<std::size_t>(seq) + 1);
        EXPECT_EQ(forces.back().seq, seq);
        EXPECT_EQ(forces.back().utime, seq * 1000);
        for (int a = 0; a < 3; ++a) EXPECT_EQ(forces.back().force_n[a], double(target.output().force_n[a]));
        ASSERT_EQ(loads.size(), forces.size());
    }
    EXPECT_GT(forces.back().force_n[2], 0.0);
    ASSERT_EQ(loads.back().count, 3);
    for (int c = 0; c < 3; ++c) {
        // Mesh nodes, which are numbered otherwise than the target's vertices.
        EXPECT_EQ(loads.back().node[std::size_t(c)],
                  static_cast<std::int32_t>(box.scene().node[target.output().vertex[c]]));
        EXPECT_EQ(loads.back().force_n[std::size_t(c)][2], double(target.output().nodal_force_n[c][2]));
    }
    EXPECT_EQ(stepper.counters().contact_ticks, 18);
}

TEST_F(BridgeSessionTest, AsksAgainAndStepsOnce) {
    publish(0);
    pipes.take();  // lost on its way
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    session.watch(Clock::now());
    exchange();
    ASSERT_EQ(forces.size(), 1U);
    publish(1);
    target.answer();
    pipes.take_answers();  // the answer was lost
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    session.watch(Clock::now());
    exchange();
    ASSERT_EQ(forces.size(), 2U);
    EXPECT_EQ(target.counters().ticks, 2U);
    EXPECT_EQ(stepper.counters().resent_frames, 2);
    publish(1);  // the device did not get it
    EXPECT_EQ(forces.size(), 3U);
    EXPECT_EQ(target.answer(), 0);
    EXPECT_EQ(session.link_report().repeated_states, 1);
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
    PatientBridgeSession() : BridgeSessionTest(std::chrono::hours(1)) {}
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
        ASSERT_EQ(forces.size(), static_cast<std::size_t>(answered) + 1);
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
    haptable_model limited = *box.scene().model;
    limited.limit = haptable_limit_force;
    limited.rate = haptable_limit_rate;
    limited.rate_n = 0.1F * limited.max_force_n;
    ServoScene scene = box.scene();
    scene.model = &limited;
    Pipes own_pipes;
    Connection own("memq://");
    SerialTarget own_line(own_pipes.line(), scene);
    FakeTarget<Pipes> there(box.scene(), own_pipes);
    LineStepper own_stepper(own_line, impatient());
    Session bridge(own_stepper, own, nullptr);
    bridge.take_answers();
    std::vector<double> felt_n;
    own.subscribe<servo_force>(channel_of<servo_force>(),
                               [&](const servo_force& force, std::int64_t) { felt_n.push_back(force.force_n[2]); });
    const auto say = [&](std::int64_t seq, float force_n) {
        own.publish(channel_of<device_state>(), simulated_state(seq, seq * 1000));
        handle_all(own);
        haptable_line_answer answer{};
        answer.out[0].state = HAPTABLE_CONTACT;
        answer.out[0].alpha[0] = 1.0F;
        for (int c = 0; c < 3; ++c) answer.out[0].vertex[c] = static_cast<std::uint16_t>(c);
        answer.out[0].force_n[2] = force_n;
        Bytes bytes(HAPTABLE_LINE_ANSWER_BYTES);
        const auto number = static_cast<std::uint32_t>(seq) + 1;
        bytes.resize(haptable_line_write_answer(number, &there.hello, &answer, bytes.data()));
        own_pipes.put(bytes);
        bridge.take_answers();
        handle_all(own);
    };
    say(0, 1.5F * limited.rate_n);
    EXPECT_TRUE(felt_n.empty());
    EXPECT_EQ(own_stepper.counters().rejected_forces, 1);
    say(1, 1.5F * limited.rate_n);  // its second tick
    ASSERT_EQ(felt_n.size(), 1U);
    say(2, -limited.rate_n);  // through nothing to the other side, by no more than the limit
    ASSERT_EQ(felt_n.size(), 2U);
    say(3, 0.5F * limited.rate_n);
    ASSERT_EQ(felt_n.size(), 3U);
    say(4, limited.max_force_n);
    EXPECT_EQ(felt_n.size(), 3U);
}

// Before any state and after some: a board may be flashed while the bridge runs.
TEST_F(BridgeSessionTest, RefusesATargetOfAnotherSceneOrVersion) {
    const auto refused = [this](const std::function<void(haptable_line_hello&)>& change) {
        haptable_line_hello other = target.hello;
        change(other);
        Bytes bytes(HAPTABLE_LINE_HELLO_BYTES);
        bytes.resize(haptable_line_write_hello(0, other, bytes.data()));
        pipes.put(bytes);
        return error_of([&] { session.take_answers(); });
    };
    for (int seq = 0; seq < 2; ++seq) {
        EXPECT_NE(refused([](auto& hello) {
                      hello.hash = 77;
                  }).find("the tables 000000000000004d, the folder's are 0000000000000001: build and flash it again"),
                  std::string::npos);
        EXPECT_NE(refused([](auto& hello) { hello.version = 9; }).find("version 9 of the line, this program version 3"),
                  std::string::npos);
        EXPECT_NE(refused([](auto& hello) { hello.fingers = 2; }).find("the target knows 2 fingers"),
                  std::string::npos);
        EXPECT_NE(refused([](auto& hello) { hello.modes = 3; }).find("with 3 modes"), std::string::npos);
        EXPECT_NE(refused([](auto& hello) { hello.flags |= HAPTABLE_LINE_FREE; }).find("that nothing holds"),
                  std::string::npos);
        EXPECT_EQ(refused([](auto&) {}), "no error");
        publish(seq);
        exchange();
        EXPECT_EQ(forces.size(), std::size_t(seq) + 1);
    }
}

// Its first hello was lost, and is asked for before any state is sent; a tick waits for it.
TEST_F(BridgeSessionTest, AsksATargetWhatItIs) {
    Connection own("memq://");
    LineStepper own_stepper(line, impatient());
    Session bridge(own_stepper, own, nullptr);
    int answers = 0;
    own.subscribe<servo_force>(channel_of<servo_force>(), [&](const servo_force&, std::int64_t) { ++answers; });
    own.publish(channel_of<device_state>(), simulated_state(0, 0));
    handle_all(own);
    const Bytes asked = pipes.take();
    Bytes want(HAPTABLE_LINE_HELLO_BYTES);
    want.resize(haptable_line_write_hello(0, target.hello, want.data()));
    EXPECT_EQ(asked, want) << "no state";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    bridge.watch(Clock::now());
    EXPECT_EQ(target.answer(), 0);
    bridge.take_answers();
    EXPECT_EQ(target.answer(), 1);
    bridge.take_answers();
    handle_all(own);
    EXPECT_EQ(answers, 1);
    EXPECT_EQ(target.counters().ticks, 1U);
}

// What no servo of these tables says does not reach the device, whatever its CRC says.
TEST_F(BridgeSessionTest, GatesForces) {
    publish(0);
    const auto says = [this](const haptable_output& output) {
        haptable_line_answer answer{};
        answer.out[0] = output;
        Bytes bytes(HAPTABLE_LINE_ANSWER_BYTES);
        bytes.resize(haptable_line_write_answer(1, &target.hello, &answer, bytes.data()));
        pipes.put(bytes);
    };
    haptable_output touch{};
    touch.state = HAPTABLE_CONTACT;
    for (int c = 0; c < 3; ++c) touch.vertex[c] = static_cast<std::uint16_t>(c);
    touch.alpha[0] = 1.0F;
    std::vector<std::function<void(haptable_output&)>> faults;
    for (const float force_n : {2.0F * box.scene().model->max_force_n, std::nanf(""), -INFINITY})
        faults.emplace_back([force_n](haptable_output& o) { o.force_n[1] = force_n; });
    faults.emplace_back([](haptable_output& o) { o.vertex[2] = 60000; });
    faults.emplace_back([](haptable_output& o) { o.nodal_force_n[2][1] = std::nanf(""); });
    faults.emplace_back([](haptable_output& o) { o.god_object_m[0] = INFINITY; });
    faults.emplace_back([](haptable_output& o) { o.alpha[1] = 0.5F; });
    faults.emplace_back([](haptable_output& o) { o.alpha[1] = std::nanf(""); });
    faults.emplace_back([](haptable_output& o) { o.state = 200; });
    faults.emplace_back([](haptable_output& o) {  // a dent that no body has
        o.state = HAPTABLE_FREE;
        o.vertex[1] = 60000;
    });
    for (const std::uint8_t state : {HAPTABLE_SILENT, HAPTABLE_FREE, HAPTABLE_REJECTED, HAPTABLE_FAULTED})
        faults.emplace_back([state](haptable_output& o) {
            o.state = state;
            o.force_n[2] = 0.1F;
        });
    for (const auto& fault : faults) {
        haptable_output wild = touch;
        fault(wild);
        says(wild);
    }
    session.take_answers();
    handle_all(connection);
    EXPECT_TRUE(forces.empty());
    EXPECT_EQ(stepper.counters().rejected_forces, static_cast<std::int64_t>(faults.size()));
    says(touch);
    session.take_answers();
    handle_all(connection);
    EXPECT_EQ(forces.size(), 1U);
}

// What the line throws while liblcm calls us comes out where it can be caught.
TEST_F(BridgeSessionTest, ASecondDeviceIsToldAndNotAsked) {
    publish(0);
    exchange();
    session_id = 5;
    publish(1);
    EXPECT_EQ(target.answer(), 0);
    ASSERT_EQ(forces.size(), 2U);
    EXPECT_EQ(forces.back().session, 5);
    EXPECT_EQ(forces.back().owner, kSession);
    EXPECT_EQ(session.link_report().other_device_states, 1);
}

TEST_F(BridgeSessionTest, ALineThatTakesNothingIsAnError) {
    Pipes stuck;
    const int full = open(stuck.to_target().c_str(), O_RDWR | O_NONBLOCK);
    while (write(full, "0123456789abcdef", 16) == 16) {
    }
    close(full);
    SerialTarget deaf(stuck.line(), box.scene());
    Connection own("memq://");
    LineStepper own_stepper(deaf, impatient());
    Session bridge(own_stepper, own, nullptr);
    own.publish(channel_of<device_state>(), simulated_state(0, 0));
    const std::string said = error_of([&] { handle_all(own); });
    EXPECT_NE(said.find("takes no bytes for a second"), std::string::npos) << said;
}

// The target keeps its contact as long as its time runs on: for another device it must not.
TEST_F(BridgeSessionTest, AnotherSessionBeginsWithoutContact) {
    for (std::int64_t seq = 0; seq < 9; ++seq) {
        publish(seq, kReal);
        exchange();
    }
    ASSERT_EQ(int{forces.back().servo_state}, HAPTABLE_CONTACT);
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
    for (std::int64_t seq = 0; seq < 9; ++seq) {
        publish(seq, kReal);
        exchange();
    }
    ASSERT_NE(forces.back().force_n[2], 0.0);
    const std::size_t before = forces.size();
    for (int i = 0; i < 3; ++i) {
        session.watch(Clock::now() + std::chrono::milliseconds(21));
        handle_all(connection);
    }
    ASSERT_EQ(forces.size(), before + 1);
    EXPECT_EQ(forces.back().force_n[2], 0.0);
    EXPECT_EQ(int{forces.back().servo_state}, HAPTABLE_SILENT);
    EXPECT_EQ(loads.back().count, 0);
    ASSERT_EQ(told.size(), 1U);
    EXPECT_NE(told[0].find("contact dropped after a silence of"), std::string::npos) << told[0];
}

TEST_F(BridgeSessionTest, GivesUpOnADeafTarget) {
    publish(0);
    EXPECT_THROW(
        {
            for (int i = 0; i < 200; ++i) {
                pipes.take();
                session.watch(Clock::now());
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        },
        Error);
}

TEST_F(BridgeSessionTest, StatusCounts) {
    publish(0);
    exchange();
    pipes.put({1, 2, 3});
    session.take_answers();
    session.publish_status();
    handle_all(connection);
    const auto value = [this](const std::string& name) {
        for (std::size_t i = 0; i < last_status.name.size(); ++i)
            if (last_status.name[i] == name) return last_status.value[i];
        return std::int64_t{-1};
    };
    EXPECT_EQ(value("ticks"), 1);
    EXPECT_EQ(value("skipped_bytes"), 3);
    EXPECT_EQ(value("resent_frames"), 0);
}

// ---- lines ---------------------------------------------------------------------------------------------------------

TEST(Line, ErrorsNameThePath) {
    WorkFolder folder;
    EXPECT_NE(error_of([] { Line::open("/dev/ttyNONE", 115200); }).find("/dev/ttyNONE"), std::string::npos);
    write_file(folder / "file", "x");
    EXPECT_NE(error_of([&] { Line::open(folder / "file", 115200); }).find("serial port"), std::string::npos);
    EXPECT_NE(error_of([&] { Line::pipes(folder / "a", folder / "b"); }).find("mkfifo"), std::string::npos);
    EXPECT_NE(error_of([] { Line::open("/dev/ptmx", 12345); }).find("--baud 12345"), std::string::npos);
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
    Bytes bytes;
    for (int b = 0; b < 256; ++b) bytes.push_back(static_cast<std::uint8_t>(b));
    return bytes;
}

TEST(Line, ATtyIsRaw) {
    const Pty port;
    Line line = Line::open(port.name(), 115200);
    const Bytes bytes = every_byte();
    ASSERT_EQ(write(port.target(), bytes.data(), bytes.size()), 256);
    EXPECT_EQ(read_from(line, 256), bytes);
    line.write(bytes);
    Bytes back(256);
    std::size_t got = 0;
    while (got < 256) got += static_cast<std::size_t>(read(port.target(), back.data() + got, 256 - got));
    EXPECT_EQ(back, bytes);
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
    EXPECT_NE(error_of([&] { Line::open(port.name(), 115200); }).find("another program has it"), std::string::npos);
}

// The cable is pulled out: reading and writing both say so, and what to do.
TEST(Line, ATtyThatVanishesIsAnErrorThatSaysWhatToDo) {
    Pty port;
    Line line = Line::open(port.name(), 115200);
    EXPECT_TRUE(read_from(line, 0).empty());  // idle is no error
    std::array<std::uint8_t, 8> some{};
    EXPECT_EQ(line.read(some), 0U);
    const std::string name = port.name();
    port.vanish();
    EXPECT_NE(error_of([&] { read_from(line, 1); }).find(name + ": the port has gone: plug"), std::string::npos);
    EXPECT_NE(error_of([&] { line.write(every_byte()); }).find(name + ": the port has gone: plug"), std::string::npos);
    EXPECT_NE(error_of([&] { Line::open(name, 115200); }).find("plugged in"), std::string::npos);
}

TEST(Line, AUnixSocketIsALine) {
    WorkFolder folder;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (folder / "uart").string();
    path.copy(address.sun_path, path.size());
    const int listening = socket(AF_UNIX, SOCK_STREAM, 0);
    ASSERT_EQ(bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_NE(error_of([&] { Line::open(path, 115200); }).find("does its other end listen"), std::string::npos);
    ASSERT_EQ(listen(listening, 1), 0);
    Line line = Line::open(path, 115200);
    const int target = accept(listening, nullptr, nullptr);
    const Bytes bytes = every_byte();
    ASSERT_EQ(write(target, bytes.data(), bytes.size()), 256);
    EXPECT_EQ(read_from(line, 256), bytes);
    close(target);
    EXPECT_NE(error_of([&] { read_from(line, 1); }).find("has closed the line"), std::string::npos);
    close(listening);
}

TEST(Line, AProgramIsALineAndItsEndIsAnError) {
    Line cat = Line::program("cat");
    cat.write(every_byte());
    EXPECT_EQ(read_from(cat, 256), every_byte());
    Line ended = Line::program("true");
    EXPECT_NE(error_of([&] { read_from(ended, 1); }).find("closed"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
