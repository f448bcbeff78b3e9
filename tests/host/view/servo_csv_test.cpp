// SPDX-License-Identifier: GPL-2.0-or-later
// Equations 9 and 10 from a servo's CSV, of a body that moves and of two fingers too, and what is said about a bad one.
#include "host/view/servo_csv.hpp"

#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

const std::string kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z\n";
const std::string kFree = ",0.015,0.015,0.04,0,-1,-1,-1,0,0,0,0.015,0.015,0.04,0,0,0\n";

/// A line with more columns behind its own.
std::string longer(std::string line, const std::string& by) { return line.insert(line.size() - 1, by); }

class ViewServoCsv : public WithCube {
protected:
    ViewServoCsv() {
        patch_ = *std::find_if(tables_.patch.begin(), tables_.patch.end(), [](const auto& p) {
            return std::find(p.begin(), p.end(), 112) != p.end();  // a patch at the middle of the top
        });
    }

    /// What a tick tells of a finger that presses.
    std::string pressing(const std::string& at, const std::string& alpha = "0.5,0.25,0.25") const {
        return fmt::format("{},1,{},{},0.015,0.014,0.03,0.1,-0.2,0.3", at, fmt::join(patch_, ","), alpha);
    }
    std::string press(int tick, const std::string& alpha = "0.5,0.25,0.25") const {
        return fmt::format("{},{}\n", tick, pressing("0.015,0.015,0.028", alpha));
    }

    std::vector<ContactFrame> read(const std::string& text, const FrameChoice& choice = {.every_ms = 1, .ticks = {}}) {
        write_file(csv_, text);
        return read_servo_csv(csv_, loads_, choice);
    }

    /// The error of a text must begin with the file and the line and contain `what`.
    void expect_error(const std::string& text, int line, const std::string& what, const FrameChoice& choice = {}) {
        const std::string said = error_of([&] { read(text, choice); });
        const std::string place = csv_.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
        EXPECT_EQ(said.rfind(place, 0), 0U) << said;
        EXPECT_TRUE(says(said, what));
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }

    const std::filesystem::path csv_ = folder_.path() / "servo.csv";
    const ContactLoads loads_{tables_};
    std::array<std::int32_t, 3> patch_{};
};

// Behind a mark of UTF-8, which is skipped.
TEST_F(ViewServoCsv, LoadsAreThoseOfEquations9And10) {
    const std::vector<ContactFrame> frames = read("\xEF\xBB\xBF" + kHeader + "0" + kFree + press(1));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_FALSE(frames[0].contact);
    EXPECT_TRUE(frames[0].loads.empty());
    EXPECT_TRUE(frames[0].finger_known);
    const ContactFrame& frame = frames[1];
    EXPECT_EQ(frame.number, 1);
    EXPECT_WITHIN(std::abs(frame.time_s - 0.001), .count = 4, .size = 0.001);
    EXPECT_EQ(frame.force_n, Vector3d(0.1, -0.2, 0.3));
    ASSERT_EQ(frame.loads.size(), 3U);
    const Vector3d u = Vector3d(0.015, 0.015, 0.028) - Vector3d(0.015, 0.014, 0.03);
    const double alpha[3] = {0.5, 0.25, 0.25};
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(frame.loads[k].node, patch_[k]);
        const auto i =
            std::size_t(std::find(tables_.node_id.begin(), tables_.node_id.end(), patch_[k]) - tables_.node_id.begin());
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(tables_.stiffness[i].data());
        for (int a = 0; a < 3; ++a)  // u is a difference of floats near 0.03
            EXPECT_WITHIN(std::abs(frame.loads[k].force_n[std::size_t(a)] - alpha[k] * s.row(a).dot(u)), .count = 8,
                          .epsilon = kFloat, .size = 0.03 * alpha[k] * s.row(a).norm());
    }
}

TEST_F(ViewServoCsv, AFixedNodeHasTheRigidStiffness) {
    patch_ = *std::find_if(tables_.patch.begin(), tables_.patch.end(),
                           [&](const auto& p) { return tables_.position[std::size_t(p[0])][2] == 0.0; });
    const ContactFrame frame = read(kHeader + press(0, "1,0,0")).at(0);
    // The rounding of u, a difference of floats near 0.03.
    const Bound rounded{.count = 8, .epsilon = kFloat, .size = 1000.0 * 0.03};
    EXPECT_WITHIN(std::abs(frame.loads[0].force_n[1] - 1000.0 * 0.001), rounded);
    EXPECT_WITHIN(std::abs(frame.loads[0].force_n[2] + 1000.0 * 0.002), rounded);
}

TEST_F(ViewServoCsv, PicksEveryNthTickOrTheNamedOnes) {
    std::string text = kHeader;
    for (int t = 0; t < 100; ++t) text += std::to_string(t) + kFree;
    const auto every = read(text, {.every_ms = 33, .ticks = {}});
    ASSERT_EQ(every.size(), 4U);
    EXPECT_EQ(every[3].number, 99);
    const auto named = read(text, {.every_ms = 33, .ticks = {7, 3}});
    ASSERT_EQ(named.size(), 2U);
    EXPECT_EQ(named[0].number, 3);
    EXPECT_EQ(named[1].number, 7);
    expect_error(text, 0, "no tick 100", {.every_ms = 33, .ticks = {7, 100}});
}

