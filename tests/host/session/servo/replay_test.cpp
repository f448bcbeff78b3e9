// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/replay.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/moving_body.hpp"

namespace haptable::test {
namespace {

constexpr const char* kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z,"
    "buttons,state,faults";

class ReplayTest : public testing::Test {
protected:
    ServoReport run(const std::string& path) {
        write_file(folder / "in.csv", path);
        return replay(scene, folder / "in.csv", folder / "out.csv", true);
    }
    std::vector<Row> rows() const { return read_rows(folder / "out.csv"); }

    SoftBox box;
    ServoScene scene = box.scene();
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

constexpr const char* kNode[] = {"node_i", "node_j", "node_k"};

bool same_floats(const Eigen::Vector3d& read, const float given[3]) {
    const Eigen::Vector3f narrow = read.cast<float>();
    return std::memcmp(narrow.data(), given, 3 * sizeof given[0]) == 0;
}

// Every number of the CSV reads back as the very float of the servo.
TEST_F(ReplayTest, WritesWhatTheServoGives) {
    const ServoReport report = run(stroke());
    const auto written = rows(), in = read_rows(folder / "in.csv");
    EXPECT_EQ(lines_of(read_file(folder / "out.csv"))[0], kHeader);
    ASSERT_EQ(written.size(), 300U);
    Finger servo(*scene.model);
    for (std::size_t i = 0; i < written.size(); ++i) {
        const haptable_output& out = servo.to(xyz_of(in[i]));
        const Row& row = written[i];
        ASSERT_EQ(row.size(), 20U);
        EXPECT_EQ(row.at("tick"), static_cast<double>(i));
        EXPECT_EQ(row.at("contact"), out.state == HAPTABLE_CONTACT ? 1.0 : 0.0);
        for (const auto& [name, floats] : {std::pair<const char*, const float*>{"", servo.at_m()},
                                           {"god_", out.god_object_m},
                                           {"force_", out.force_n}})
            EXPECT_TRUE(same_floats(xyz_of(row, name), floats)) << name;
        EXPECT_TRUE(same_floats({row.at("alpha_i"), row.at("alpha_j"), row.at("alpha_k")}, out.alpha));
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(row.at(kNode[c]), mesh_node(scene, out, c));
    }
    EXPECT_EQ(report.counters.ticks, 300U);
    EXPECT_GT(report.counters.contact_ticks, 150U);
    EXPECT_GT(report.largest_force_n, 0.01);
    EXPECT_EQ(report.step.count(), 300U);
}

// The nodes are mesh nodes: the god-object is where they and the area coordinates say.
TEST_F(ReplayTest, NamesTheNodesOfTheMesh) {
    run(stroke());
    for (const auto& row : rows()) {
        const Eigen::Vector3d alpha(row.at("alpha_i"), row.at("alpha_j"), row.at("alpha_k"));
        if (row.at("contact") == 0.0) {
            for (const char* node : kNode) EXPECT_EQ(row.at(node), -1.0);
            EXPECT_EQ(alpha, Eigen::Vector3d::Zero());
            EXPECT_EQ(xyz_of(row, "god_"), xyz_of(row));
            continue;
        }
        Eigen::Vector3d god = -xyz_of(row, "god_");
        for (int c = 0; c < 3; ++c) {
            const auto& corner = box.model().tables().position[static_cast<std::size_t>(row.at(kNode[c]))];
            god += alpha[c] * Eigen::Vector3d(corner.data());
        }
        EXPECT_WITHIN(god.cwiseAbs().maxCoeff(), rounded(box.model()));
    }
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
    EXPECT_TRUE(fails_with([&] { run("x,y,z,x2,y2,z2\n0,0,0,1,1,1\n"); }, "fingers = 2"));
    EXPECT_THROW(replay(scene, folder / "in.csv", folder / "no" / "out.csv", true), Error);
}

TEST_F(ReplayTest, TakesAnEmptyPath) {
    EXPECT_EQ(run("x,y,z\n").counters.ticks, 0U);
    EXPECT_EQ(read_file(folder / "out.csv"), fmt::format("{}\n", kHeader));
}

// ---- a body that nothing holds -------------------------------------------------------------------------------------

TEST_F(ReplayTest, HasThePoseOfABodyThatFalls) {
    haptable_body body = cube_body();
    add_gravity(body);
    scene.body = &body;
    std::string path = "x,y,z\n";
    for (int tick = 0; tick < 200; ++tick) path += "0.015,0.015,0.1\n";
    run(path);
    EXPECT_EQ(lines_of(read_file(folder / "out.csv"))[0],
              fmt::format("{},body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z", kHeader));
    const auto written = rows();
    ASSERT_EQ(written.size(), 200U);
    for (std::size_t k = 0; k < written.size(); ++k) {
        const double t = 0.001 * double(k), fallen = 0.5 * 9.81 * t * t;
        EXPECT_NEAR(written[k].at("body_z"), 0.015 - fallen, 1e-4 * fallen + 1e-8);
        EXPECT_EQ(written[k].at("turn_w"), 1.0);
    }
}

}  // namespace
}  // namespace haptable::test
