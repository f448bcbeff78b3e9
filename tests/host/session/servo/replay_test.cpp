// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/replay.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "host/base/error.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

constexpr const char* kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z,"
    "buttons,state,faults";

class ReplayTest : public testing::Test {
protected:
    ServoReport run(const std::string& path, const std::string& out = "out.csv") {
        write_file(folder / "in.csv", path);
        return replay(box.scene(), folder / "in.csv", folder / out, true);
    }

    SoftBox box;
    WorkFolder folder;
};

/// Down into the top, along it, and out again.
std::string stroke() {
    std::string text = "x,y,z\n";
    for (int i = 0; i < 300; ++i) {
        const double s = i / 300.0;
        const double depth_m = 0.004 * std::sin(M_PI * s) - 0.001;
        text += std::to_string(0.006 + 0.017 * s) + ",0.0131," + std::to_string(0.03 - depth_m) + "\n";
    }
    return text;
}

bool same_bits(float a, double b) {
    const auto narrow = static_cast<float>(b);
    return std::memcmp(&a, &narrow, sizeof a) == 0;
}

// Every number of the CSV reads back as the very float of the servo.
TEST_F(ReplayTest, WritesWhatTheServoGives) {
    const ServoReport report = run(stroke());
    const auto rows = read_rows(folder / "out.csv"), in = read_rows(folder / "in.csv");
    EXPECT_EQ(lines_of(read_file(folder / "out.csv"))[0], kHeader);
    ASSERT_EQ(rows.size(), 300U);
    haptable_servo servo;
    haptable_servo_init(&servo);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::array<float, 3> finger = to_finger(in[i].data());
        haptable_output out;
        haptable_servo_step(box.scene().model, &servo, finger.data(), static_cast<std::uint32_t>(i * 1000), &out);
        const std::vector<double>& row = rows[i];
        ASSERT_EQ(row.size(), 20U);
        EXPECT_EQ(row[0], static_cast<double>(i));
        EXPECT_EQ(row[4], out.state == HAPTABLE_CONTACT ? 1.0 : 0.0);
        for (std::size_t a = 0; a < 3; ++a) {
            EXPECT_TRUE(same_bits(finger[a], row[1 + a]));
            EXPECT_EQ(row[5 + a], mesh_node(box.scene(), out, a));
            EXPECT_TRUE(same_bits(out.alpha[a], row[8 + a]));
            EXPECT_TRUE(same_bits(out.god_object_m[a], row[11 + a]));
            EXPECT_TRUE(same_bits(out.force_n[a], row[14 + a]));
        }
    }
    EXPECT_EQ(report.counters.ticks, 300U);
    EXPECT_GT(report.counters.contact_ticks, 150U);
    EXPECT_GT(report.largest_force_n, 0.01);
    EXPECT_EQ(report.step.count(), 300U);
}

// The nodes are mesh nodes: the god-object is where they and the area coordinates say.
TEST_F(ReplayTest, NamesTheNodesOfTheMesh) {
    run(stroke());
    for (const auto& row : read_rows(folder / "out.csv")) {
        if (row[4] == 0.0) {
            for (int a = 5; a < 11; ++a) EXPECT_EQ(row[static_cast<std::size_t>(a)], a < 8 ? -1.0 : 0.0);
            for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(row[11 + a], row[1 + a]);
            continue;
        }
        for (std::size_t a = 0; a < 3; ++a) {
            double god = 0.0;
            for (std::size_t c = 0; c < 3; ++c)
                god += row[8 + c] * box.model().tables().position[static_cast<std::size_t>(row[5 + c])][a];
            EXPECT_WITHIN(std::abs(god - row[11 + a]), rounded(box.model()));
        }
    }
}

TEST_F(ReplayTest, RecordsTheButtons) {
    run("x,y,z,buttons\n0,0,0.031,0\n0,0,0.031,2\n0,0,0.031,6\n");
    const auto rows = read_rows(folder / "out.csv");
    ASSERT_EQ(rows.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(rows[i].at(17), (std::array{0.0, 2.0, 6.0})[i]);
}

TEST_F(ReplayTest, MakesTheSameBytesTwice) {
    run(stroke(), "one.csv");
    run(stroke(), "two.csv");
    EXPECT_EQ(read_file(folder / "one.csv"), read_file(folder / "two.csv"));
}

// What is not a position reaches the servo, which answers with nothing and goes on.
TEST_F(ReplayTest, RejectsBadPositionsAndGoesOn) {
    const ServoReport report =
        run("x,y,z\n0.011,0.012,0.031\n0.011,0.012,0.029\nnan,0,0\n0,-inf,0\n1e30,0,0\n1e300,0,0\n"
            "0.011,0.012,0.031\n0.011,0.012,0.029\n");
    EXPECT_EQ(report.counters.rejected_positions, 4U);
    EXPECT_EQ(report.counters.contact_ticks, 2U);
    const std::vector<std::string> lines = lines_of(read_file(folder / "out.csv"));
    ASSERT_EQ(lines.size(), 9U);
    EXPECT_EQ(lines[3], "2,nan,0,0,0,-1,-1,-1,0,0,0,0,0,0,0,0,0,0,3,0");
    EXPECT_EQ(lines[4], "3,0,-inf,0,0,-1,-1,-1,0,0,0,0,0,0,0,0,0,0,3,0");
}

TEST_F(ReplayTest, WritesNothingForABadPath) {
    EXPECT_THROW(run("x,y,z\n0,0,0\n0,0\n"), Error);
    EXPECT_EQ(folder.file_count(), 1U);  // in.csv
    EXPECT_THROW(replay(box.scene(), folder / "in.csv", folder / "no" / "out.csv", true), Error);
}

TEST_F(ReplayTest, TakesAnEmptyPath) {
    EXPECT_EQ(run("x,y,z\n").counters.ticks, 0U);
    EXPECT_EQ(read_file(folder / "out.csv"), fmt::format("{}\n", kHeader));
}

}  // namespace
}  // namespace haptable::test
