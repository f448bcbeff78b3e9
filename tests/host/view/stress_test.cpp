// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/stress.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/precompute/precompute.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::array<Vector3d, 4> kCorner{Vector3d(0.01, 0.002, 0.0), Vector3d(0.013, 0.0, 0.001),
                                      Vector3d(0.011, 0.005, -0.001), Vector3d(0.012, 0.002, 0.004)};

/// Of the homogeneous deformation u = A x.
float of(const Matrix3d& a) {
    Eigen::Matrix<float, 3, 4> u;
    for (int c = 0; c < 4; ++c) u.col(c) = (a * kCorner[static_cast<std::size_t>(c)]).cast<float>();
    return von_mises(2000.0F, shape_gradients(kCorner), u);
}

// Displacements of 10 mm times the strain, over edges of some 4 mm.
constexpr Bound kStress{.count = 64, .epsilon = kFloat, .condition = 10.0, .size = 2000.0};

// Of plane shear gamma it is sqrt(3) mu gamma, of a stretch e and -nu e across 3 mu e 2 (1 + nu) / 3; a turn and a
// change of volume have none.
TEST(ViewStress, OfKnownDeformations) {
    Matrix3d shear = Matrix3d::Zero();
    shear(0, 1) = 0.1;
    EXPECT_WITHIN(std::abs(of(shear) - std::sqrt(3.0) * 2000.0 * 0.1), kStress);
    const double nu = 0.3, stretch = 0.05;
    const Matrix3d pulled = Vector3d(stretch, -nu * stretch, -nu * stretch).asDiagonal();
    EXPECT_WITHIN(std::abs(of(pulled) - 2000.0 * 2.0 * (1.0 + nu) * stretch), kStress);
    EXPECT_WITHIN(of(0.1 * Matrix3d::Identity()), kStress);
    Matrix3d turn = Matrix3d::Zero();
    turn(0, 1) = 0.1, turn(1, 0) = -0.1;
    EXPECT_WITHIN(of(turn), kStress);
}

class ViewStressOfTables : public testing::Test {
protected:
    Tables tables(const std::string& more) {
        write_file(folder_.path() / "a.toml",
                   "name = \"a\"\n[mesh]\ngenerate = \"cube\"\nnodes_per_side = 4\nside = 0.03\n[material]\nyoung = "
                   "1e4\npoisson = 0.3\n[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n" +
                       more);
        Progress silent(true);
        precompute(read_scene(folder_.path() / "a.toml"), folder_.path() / "a", silent);
        return read_tables(folder_.path() / "a");
    }
    TemporaryFolder folder_;
};

// All nodes moved by shear, the fixed ones with the shear that they have at z = 0: none. So every element has it.
TEST_F(ViewStressOfTables, IsThatOfTheFieldAtEveryNode) {
    const Tables t = tables("[tables]\ncolumns = \"all\"\n");
    const DrawnSurface surface(t);
    const SurfaceStress stress(t, folder_.path() / "a", surface);
    std::vector<float> u;
    for (const std::int32_t node : t.row_id)
        u.insert(u.end(), {static_cast<float>(0.02 * t.position[static_cast<std::size_t>(node)][2]), 0.0F, 0.0F});
    std::vector<float> found;
    stress.find(u, found);
    ASSERT_EQ(found.size(), surface.nodes());
    const double wanted = std::sqrt(3.0) * 1e4 / 2.6 * 0.02;
    for (const float s : found)
        EXPECT_WITHIN(std::abs(s - wanted), .count = 256, .epsilon = kFloat, .condition = 10.0, .size = wanted);
}

TEST_F(ViewStressOfTables, SaysWhatIsInTheWay) {
    const auto error = [&](const std::string& more) {
        const Tables t = tables(more);
        try {
            const SurfaceStress stress(t, folder_.path() / "a", DrawnSurface(t));
        } catch (const Error& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_NE(error("").find("columns = \"all\""), std::string::npos);
    EXPECT_EQ(error("[tables]\ncolumns = \"all\"\n"), "");
}

}  // namespace
}  // namespace haptable::test
