// SPDX-License-Identifier: GPL-2.0-or-later
// The microcontroller in the loop: the loop image under QEMU, the bridge, the simulated device. The forces are those of
// the host's servo, bit for bit, and noise on the line changes none.
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstring>
#include <random>
#include <thread>

#include "codegen/in_memory.hpp"
#include "host/base/error.hpp"
#include "host/bridge/line_stepper.hpp"
#include "host/link/messages.hpp"
#include "host/session/session.hpp"
#include "host/target/image.hpp"
#include "host/target/strokes.hpp"
#include "tests/finger.hpp"
#include "tests/host/bridge/fake_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

std::string elf(const std::string& target, const std::string& image, const std::string& scene = "cube") {
    return (build_folder() / scene / "firmware" / target / (image + ".elf")).string();
}

class TargetLoop : public testing::Test {
protected:
    void SetUp() override {
        url = own_url();
        setenv("LCM_DEFAULT_URL", url.c_str(), 1);
        for (const std::string& needed : {servo, device, bridge})
            if (!std::filesystem::exists(needed)) GTEST_SKIP() << needed << " is not built: make scene";
        const std::string missing = TargetImage(build_folder(), "cube", "cortex-m7").missing();
        if (!missing.empty()) GTEST_SKIP() << missing;
        if (const std::string why = why_no_lcm(url); !why.empty()) GTEST_SKIP() << why;
    }
    void TearDown() override { unsetenv("LCM_DEFAULT_URL"); }

    /// A session in lockstep of `seconds` with the target behind `line`; then the same path through the host's servo.
    void expect_forces_of_the_host(const std::vector<std::string>& line, const std::string& seconds) {
        std::vector<std::string> command{bridge,  (build_folder() / "cube").string(), "--quiet", "--no-realtime",
                                         "--csv", (folder / "bridge.csv").string()};
        command.insert(command.end(), line.begin(), line.end());
        Process bridge_process(command);
        Process device_process({device, "meshes/cube.toml", "--quiet", "--lockstep", "--path", "drag,poke", "--seconds",
                                seconds, "--csv", (folder / "device.csv").string()});
        ASSERT_EQ(device_process.wait_for_exit(), 0);
        bridge_process.kill(SIGTERM);
        ASSERT_EQ(bridge_process.wait_for_exit(), 0);
        write_file(folder / "path.csv", finger_path_of(folder / "bridge.csv"));
        Process replay(
            {servo, "--quiet", "--replay", (folder / "path.csv").string(), "--out", (folder / "host.csv").string()});
        ASSERT_EQ(replay.wait_for_exit(), 0);
        EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
        const auto rows = read_rows(folder / "bridge.csv"), felt = read_rows(folder / "device.csv");
        ASSERT_EQ(rows.size(), static_cast<std::size_t>(std::stod(seconds) * 1000.0));
        ASSERT_EQ(felt.size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i) {
            ASSERT_EQ(felt[i][13], static_cast<double>(i));
            for (std::size_t a = 0; a < 3; ++a)
                ASSERT_EQ(static_cast<float>(rows[i][14 + a]), static_cast<float>(felt[i][10 + a])) << i;
        }
        EXPECT_GT(std::count_if(rows.begin(), rows.end(), [](const auto& row) { return row[4] > 0.0; }), 50);
    }

    /// The same of two hands.
    void expect_forces_of_both(const std::vector<std::string>& line, const std::string& name = "cube-two",
                               const std::string& file = "meshes/cube-two.toml",
                               const std::vector<std::string>& path = {"--path", "drag,poke", "--seconds", "0.5"}) {
        const std::filesystem::path scene = build_folder() / name;
        std::vector<std::string> command{bridge,          scene.string(), "--quiet",
                                         "--no-realtime", "--csv",        (folder / "bridge.csv").string()};
        command.insert(command.end(), line.begin(), line.end());
        Process bridge_process(command);
        std::vector<std::string> hands{device, file, "--quiet", "--lockstep", "--fingers", "2"};
        hands.insert(hands.end(), path.begin(), path.end());
        Process device_process(hands);
        ASSERT_EQ(device_process.wait_for_exit(), 0);
        bridge_process.kill(SIGTERM);
        ASSERT_EQ(bridge_process.wait_for_exit(), 0);
        Process replay({scene / "servo", "--quiet", "--replay", folder / "bridge.csv", "--out", folder / "host.csv"});
        ASSERT_EQ(replay.wait_for_exit(), 0);
        EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
        const auto rows = read_rows(folder / "bridge.csv");
        EXPECT_GE(rows.size(), 500U);
        if (path[1] == "lift") {
            const std::size_t height = rows[0].size() - 5;  // before it x and y, behind it the turn
            double most_m = 0.0;
            for (const auto& row : rows) most_m = std::max(most_m, row[height]);
            EXPECT_GT(most_m, rows[0][height] + 0.01) << "it is lifted";
        }
        const auto both_touch = [](const auto& row) { return row[4] > 0.0 && row[22] > 0.0; };
        EXPECT_GT(std::count_if(rows.begin(), rows.end(), both_touch), 50);
    }

