// SPDX-License-Identifier: GPL-2.0-or-later
// One body, written in several ways: the same tables.
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "host/base/file.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/tables.hpp"
#include "tests/cells.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

const fs::path kShared = "../shared/meshes";

class SameTables : public testing::Test {
protected:
    void SetUp() override {
        if (!fs::exists(kShared)) GTEST_SKIP() << "no ../shared/meshes";
    }
    /// Held up to that height.
    Tables compute(const fs::path& mesh, double up_to_m = 1e-3) {
        Scene scene;
        scene.file = "same.toml";
        scene.name = "same";
        scene.mesh.file = mesh;
        scene.material = {1e4, 0.3};
        scene.fixed.push_back({std::array<double, 6>{-1e9, -1e9, -1e9, 1e9, 1e9, up_to_m}, "", 1});
        Progress progress(true);
        precompute(scene, folder_.path() / "out", progress);
        return read_tables(folder_.path() / "out");
    }
    /// The same text with the line ends of another system.
    fs::path with_crlf(const fs::path& from) {
        std::string crlf;
        for (char c : read_file(from)) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
        write_file(folder_.path() / from.filename(), crlf);
        return folder_.path() / from.filename();
    }
    const TemporaryFolder folder_;
};

/// Positions up to a move of the whole body; tolerance: of the largest entry of S, and in metres.
void expect_same(const Tables& a, const Tables& b, double tolerance) {
    ASSERT_EQ(a.patch, b.patch);
    ASSERT_EQ(a.node_id, b.node_id);
    ASSERT_EQ(a.stiffness.size(), b.stiffness.size());
    double scale = 0.0;
    for (const auto& block : a.stiffness)
        for (double s : block) scale = std::max(scale, std::abs(s));
    for (std::size_t i = 0; i < a.stiffness.size(); ++i)
        for (std::size_t k = 0; k < 9; ++k)
            EXPECT_WITHIN(std::abs(a.stiffness[i][k] - b.stiffness[i][k]), .epsilon = tolerance, .size = scale);
    for (std::size_t i = 0; i < a.position.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_WITHIN(std::abs((a.position[i][k] - a.position[0][k]) - (b.position[i][k] - b.position[0][k])),
                          .epsilon = tolerance);
}

TEST_F(SameTables, CrlfCrAndLargeNumbersOfNodes) {
    const Tables plain = compute(kShared / "bad/00_good_base.msh");
    ASSERT_FALSE(plain.node_id.empty());
    for (const fs::path& other : {with_crlf(kShared / "bad/00_good_base.msh"), kShared / "bad/24_cr_only.msh",
                                  kShared / "bad/41_node_ids_4e9.msh", kShared / "bad/12_inverted_three.msh"})
        expect_same(plain, compute(other), 0.0);
}

TEST_F(SameTables, CrlfInEveryTextFormat) {
    for (const char* name : {"liver_181.msh", "teddy_410.vtk", "abaqus_tet_13.inp", "turtle_347.veg"}) {
        SCOPED_TRACE(name);
        const fs::path file = kShared / name;
        const double low = lowest_tenth_m(read_mesh(file, 1.0));
        expect_same(compute(file, low), compute(with_crlf(file), low), 0.0);
    }
}

TEST_F(SameTables, FarFromTheOrigin) {
    const Tables plain = compute(kShared / "bad/00_good_base.msh");
    const double far = 1e7 + 1e-3;
    expect_same(plain, compute(kShared / "bad/43_far_from_origin.msh", far), 16.0 * kDouble * far);
}

/// The two files number their nodes otherwise, and the twin's coordinates went through float: of 20 times an edge.
TEST_F(SameTables, TheTurnedElbow) {
    const double low = lowest_tenth_m(read_mesh(kShared / "elbow_1823.mesh", 1.0));
    const Tables elbow = compute(kShared / "elbow_1823.mesh", low);
    const Tables twin = compute(kShared / "elbow2_inverted_1823.mesh", low);
    ASSERT_GT(elbow.node_id.size(), 600U);
    ASSERT_EQ(elbow.node_id.size(), twin.node_id.size());
    const auto place_of = [](const Tables& tables, std::size_t i) {
        return Eigen::Vector3d(tables.position[static_cast<std::size_t>(tables.node_id[i])].data());
    };
    for (std::size_t i = 0; i < elbow.node_id.size(); ++i) {
        std::size_t j = 0;
        while (j < twin.node_id.size() && (place_of(elbow, i) - place_of(twin, j)).norm() >= 1e-6) ++j;
        ASSERT_LT(j, twin.node_id.size()) << "no node at " << place_of(elbow, i).transpose();
        const auto &s = elbow.stiffness[i], &t = twin.stiffness[j];
        for (std::size_t k = 0; k < 9; ++k)
            EXPECT_WITHIN(std::abs(s[k] - t[k]), .epsilon = kFloat, .condition = 20.0, .size = s[0] + s[4] + s[8]);
    }
}

/// The locale decides how the C library reads numbers: no reader may ask it.
TEST_F(SameTables, ACommaLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    const Tables plain = compute(kShared / "bad/00_good_base.msh");
    const Tables vega = compute(kShared / "turtle_347.veg", 0.0);
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) {
        const std::string made = (folder_.path() / "locale").string();
        const std::string command = "localedef -i de_DE -f UTF-8 " + made + "/de_DE.UTF-8";
        fs::create_directories(made);
        setenv("LOCPATH", made.c_str(), 1);
        if (run(command).status != 0 || std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr) {
            unsetenv("LOCPATH");
            GTEST_SKIP() << "no locale with decimal commas can be made here";
        }
    }
    ASSERT_STREQ(std::localeconv()->decimal_point, ",");
    expect_same(plain, compute(kShared / "bad/00_good_base.msh"), 0.0);
    expect_same(vega, compute(kShared / "turtle_347.veg", 0.0), 0.0);
    std::setlocale(LC_ALL, before.c_str());
    unsetenv("LOCPATH");
}

}  // namespace
}  // namespace haptable::test
