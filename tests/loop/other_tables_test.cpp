// SPDX-License-Identifier: GPL-2.0-or-later
// Two tables of the same inputs that differ in one bit, as two machines may make them: no part takes one for the other.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>

#include "codegen/codegen.hpp"
#include "codegen/in_memory.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/servo.hpp"
#include "host/session/session.hpp"
#include "host/view/contact_messages.hpp"
#include "tests/error_of.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/host/view/cube_tables.hpp"

namespace haptable::test {
namespace {

/// Tables as the servo, the bridge and the viewer have them.
struct Built {
    explicit Built(const Tables& from) : tables(from), node(servo.node.begin(), servo.node.end()) {}
    Built(const Built&) = delete;
    Built& operator=(const Built&) = delete;
    ServoScene scene() const { return {&model, node.data(), "cube"}; }
    std::string hash() const { return fmt::format("{:016x}", model.hash); }

    Tables tables;
    ServoModel servo = build_model(tables);
    haptable_model model = model_in_memory(tables, servo);
    std::vector<std::uint32_t> node;
};

Tables cube_tables() {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    return read_tables(folder.path());
}

/// A bit of the mantissa of one number of S. A float's last is a double's 30th.
Tables with_flipped_bit(Tables tables, int bit) {
    double& s = tables.stiffness[5][0];
    s = std::bit_cast<double>(std::bit_cast<std::uint64_t>(s) ^ (std::uint64_t{1} << bit));
    return tables;
}

class OtherTables : public testing::Test {
protected:
    template <typename Meet>
    void expect_both_named(const Meet& meet) const {
        const std::string said = error_of([&] { meet(); });
        EXPECT_NE(said.find(ours.hash()), std::string::npos) << said;
        EXPECT_NE(said.find(theirs.hash()), std::string::npos) << said;
    }
    int replay(const Built& servo, const std::string& tables) const {
        const std::string in = folder / "path.csv", out = folder / "out.csv";
        write_file(in, "x,y,z\n0.01,0.01,0.031\n0.01,0.01,0.029\n");
        const char* argv[] = {"servo",     "--replay", in.c_str(),     "--out",
                              out.c_str(), "--tables", tables.c_str(), "--quiet"};
        return servo_main(std::size(argv), const_cast<char**>(argv), servo.scene());
    }

    const Tables made = cube_tables();
    const Built ours{made}, theirs{with_flipped_bit(made, 29)};
    const WorkFolder folder;
};

TEST_F(OtherTables, AreOfTheSameInputsAndHaveAnotherHash) {
    EXPECT_EQ(ours.tables.model_hash, theirs.tables.model_hash);
    EXPECT_NE(ours.hash(), theirs.hash());
    EXPECT_EQ(ours.hash(), Built(made).hash());
    // Below a float's last bit: the servo's tables are the same.
    EXPECT_EQ(ours.hash(), Built(with_flipped_bit(made, 0)).hash());
    EXPECT_NE(model_text(theirs.tables, theirs.servo).header.find("_HASH 0x" + theirs.hash()), std::string::npos);
}

TEST_F(OtherTables, AServoDoesNotAnswerADeviceThatWantsTheOther) {
    Connection connection("memq://");
    int forces = 0;
    connection.subscribe<servo_force>(channel_of<servo_force>(), [&](const servo_force&, std::int64_t) { ++forces; });
    LocalStepper stepper(ours.scene());
    Session session(stepper, connection, nullptr);
    device_state state = simulated_state(0, 0);
    for (const Built* wanted : {&theirs, &ours}) {
        state.model_hash = static_cast<std::int64_t>(wanted->model.hash);
        connection.publish(channel_of<device_state>(), state);
        handle_all(connection);
        EXPECT_EQ(forces, wanted == &ours ? 1 : 0);
    }
    EXPECT_EQ(session.link_report().foreign_states, 1);
}

TEST_F(OtherTables, ABridgeRefusesATargetOfTheOther) {
    Connection connection("memq://");
    Pipes pipes;
    SerialTarget line(pipes.line(), ours.scene());
    FakeTarget<Pipes> target(theirs.scene(), pipes);
    LineStepper stepper(line, {});
    Session session(stepper, connection, nullptr);
    connection.publish(channel_of<device_state>(), simulated_state(0, 0));
    handle_all(connection);
    target.answer();
    expect_both_named([&] { session.take_answers(); });
}

TEST_F(OtherTables, AViewerRefusesASessionOfTheOther) {
    const ContactLoads loads(ours.tables);
    contact message{};
    message.model_hash = static_cast<std::int64_t>(ours.model.hash);
    EXPECT_NO_THROW(to_frame(message, loads, 0, "a log"));
    message.model_hash = static_cast<std::int64_t>(theirs.model.hash);
    expect_both_named([&] { to_frame(message, loads, 0, "a log"); });
}

TEST_F(OtherTables, AReplayRefusesARecordOfTheOther) {
    EXPECT_EQ(replay(ours, ours.hash()), 0);
    std::filesystem::remove(folder / "out.csv");
    testing::internal::CaptureStderr();
    EXPECT_NE(replay(ours, theirs.hash()), 0);
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find(ours.hash()), std::string::npos) << said;
    EXPECT_NE(said.find(theirs.hash()), std::string::npos) << said;
    EXPECT_FALSE(std::filesystem::exists(folder / "out.csv"));
}

}  // namespace
}  // namespace haptable::test