    /// The same of how the body moves, in the bridge's record and over LCM: three numbers of each message, `of`, are
    /// those from column 20 on.
    template <typename Message, typename Of>
    void expect_motion_of_the_host(const std::vector<std::string>& line, const std::string& name,
                                   const std::string& file, const char* channel, Of of) {
        const std::filesystem::path scene = build_folder() / name;
        Connection connection;
        std::vector<Message> motion;
        connection.subscribe<Message>(channel, [&](const Message& m, std::int64_t) { motion.push_back(m); });
        std::vector<std::string> command{bridge,          scene.string(), "--quiet",
                                         "--no-realtime", "--csv",        (folder / "bridge.csv").string()};
        command.insert(command.end(), line.begin(), line.end());
        Process bridge_process(command);
        Process device_process({device, file, "--quiet", "--lockstep", "--path", "drag", "--seconds", "0.5"});
        for (Clock::time_point begun = Clock::now();
             motion.size() < 500 && Clock::now() - begun < std::chrono::seconds(60);)
            connection.handle_until(Clock::now() + std::chrono::milliseconds(20));
        ASSERT_EQ(device_process.wait_for_exit(), 0);
        bridge_process.kill(SIGTERM);
        ASSERT_EQ(bridge_process.wait_for_exit(), 0);
        Process replay({scene / "servo", "--quiet", "--replay", folder / "bridge.csv", "--out", folder / "host.csv"});
        ASSERT_EQ(replay.wait_for_exit(), 0);
        EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "bridge.csv"));
        const auto rows = read_rows(folder / "bridge.csv");
        ASSERT_EQ(rows.size(), 500U);
        ASSERT_EQ(motion.size(), rows.size());
        for (std::size_t i = 0; i < rows.size(); ++i)
            for (std::size_t a = 0; a < 3; ++a)
                ASSERT_EQ(static_cast<float>(of(motion[i])[a]), static_cast<float>(rows[i][20 + a])) << i;
        EXPECT_NE(rows.back()[20], rows[0][20]) << "it is pushed";
    }

    std::string servo = build_folder() / "cube/servo";
    std::string device = program("haptable-device");
    std::string bridge = program("haptable-bridge");
    std::string url;
    WorkFolder folder;
};

TEST_F(TargetLoop, OverPipesGivesTheForcesOfTheHost) {
    for (const char* target : kTargets) {
        SCOPED_TRACE(target);
        const Pipes pipes;
        const Process image(
            {"sh", "scripts/qemu.sh", target, elf(target, "loop"), pipes.to_target(), pipes.from_target()});
        expect_forces_of_the_host({"--pipes", pipes.to_target(), pipes.from_target()}, "1");
    }
}

// Two hands of one device, the image of two fingers: what the target felt, through the host's servo again.
TEST_F(TargetLoop, TwoFingersHaveTheForcesOfTheHost) {
    for (const char* target : kTargets) {
        SCOPED_TRACE(target);
        const Pipes pipes;
        const Process image(
            {"sh", "scripts/qemu.sh", target, elf(target, "loop", "cube-two"), pipes.to_target(), pipes.from_target()});
        expect_forces_of_both({"--pipes", pipes.to_target(), pipes.from_target()});
    }
}

TEST_F(TargetLoop, TwoFingersOverTheUartHaveTheForcesOfTheHost) {
    for (const char* target : {"cortex-m7", "rv32"}) {
        SCOPED_TRACE(target);
        expect_forces_of_both({"--run", "env QEMU_SERIAL=stdio sh scripts/qemu.sh " + std::string(target) + " " +
                                            elf(target, "uart", "cube-two")});
    }
}

