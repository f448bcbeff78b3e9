// SPDX-License-Identifier: GPL-2.0-or-later
// Noise on the line to a microcontroller changes no force. tests/loop/test_target.py has the loop itself.
#include <gtest/gtest.h>

#include <random>

#include "codegen/loaded_scene.hpp"
#include "host/link/messages.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/session.hpp"
#include "host/target/image.hpp"
#include "host/target/strokes.hpp"
#include "tests/finger.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

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
    const LoadedScene cube(TablesFolder(build_folder() / "cube"));
    const ServoScene scene{&cube.model(), cube.node().data(), "cube"};
    const auto path_m = walked(stroke_path(cube.tables(), 100));
    const Pipes near, far;  // bridge to relay, relay to image
    const std::string elf = (build_folder() / "cube/firmware/cortex-m7/loop.elf").string();
    const Process image({"sh", "scripts/qemu.sh", "cortex-m7", elf, far.to_target(), far.from_target()});
    Connection connection("memq://");
    SerialTarget target(near.line(), scene);
    LineOptions options;
    options.retry = std::chrono::microseconds(3000);
    LineStepper stepper(target, options);
    Session session(stepper, connection, nullptr);
    std::vector<servo_force> forces;
    connection.subscribe<servo_force>(channel_of<servo_force>(),
                                      [&](const servo_force& force, std::int64_t) { forces.push_back(force); });
    SceneState host = state_of(scene);
    require_whole_tables(scene, host);
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
        haptable_input in{};
        haptable_output out{};
        in.is_there = 1;
        std::copy_n(path_m[tick].data(), 3, in.finger_m);
        host.step(&in, static_cast<std::uint32_t>(tick * 1000), &out);
        ASSERT_EQ(forces.size(), tick + 1) << "no answer to state " << tick;
        ASSERT_EQ(forces.back().seq, static_cast<std::int64_t>(tick));
        ASSERT_EQ(Eigen::Vector3d(forces.back().force_n), to_vector(out.force_n)) << "tick " << tick;
    }
    const LineCounters report = stepper.counters();
    EXPECT_GE(noise.garbage, 1'000'000U);
    EXPECT_GE(report.resent_frames, static_cast<std::int64_t>(noise.damaged / 2));
    EXPECT_EQ(report.rejected_forces, 0);
    EXPECT_EQ(report.foreign_frames, 0);
    EXPECT_GT(report.contact_ticks, static_cast<std::int64_t>(tick / 3));
}

}  // namespace
}  // namespace haptable::test
