// SPDX-License-Identifier: GPL-2.0-or-later
// Equations 9 and 10 from a servo's CSV, and what is said about a bad one.
#include "host/view/servo_csv.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/base/error.hpp"
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

class ViewServoCsv : public ::testing::Test {
protected:
    ViewServoCsv() {
        write_cube_tables(folder_.path());
        tables_ = read_tables(folder_.path());
        loads_ = std::make_unique<ContactLoads>(tables_);
        patch_ = *std::find_if(tables_.patch.begin(), tables_.patch.end(), [](const auto& p) {
            return std::find(p.begin(), p.end(), 112) != p.end();  // a patch at the middle of the top
        });
    }

    std::string press(int tick, const std::string& alpha = "0.5,0.25,0.25") const {
        return std::to_string(tick) + ",0.015,0.015,0.028,1," + std::to_string(patch_[0]) + "," +
               std::to_string(patch_[1]) + "," + std::to_string(patch_[2]) + "," + alpha +
               ",0.015,0.014,0.03,0.1,-0.2,0.3\n";
    }

    std::vector<ContactFrame> read(const std::string& text, const FrameChoice& choice = {.every_ms = 1, .ticks = {}}) {
        write_file(csv_, text);
        return read_servo_csv(csv_, *loads_, choice);
    }

    /// The error of a text must begin with the file and the line and contain `what`.
    void expect_error(const std::string& text, int line, const std::string& what, const FrameChoice& choice = {}) {
        const std::string said = error_of([&] { read(text, choice); });
        const std::string place = csv_.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
        EXPECT_EQ(said.rfind(place, 0), 0U) << said;
        EXPECT_NE(said.find(what), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }

    TemporaryFolder folder_;
    std::filesystem::path csv_ = folder_.path() / "servo.csv";
    Tables tables_;
    std::unique_ptr<ContactLoads> loads_;
    std::array<std::int32_t, 3> patch_{};
};

TEST_F(ViewServoCsv, AMarkOfUtf8IsSkipped) {
    EXPECT_EQ(read("\xEF\xBB\xBF" + kHeader + "0" + kFree + press(1)).size(), 2U);
}

TEST_F(ViewServoCsv, LoadsAreThoseOfEquations9And10) {
    const std::vector<ContactFrame> frames = read(kHeader + "0" + kFree + press(1));
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
        const auto i = static_cast<std::size_t>(std::find(tables_.node_id.begin(), tables_.node_id.end(), patch_[k]) -
                                                tables_.node_id.begin());
        const auto& s = tables_.stiffness[i];
        for (std::size_t a = 0; a < 3; ++a) {
            const double f = alpha[k] * (s[3 * a] * u.x() + s[3 * a + 1] * u.y() + s[3 * a + 2] * u.z());
            const double size = alpha[k] * Vector3d(s[3 * a], s[3 * a + 1], s[3 * a + 2]).norm();
            // u is a difference of floats near 0.03.
            EXPECT_WITHIN(std::abs(frame.loads[k].force_n[a] - f), .count = 8, .epsilon = kFloat, .size = size * 0.03);
        }
    }
}

TEST_F(ViewServoCsv, AFixedNodeHasTheRigidStiffness) {
    patch_ = *std::find_if(tables_.patch.begin(), tables_.patch.end(),
                           [&](const auto& p) { return tables_.position[static_cast<std::size_t>(p[0])][2] == 0.0; });
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
    const auto longer = [](std::string line, const std::string& by) { return line.insert(line.size() - 1, by); };
    const std::string header = longer(kHeader, ",buttons,more");
    const auto frames = read(header + longer("0" + kFree, ",0,1") + longer(press(1), ",2,x"));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_TRUE(frames[1].contact);
    expect_error(header + "0" + kFree, 2, "17 columns where 19");
    expect_error(longer(kHeader, "s") + "0" + kFree, 1, "header");
}

TEST_F(ViewServoCsv, ErrorsNameFileAndLine) {
    expect_error("x,y,z\n0,0,0\n", 1, "header");
    expect_error("", 1, "header");
    expect_error(kHeader, 0, "no tick");
    expect_error(kHeader + "0" + kFree + "1,2,3\n", 3, "3 columns where 17");
    expect_error(kHeader + "0" + kFree + "\n", 3, "0 columns");
    expect_error(kHeader + "zero" + kFree, 2, "tick is \"zero\"");
    expect_error(kHeader + "0,1,2,3x,0,-1,-1,-1,0,0,0,0,0,0,0,0,0\n", 2, "\"3x\"");
    expect_error(kHeader + "0,1,2,3,2,-1,-1,-1,0,0,0,0,0,0,0,0,0\n", 2, "contact is 2");
    expect_error(kHeader + "0,1,2,3,0,1,-1,-1,0,0,0,0,0,0,0,0,0\n", 2, "must be -1");
    expect_error(kHeader + "5" + kFree + "5" + kFree, 3, "ticks must rise");
    expect_error(kHeader + press(0, "0.5,0.5,0.5"), 2, "sum to 1");
    expect_error(kHeader + press(0, "1.5,-0.5,0"), 2, "0..1");
    expect_error(kHeader + press(0, "nan,0.5,0.5"), 2, "not finite");
    patch_ = {0, 1, 124};
    expect_error(kHeader + press(0), 2, "no touchable patch");
    patch_ = {-1, 5000, 3};
    expect_error(kHeader + press(0), 2, "no touchable patch");
}

}  // namespace
}  // namespace haptable::test