// A body that nothing holds, pushed by one hand or lifted by two, or that rings is where the host's servo has it; over
// LCM too.
TEST_F(TargetLoop, ABodyThatMovesIsWhereTheHostHasIt) {
    for (const char* target : {"cortex-m4", "rv32"}) {
        SCOPED_TRACE(target);
        const Pipes pipes;
        const Process image({"sh", "scripts/qemu.sh", target, elf(target, "loop", "free-cube"), pipes.to_target(),
                             pipes.from_target()});
        expect_motion_of_the_host<body_pose>({"--pipes", pipes.to_target(), pipes.from_target()}, "free-cube",
                                             "meshes/free-cube.toml", channel_of<body_pose>(),
                                             [](const body_pose& m) { return m.centre_m; });
    }
    for (const char* target : {"cortex-m7", "rv32"}) {  // one that rings
        SCOPED_TRACE(target);
        const Pipes pipes;
        const Process image(
            {"sh", "scripts/qemu.sh", target, elf(target, "loop", "ringing"), pipes.to_target(), pipes.from_target()});
        expect_motion_of_the_host<body_modes>({"--pipes", pipes.to_target(), pipes.from_target()}, "ringing",
                                              "tests/firmware/modes.toml", channel_of<body_modes>(),
                                              [](const body_modes& m) { return m.swung; });
    }
    for (const auto& [target, scene, file] :
         {std::tuple{"cortex-m7", "grasped", "tests/firmware/grasp.toml"},
          {"cortex-m33", "wobbling", "tests/firmware/wobble.toml"}}) {  // with modes besides
        SCOPED_TRACE(scene);
        const Pipes pipes;
        const Process image(
            {"sh", "scripts/qemu.sh", target, elf(target, "loop", scene), pipes.to_target(), pipes.from_target()});
        expect_forces_of_both({"--pipes", pipes.to_target(), pipes.from_target()}, scene, file,
                              {"--path", "lift", "--hold", "0.1"});
    }
    const Pipes pipes;  // two fingers on one that is held and rings
    const Process image({"sh", "scripts/qemu.sh", "cortex-m4", elf("cortex-m4", "loop", "squeezed"), pipes.to_target(),
                         pipes.from_target()});
    expect_forces_of_both({"--pipes", pipes.to_target(), pipes.from_target()}, "squeezed",
                          "tests/firmware/squeeze.toml");
}

TEST_F(TargetLoop, OverTheUartGivesTheForcesOfTheHost) {
    for (const char* target : {"cortex-m7", "rv32"}) {
        SCOPED_TRACE(target);
        expect_forces_of_the_host(
            {"--run", "env QEMU_SERIAL=stdio sh scripts/qemu.sh " + std::string(target) + " " + elf(target, "uart")},
            "0.3");
    }
}

