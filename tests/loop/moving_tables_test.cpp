// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of a body that nothing holds before programs that know none: one line that names folder or file and key,
// instead of another body's forces.
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

constexpr const char* kCube = R"([mesh]
generate = "cube"
nodes_per_side = 3
[material]
young = 1e4
poisson = 0.3
)";
constexpr const char* kHeld = "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n";

class MovingTables : public testing::Test {
protected:
    void make(const std::string& name, const std::string& rest) const {
        write_file(folder / (name + ".toml"), "name = \"" + name + "\"\n" + kCube + rest);
        const Outcome made = run(program("haptable-precompute").string() + " --quiet " + name + ".toml", folder.path());
        ASSERT_EQ(made.status, 0) << made.err;
    }
    void SetUp() override {
        ASSERT_NO_FATAL_FAILURE(make("ringing", std::string(kHeld) + "[body]\nmodes = 4\ndensity = 1000\n"));
        ASSERT_NO_FATAL_FAILURE(make("loose", "[body]\nfree = true\ndensity = 1000\n"));
        write_file(folder / "press.csv", "time_s,depth_m,force_n\n0,0.001,0.1\n1,0.001,0.1\n");
    }
    std::string refusal(const std::string& command) const {
        const Outcome outcome = run(program(command).string(), folder.path());
        EXPECT_EQ(outcome.status, 1) << command;
        EXPECT_EQ(lines_of(outcome.err).size(), 1U) << outcome.err;
        return outcome.err;
    }

    WorkFolder folder;
};

TEST_F(MovingTables, AreRefusedByAFitThatHoldsThemStill) {
    const std::string said = refusal("haptable-fit press.csv loose.toml");
    EXPECT_NE(said.find("build/loose: "), std::string::npos) << said;
    EXPECT_NE(said.find("remove free = true from [body]"), std::string::npos) << said;
}

}  // namespace
}  // namespace haptable::test
