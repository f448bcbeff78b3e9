// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/finger_path.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class FingerPathTest : public testing::Test {
protected:
    std::vector<FingerTick> ticks(const std::string& text, Positions allowed = Positions::any) {
        write_file(path_, text);
        return read_finger_ticks(path_, allowed);
    }
    std::vector<std::array<double, 3>> read(const std::string& text, Positions allowed = Positions::any) {
        write_file(path_, text);
        return read_finger_path(path_, allowed);
    }

    const WorkFolder folder_;
    const std::filesystem::path path_ = folder_ / "path.csv";
};

TEST_F(FingerPathTest, ReadsPositions) {
    const auto path = read("x,y,z\n0.015,-2e-3,+.03\n1,2,3\n");
    ASSERT_EQ(path.size(), 2U);
    EXPECT_EQ(path[0], (std::array<double, 3>{0.015, -0.002, 0.03}));
    EXPECT_EQ(path[1], (std::array<double, 3>{1.0, 2.0, 3.0}));
    EXPECT_EQ(ticks("x,y,z,x2,y2,z2\n0,0,0,1,2,3\n").at(0).others.at(0).position_m, path[1]) << "of two fingers";
}

const std::string kServo = "tick,x,y,z,contact,force_x";

// Of a servo's CSV what went in, and its ticks, whatever came out; also of one without buttons.
TEST_F(FingerPathTest, ReadsAServosOwnCsv) {
    const auto read_ticks = ticks(kServo + ",buttons,state\n7,1,2,3,0,9.5,2,1\n9,nan,5,6,1,8.5,0,3\n");
    ASSERT_EQ(read_ticks.size(), 2U);
    EXPECT_EQ(read_ticks[0].position_m, (std::array<double, 3>{1.0, 2.0, 3.0}));
    EXPECT_EQ(read_ticks[0].number, 7);
    EXPECT_EQ(read_ticks[0].buttons, 2U);
    EXPECT_EQ(read_ticks[1].number, 9);
    EXPECT_TRUE(std::isnan(read_ticks[1].position_m[0]));
    EXPECT_EQ(read(kServo + "\n0,1,2,3,0,0\n")[0], (std::array<double, 3>{1.0, 2.0, 3.0}));
}

TEST_F(FingerPathTest, ReadsHowAToolIsTurned) {
    const FingerTick tick = ticks("x,y,z,qw,qx,qy,qz,buttons\n1,2,3,0.6,0,-0.8,0,2\n", Positions::finite).at(0);
    EXPECT_EQ(tick.position_m, (std::array<double, 3>{1.0, 2.0, 3.0}));
    EXPECT_EQ(tick.turn, (std::array<double, 4>{0.6, 0.0, -0.8, 0.0}));
    EXPECT_EQ(tick.buttons, 2U);
    const std::string csv = "tick,x,y,z,contact,buttons,state,faults,qw,qx,qy,qz,torque_x\n4,1,2,3,0,1,1,0,1,0,0,0,9\n";
    EXPECT_EQ(ticks(csv).at(0).turn, (std::array<double, 4>{1.0, 0.0, 0.0, 0.0}));
    EXPECT_NO_THROW(read("x,y,z,qw,qx,qy,qz\n1,2,3,1,0.1,0,0\n"));  // the servo is to see it
}

TEST_F(FingerPathTest, ReadsWhatOtherSystemsWrite) {
    EXPECT_EQ(read("\xEF\xBB\xBFx,y,z\r\n1,2,3\r\n4,5,6").size(), 2U);
    EXPECT_EQ(read("x, y, z\n 1 ,\t2, 3 \n\n\n").size(), 1U);
    EXPECT_TRUE(read("x,y,z\n").empty());
    EXPECT_TRUE(read("x,y,z").empty());
}

TEST_F(FingerPathTest, KeepsWhatIsNotFinite) {
    const auto path = read("x,y,z\nnan,-inf,Infinity\n1e999,-1e999,1e-999\n");
    ASSERT_EQ(path.size(), 2U);
    EXPECT_TRUE(std::isnan(path[0][0]));
    EXPECT_EQ(path[0][1], -INFINITY);
    EXPECT_EQ(path[0][2], INFINITY);
    EXPECT_EQ(path[1], (std::array<double, 3>{INFINITY, -INFINITY, 0.0}));
}

TEST_F(FingerPathTest, NamesTheBadLine) {
    const auto expect_at = [this](int line, Positions allowed, const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            const std::string error = error_of([&] { read(text, allowed); });
            EXPECT_TRUE(error.starts_with(fmt::format("{}:{}: ", path_.string(), line))) << text << error;
            EXPECT_EQ(error.find('\n'), std::string::npos) << error;
        }
    };
    const std::string turned = "x,y,z,qw,qx,qy,qz\n", pressed = "x,y,z,buttons\n";
    expect_at(1, Positions::any,
              {"", "1,2,3\n", "x,y\n1,2\n", "x,y,z,force\n1,2,3,0\n", "x,y,z,qw\n1,2,3,1\n", "x,y,z,x2\n"});
    expect_at(2, Positions::any,
              {"x,y,z\n1,2,3,4\n", "x,y,z\n1,,3\n", "x,y,z\n1,2,3mm\n", "x,y,z\n1,2,0x10\n", "x,y,z\n1;2;3\n",
               "x,y,z\n1,2,--3\n", std::string("x,y,z\n1,2,\0\n", 11), kServo + "\n0.5,1,2,3,0,0\n",
               turned + "1,2,3,1,0,0\n", pressed + "1,2,3\n", pressed + "1,2,3,-1\n", pressed + "1,2,3,0.5\n",
               pressed + "1,2,3,\n", pressed + "1,2,3,0,0\n"});
    expect_at(3, Positions::any,
              {"x,y,z\n1,2,3\n1,2\n", "x,y,z\n1,2,3\n\n1,2,3\n", kServo + "\n0,1,2,3,0,0\n1,1,2,3,0\n"});
    expect_at(2, Positions::finite,
              {"x,y,z\n1,2,1e999\n", turned + "1,2,3,1,0.1,0,0\n", "x,y,z,x2,y2,z2\n0,0,0,1,1\n",
               "x,y,z,x2,y2,z2\n0,0,0,1,nan,1\n"});
    expect_at(3, Positions::finite, {"x,y,z\n1,2,3\n1,nan,3\n"});
    EXPECT_THROW(read_finger_path(folder_ / "none.csv", Positions::any), Error);
}

}  // namespace
}  // namespace haptable::test