TEST_F(ViewServoCsv, ARejectedPositionIsAFingerThatIsNowhere) {
    const auto frames =
        read(kHeader + "0,nan,0,0,0,-1,-1,-1,0,0,0,0,0,0,0,0,0\r\n1,inf,0,0,0,-1,-1,-1,0,0,0,0,0,0,0,0,0");
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_FALSE(frames[0].finger_known);
    EXPECT_FALSE(frames[1].finger_known);
}

TEST_F(ViewServoCsv, LetsColumnsBehindItsOwnBe) {
    const std::string header = longer(kHeader, ",buttons,more");
    const auto frames = read(header + longer("0" + kFree, ",0,1") + longer(press(1), ",2,x"));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_TRUE(frames[1].contact);
    expect_error(header + "0" + kFree, 2, "17 columns where 19");
    expect_error(longer(kHeader, "s") + "0" + kFree, 1, "header");
}

const std::string kState = ",buttons,state,faults";

// Loads are those of the dent in the body's frame: the same press, wherever the body is.
TEST_F(ViewServoCsv, ABodysPoseIsThatOfTheLastColumns) {
    const std::string place = ",0.015,0.015,1,0,0,0";
    const auto frames = read(longer(kHeader, kState + ",body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z") + "0," +
                             pressing("0.015,0.015,0.028") + ",0,2,0,0.015" + place + "\n" + "1," +
                             pressing("1.015,0.015,0.028") + ",0,2,0,1.015" + place + "\n");
    ASSERT_EQ(frames.size(), 2U);
    ASSERT_TRUE(frames[1].pose);
    EXPECT_WITHIN((*frames[1].pose * Vector3d::Zero() - Vector3d::UnitX()).norm(), .count = 8);
    ASSERT_EQ(frames[0].loads.size(), frames[1].loads.size());
    for (std::size_t i = 0; i < frames[0].loads.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_WITHIN(std::abs(frames[1].loads[i].force_n[c] - frames[0].loads[i].force_n[c]), .count = 16,
                          .epsilon = kFloat, .size = 0.5);
}

// A second finger is drawn, and its load is the reaction of what it feels, in the body's frame.
TEST_F(ViewServoCsv, TwoFingersLoadBoth) {
    std::string second = kState;
    for (const char* name : {"x", "y", "z", "contact", "node_i", "node_j", "node_k", "alpha_i", "alpha_j", "alpha_k",
                             "god_x", "god_y", "god_z", "force_x", "force_y", "force_z", "buttons", "state", "faults"})
        second += std::string(",") + name + "2";
    const std::string away = ",0.1,0,0,0,-1,-1,-1,0,0,0,0.1,0,0,0,0,0,0,1,0,",
                      none = ",0,-1,-1,-1,0,0,0,0,0,0,0,0,0,0,";
    const auto frames = read(longer(kHeader, second) + "0" + away + pressing("0.01,0.01,0.01") + ",0,2,0\n" + "1" +
                             away + "0.01,0.01,0.06" + none + "1,0\n" + "2" + away + "nan,nan,nan" + none + "0,0\n");
    ASSERT_EQ(frames.size(), 3U);
    ASSERT_FALSE(frames[1].others.empty()) << "free, it is drawn";
    EXPECT_EQ(frames[1].others[0].finger_m.z(), 0.06);
    EXPECT_FALSE(frames[1].others[0].contact);
    EXPECT_TRUE(frames[1].loads.empty());
    EXPECT_TRUE(frames[2].others.empty()) << "nowhere";
    ASSERT_TRUE(!frames[0].others.empty() && frames[0].others[0].contact);
    EXPECT_EQ(frames[0].others[0].god_object_m, Vector3d(0.015, 0.014, 0.03));
    Vector3d sum = Vector3d::Zero();
    for (const NodalForce& load : frames[0].loads) sum += Vector3d(load.force_n[0], load.force_n[1], load.force_n[2]);
    EXPECT_WITHIN((sum - Vector3d(-0.1, 0.2, -0.3)).norm(), .count = 16, .epsilon = kFloat, .size = 0.4);
}

TEST_F(ViewServoCsv, ErrorsNameFileAndLine) {
    const std::string nowhere = ",-1,-1,-1,0,0,0,0,0,0,0,0,0\n";
    const std::tuple<std::string, int, const char*> cases[] = {
        {"x,y,z\n0,0,0\n", 1, "header"},
        {"", 1, "header"},
        {kHeader, 0, "no tick"},
        {kHeader + "0" + kFree + "1,2,3\n", 3, "3 columns where 17"},
        {kHeader + "0" + kFree + "\n", 3, "0 columns"},
        {kHeader + "zero" + kFree, 2, "tick is \"zero\""},
        {kHeader + "0,1,2,3x,0" + nowhere, 2, "\"3x\""},
        {kHeader + "0,1,2,3,2" + nowhere, 2, "contact is 2"},
        {kHeader + "0,1,2,3,0,1,-1,-1,0,0,0,0,0,0,0,0,0\n", 2, "must be -1"},
        {kHeader + "5" + kFree + "5" + kFree, 3, "ticks must rise"},
        {kHeader + press(0, "0.5,0.5,0.5"), 2, "sum to 1"},
        {kHeader + press(0, "1.5,-0.5,0"), 2, "0..1"},
        {kHeader + press(0, "nan,0.5,0.5"), 2, "not finite"}};
    for (const auto& [text, line, what] : cases) expect_error(text, line, what);
    for (const auto& patch : {std::array<std::int32_t, 3>{0, 1, 124}, {-1, 5000, 3}}) {
        patch_ = patch;
        expect_error(kHeader + press(0), 2, "no touchable patch");
    }
}

}  // namespace
}  // namespace haptable::test
