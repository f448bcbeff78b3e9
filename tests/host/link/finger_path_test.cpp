// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/finger_path.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

class FingerPathTest : public testing::Test {
protected:
    std::vector<std::array<double, 3>> read(const std::string& text, Positions allowed = Positions::any) {
        write_file(folder / "path.csv", text);
        return read_finger_path(folder / "path.csv", allowed);
    }
    std::string error_of(const std::string& text, Positions allowed = Positions::any) {
        return test::error_of([&] { read(text, allowed); });
    }
    void expect_error_at(const std::string& text, int line, Positions allowed = Positions::any) {
        const std::string place = (folder / "path.csv").string() + ":" + std::to_string(line) + ": ";
        const std::string error = error_of(text, allowed);
        EXPECT_EQ(error.substr(0, place.size()), place) << error;
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    }

    WorkFolder folder;
};

TEST_F(FingerPathTest, ReadsPositions) {
    const auto path = read("x,y,z\n0.015,-2e-3,+.03\n1,2,3\n");
    ASSERT_EQ(path.size(), 2U);
    EXPECT_EQ(path[0], (std::array<double, 3>{0.015, -0.002, 0.03}));
    EXPECT_EQ(path[1], (std::array<double, 3>{1.0, 2.0, 3.0}));
}

// Of a servo's CSV what went in, and its ticks, whatever came out; also of one without buttons.
TEST_F(FingerPathTest, ReadsAServosOwnCsv) {
    const std::string begin = "tick,x,y,z,contact,force_x";
    write_file(folder / "path.csv", begin + ",buttons,state\n7,1,2,3,0,9.5,2,1\n9,nan,5,6,1,8.5,0,3\n");
    const auto ticks = read_finger_ticks(folder / "path.csv", Positions::any);
    ASSERT_EQ(ticks.size(), 2U);
    EXPECT_EQ(ticks[0].position_m, (std::array<double, 3>{1.0, 2.0, 3.0}));
    EXPECT_EQ(ticks[0].number, 7);
    EXPECT_EQ(ticks[0].buttons, 2U);
    EXPECT_EQ(ticks[1].number, 9);
    EXPECT_TRUE(std::isnan(ticks[1].position_m[0]));
    EXPECT_EQ(read(begin + "\n0,1,2,3,0,0\n")[0], (std::array<double, 3>{1.0, 2.0, 3.0}));
    expect_error_at(begin + "\n0,1,2,3,0,0\n1,1,2,3,0\n", 3);
    expect_error_at(begin + "\n0.5,1,2,3,0,0\n", 2);
}

TEST_F(FingerPathTest, ReadsHowAToolIsTurned) {
    write_file(folder / "path.csv", "x,y,z,qw,qx,qy,qz,buttons\n1,2,3,0.6,0,-0.8,0,2\n");
    const FingerTick tick = read_finger_ticks(folder / "path.csv", Positions::finite).at(0);
    EXPECT_EQ(tick.position_m, (std::array<double, 3>{1.0, 2.0, 3.0}));
    EXPECT_EQ(tick.turn, (std::array<double, 4>{0.6, 0.0, -0.8, 0.0}));
    EXPECT_EQ(tick.buttons, 2U);
    const std::string csv = "tick,x,y,z,contact,buttons,state,faults,qw,qx,qy,qz,torque_x\n4,1,2,3,0,1,1,0,1,0,0,0,9\n";
    write_file(folder / "path.csv", csv);
    EXPECT_EQ(read_finger_ticks(folder / "path.csv", Positions::any).at(0).turn,
              (std::array<double, 4>{1.0, 0.0, 0.0, 0.0}));
    expect_error_at("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0\n", 2);
    expect_error_at("x,y,z,qw,qx,qy,qz\n1,2,3,1,0.1,0,0\n", 2, Positions::finite);
    EXPECT_NO_THROW(read("x,y,z,qw,qx,qy,qz\n1,2,3,1,0.1,0,0\n"));  // the servo is to see it
    expect_error_at("x,y,z,qw\n1,2,3,1\n", 1);
}

TEST_F(FingerPathTest, ReadsButtonsWhereTheHeaderNamesThem) {
    write_file(folder / "path.csv", "x,y,z,buttons\n1,2,3,0\n4,5,6, 6\n");
    const auto ticks = read_finger_ticks(folder / "path.csv", Positions::any);
    ASSERT_EQ(ticks.size(), 2U);
    EXPECT_EQ(ticks[0].buttons, 0U);
    EXPECT_EQ(ticks[1].buttons, 6U);
    EXPECT_EQ(ticks[1].position_m, (std::array<double, 3>{4.0, 5.0, 6.0}));
    EXPECT_EQ(read("x,y,z,buttons\n1,2,3,0\n").size(), 1U) << "positions alone";
    expect_error_at("x,y,z,buttons\n1,2,3\n", 2);
    expect_error_at("x,y,z,buttons\n1,2,3,-1\n", 2);
    expect_error_at("x,y,z,buttons\n1,2,3,0.5\n", 2);
    expect_error_at("x,y,z,buttons\n1,2,3,\n", 2);
    expect_error_at("x,y,z,buttons\n1,2,3,0,0\n", 2);
    expect_error_at("x,y,z,force\n1,2,3,0\n", 1);
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
    expect_error_at("x,y,z\n1,2,3\n1,nan,3\n", 3, Positions::finite);
    expect_error_at("x,y,z\n1,2,1e999\n", 2, Positions::finite);
}

TEST_F(FingerPathTest, NamesTheBadLine) {
    expect_error_at("", 1);
    expect_error_at("1,2,3\n", 1);
    expect_error_at("x,y\n1,2\n", 1);
    expect_error_at("x,y,z\n1,2,3\n1,2\n", 3);
    expect_error_at("x,y,z\n1,2,3,4\n", 2);
    expect_error_at("x,y,z\n1,2,3\n\n1,2,3\n", 3);
    expect_error_at("x,y,z\n1,,3\n", 2);
    expect_error_at("x,y,z\n1,2,3mm\n", 2);
    expect_error_at("x,y,z\n1,2,0x10\n", 2);
    expect_error_at("x,y,z\n1;2;3\n", 2);
    expect_error_at("x,y,z\n1,2,--3\n", 2);
    expect_error_at(std::string("x,y,z\n1,2,\0\n", 11), 2);
}

TEST_F(FingerPathTest, NamesAMissingFile) {
    EXPECT_THROW(read_finger_path(folder / "none.csv", Positions::any), Error);
}

}  // namespace
}  // namespace haptable::test