/// A target at the other end of a serial port, until the port is pulled out or this object ends.
class PortTarget {
public:
    explicit PortTarget(int states = 1'000'000) : left_(states), thread_([this] { answer(); }) {}
    ~PortTarget() {
        ended_ = true;
        thread_.join();
    }
    PortTarget(const PortTarget&) = delete;
    PortTarget& operator=(const PortTarget&) = delete;
    const std::string& name() const { return port_.name(); }

private:
    void answer() {
        FakeTarget target({&model_, nullptr, "cube"}, port_);
        while (!ended_ && left_ > 0) {
            const int states = target.answer();
            left_ -= states;
            if (states == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        if (left_ <= 0) port_.vanish();
    }

    const Tables tables_ = read_tables(build_folder() / "cube");
    const ServoModel built_ = build_model(tables_);
    const haptable_model model_ = model_in_memory(tables_, built_);
    Pty port_;
    int left_;
    std::atomic<bool> ended_ = false;
    std::thread thread_;
};

TEST_F(TargetLoop, OverASerialPortGivesTheForcesOfTheHost) {
    const PortTarget target;
    expect_forces_of_the_host({"--port", target.name(), "--baud", "2000000"}, "0.3");
}

// The cable is pulled out in the middle of a session: one line that says so, and a record up to there; plugged in
// again, under whatever name, a new bridge goes on with the same device.
TEST_F(TargetLoop, APortThatVanishesEndsTheBridgeAndAnotherGoesOn) {
    const std::string tables = build_folder() / "cube";
    const auto bridge_on = [&](const std::string& port, const std::string& record) {
        return std::vector<std::string>{bridge, tables, "--port", port, "--quiet", "--no-realtime", "--csv", record};
    };
    const PortTarget pulled(100);
    Process first(bridge_on(pulled.name(), folder / "first.csv"), {{}, "/dev/null", folder / "first.txt"});
    Process device_process({device, "meshes/cube.toml", "--quiet", "--lockstep", "--path", "poke", "--seconds", "0.3"});
    EXPECT_EQ(first.wait_for_exit(), 1);
    const std::string said = read_file(folder / "first.txt");
    EXPECT_NE(said.find(pulled.name() + ": the port has gone: plug"), std::string::npos) << said;
    EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
    EXPECT_GT(read_rows(folder / "first.csv").size(), 50U) << "its record is there, up to the end";
    const PortTarget plugged;
    Process second(bridge_on(plugged.name(), folder / "second.csv"));
    EXPECT_EQ(device_process.wait_for_exit(), 0);
    second.kill(SIGTERM);
    EXPECT_EQ(second.wait_for_exit(), 0);
    EXPECT_GT(read_rows(folder / "second.csv").size(), 190U);
}

// ---- noise -------------------------------------------------------------------------------------------------------

/// Puts garbage, rich in false begins, before what passes, and damages a byte of it now and then.
class Noise {
public:
    Bytes on(Bytes bytes) {
        if (bytes.empty()) return bytes;
        if (random_() % 16 == 0) {
            bytes[random_() % bytes.size()] ^= static_cast<std::uint8_t>(1U << (random_() % 8));
            ++damaged;
        }
        Bytes all(random_() % 700);
        for (std::uint8_t& byte : all)
            byte = static_cast<std::uint8_t>(random_() % 4 == 0 ? (random_() % 2 != 0 ? 0xA5 : 0x5A) : random_());
        garbage += all.size();
        all.insert(all.end(), bytes.begin(), bytes.end());
        return all;
    }

    std::size_t garbage = 0, damaged = 0;

private:
    std::mt19937 random_{1};
};

// 10^6 bytes of garbage on the line, both ways, and every sixteenth burst damaged: every state is answered, with the
// force of the host's servo, and nothing else is published. The image, the bridge's session, LCM within this process.
TEST(TargetNoise, AMillionBytesOfGarbageChangeNoForce) {
    const TargetImage missing(build_folder(), "cube", "cortex-m7");
    if (!missing.missing().empty()) GTEST_SKIP() << missing.missing();
    const Tables tables = read_tables(build_folder() / "cube");
    const ServoModel built = build_model(tables);
    const haptable_model model = model_in_memory(tables, built);
    const std::vector<std::uint32_t> node(built.node.begin(), built.node.end());
    const auto path_m = walked(stroke_path(tables, 100));
    const Pipes near, far;  // bridge to relay, relay to image
    const Process image(
        {"sh", "scripts/qemu.sh", "cortex-m7", elf("cortex-m7", "loop"), far.to_target(), far.from_target()});
    Connection connection("memq://");
    const ServoScene scene{&model, node.data(), "cube"};
    SerialTarget target(near.line(), scene);
    LineOptions options;
    options.retry = std::chrono::microseconds(3000);
    LineStepper stepper(target, options);
    Session session(stepper, connection, nullptr);
    std::vector<servo_force> forces;
    connection.subscribe<servo_force>(channel_of<servo_force>(),
                                      [&](const servo_force& force, std::int64_t) { forces.push_back(force); });
    haptable_servo servo;
    haptable_servo_init(&servo);
    check_tables(model, servo);
    Noise noise;
    const Clock::time_point give_up = Clock::now() + std::chrono::seconds(50);
    std::size_t tick = 0;
    for (; noise.garbage < 1'000'000 && tick < path_m.size(); ++tick) {
        device_state state = simulated_state(static_cast<std::int64_t>(tick), static_cast<std::int64_t>(tick) * 1000);
        for (std::size_t a = 0; a < 3; ++a) state.position_m[a] = double(path_m[tick][a]);
        connection.publish(channel_of<device_state>(), state);
        while (forces.size() <= tick && Clock::now() < give_up) {
            handle_all(connection);
            far.put_to_target(noise.on(near.take()));
            near.put(noise.on(far.take_answers()));
            session.take_answers();
            session.watch(Clock::now());
        }
        haptable_output out;
        haptable_servo_step(&model, &servo, path_m[tick].data(), static_cast<std::uint32_t>(tick * 1000), &out);
        ASSERT_EQ(forces.size(), tick + 1) << "no answer to state " << tick;
        ASSERT_EQ(forces.back().seq, static_cast<std::int64_t>(tick));
        for (int a = 0; a < 3; ++a) ASSERT_EQ(forces.back().force_n[a], double(out.force_n[a])) << "tick " << tick;
    }
    const LineCounters report = stepper.counters();
    RecordProperty("garbage_bytes", std::to_string(noise.garbage));
    RecordProperty("ticks", std::to_string(tick));
    RecordProperty("damaged", std::to_string(noise.damaged));
    RecordProperty("resent_frames", std::to_string(report.resent_frames));
    EXPECT_GE(noise.garbage, 1'000'000U);
    EXPECT_GE(report.resent_frames, static_cast<std::int64_t>(noise.damaged / 2));
    EXPECT_EQ(report.rejected_forces, 0);
    EXPECT_EQ(report.foreign_frames, 0);
    EXPECT_GT(report.contact_ticks, static_cast<std::int64_t>(tick / 3));
}

}  // namespace
}  // namespace haptable::test
