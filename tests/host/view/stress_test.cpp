// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/stress.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/base/file.hpp"
#include "host/precompute/precompute.hpp"
#include "tests/error_of.hpp"
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
    const Corners corners = kCorner;
    Eigen::Matrix<float, 12, 1> u;
    for (int c = 0; c < 4; ++c) u.segment<3>(3 * c) = (a * kCorner[std::size_t(c)]).cast<float>();
    // mu 2000 Pa, and lambda 1000 times as large, which must not matter.
    return von_mises(deviator_map(isotropic_hooke({2e6, 2000.0}), tet_geometry(corners).gradient_per_m) * u);
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

constexpr const char* kAll = "[tables]\ncolumns = \"all\"\n";
const std::string kIsotropic = "young = 1e4\npoisson = 0.3\n";

class ViewStressOfTables : public testing::Test {
protected:
    /// A cube of 30 mm, held at z = 0. material: lines of [material]; more: tables behind it.
    Tables tables(const std::string& more, const std::string& material = kIsotropic,
                  const std::string& element = "linear") {
        write_file(folder_.path() / "a.toml",
                   "name = \"a\"\n[mesh]\ngenerate = \"cube\"\nnodes_per_side = 4\nside = 0.03\nelement = \"" +
                       element + "\"\n[material]\n" + material + "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 1e-9]\n" + more);
        Progress silent(true);
        precompute(read_scene(folder_.path() / "a.toml"), folder_.path() / "a", silent);
        return read_tables(folder_.path() / "a");
    }

    template <typename Field>
    std::vector<float> stress_of(const Tables& t, const DrawnSurface& surface, const Field& field) const {
        std::vector<float> u, found;
        for (const std::int32_t node : t.row_id)
            for (const double x : Vector3d(field(at_m(t, node)))) u.push_back(float(x));
        SurfaceStress(t, folder_.path() / "a", surface).find(u, found);
        return found;
    }

    /// What is found where all nodes are displaced by `field`, which is 0 at z = 0, against `wanted` at each node, Pa.
    template <typename Field, typename Wanted>
    void expect_stress(const Tables& t, const Field& field, const Wanted& wanted) {
        const DrawnSurface surface(t);
        const std::vector<float> found = stress_of(t, surface, field);
        ASSERT_EQ(found.size(), surface.nodes());
        double largest = 0.0;
        for (const std::int32_t node : surface.node_id) largest = std::max(largest, double(wanted(at_m(t, node))));
        for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_WITHIN(std::abs(found[i] - wanted(at_m(t, surface.node_id[i]))), .count = 256, .epsilon = kFloat,
                          .condition = 10.0, .size = largest)
                << at_m(t, surface.node_id[i]).transpose();
    }

    static Vector3d at_m(const Tables& t, std::int32_t node) { return Vector3d(t.position[std::size_t(node)].data()); }
    TemporaryFolder folder_;
};

double von_mises_of(const Matrix3d& stress) {
    const Matrix3d deviator = stress - stress.trace() / 3.0 * Matrix3d::Identity();
    return std::sqrt(1.5) * deviator.norm();
}

// All nodes moved by shear, the fixed ones with the shear that they have at z = 0: none. So every element has it. What
// average nodal pressure averages has no part in it.
TEST_F(ViewStressOfTables, IsThatOfTheFieldAtEveryNodeWhateverTheElement) {
    for (const char* element : {"linear", "average-nodal-pressure", "quadratic"})
        expect_stress(
            tables(kAll, kIsotropic, element), [](const Vector3d& x) { return Vector3d(0.02 * x.z(), 0, 0); },
            [](const Vector3d&) { return std::sqrt(3.0) * 1e4 / 2.6 * 0.02; });
}

// Quadratic elements have a shear that grows with z, exactly, at their corners and between them.
TEST_F(ViewStressOfTables, GrowsWithinAQuadraticElement) {
    expect_stress(
        tables(kAll, kIsotropic, "quadratic"), [](const Vector3d& x) { return Vector3d(x.z() * x.z(), 0, 0); },
        [](const Vector3d& x) { return std::sqrt(3.0) * 1e4 / 2.6 * 2.0 * x.z(); });
}

// Stretched by e along z and by nothing across, with fibres along 1 that lie oblique to z: stress by the inverse of the
// compliances, each strain turned by hand.
TEST_F(ViewStressOfTables, OfFibresIsThatOfTheirOwnLaw) {
    const std::string law =
        "law = \"fibre\"\nyoung_along = 3e4\nyoung_across = 1e4\npoisson = 0.25\npoisson_across = 0.4\nshear = 6e3\n";
    constexpr double kAlong = 3e4, kAcross = 1e4, kNu = 0.25, kNuAcross = 0.4, kShear = 6e3, kStretch = 0.02;
    for (const double degrees : {0.0, 30.0, 90.0}) {
        const double c = std::cos(degrees * M_PI / 180.0), s = std::sin(degrees * M_PI / 180.0);
        // Along (s, 0, c): direction 1; 2 is y.
        Matrix3d axes, strain = Matrix3d::Zero(), compliance;
        axes.col(0) = Vector3d(s, 0, c), axes.col(1) = Vector3d(0, 1, 0), axes.col(2) = axes.col(0).cross(axes.col(1));
        strain(2, 2) = kStretch;
        const Matrix3d own = axes.transpose() * strain * axes;
        compliance << 1 / kAlong, -kNu / kAlong, -kNu / kAlong, -kNu / kAlong, 1 / kAcross, -kNuAcross / kAcross,
            -kNu / kAlong, -kNuAcross / kAcross, 1 / kAcross;
        const Vector3d normal = compliance.inverse() * Vector3d(own.diagonal());
        Matrix3d stress = normal.asDiagonal();
        stress(0, 2) = stress(2, 0) = 2.0 * kShear * own(0, 2);
        const double wanted = von_mises_of(stress);
        for (const char* element : {"linear", "quadratic"})
            expect_stress(
                tables(kAll, law + fmt::format("direction = [{}, 0, {}]\n", s, c), element),
                [](const Vector3d& x) { return Vector3d(0, 0, kStretch * x.z()); },
                [&](const Vector3d&) { return wanted; });
    }
}

// The upper third is four times as stiff; a node of both has the mean of its elements, which lies between.
TEST_F(ViewStressOfTables, OfRegionsIsTheirOwnMaterials) {
    const Tables t =
        tables(std::string("[[region]]\nbox = [-1, -1, 0.0199, 1, 1, 1]\nyoung = 4e4\npoisson = 0.3\n") + kAll);
    const double lower = std::sqrt(3.0) * 1e4 / 2.6 * 0.02;
    const DrawnSurface surface(t);
    const std::vector<float> found =
        stress_of(t, surface, [](const Vector3d& x) { return Vector3d(0.02 * x.z(), 0, 0); });
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double z = at_m(t, surface.node_id[i]).z();
        if (std::abs(z - 0.02) < 1e-6) {
            EXPECT_GT(found[i], 1.1 * lower);
            EXPECT_LT(found[i], 3.9 * lower);
            continue;
        }
        const double wanted = (z > 0.02 ? 4.0 : 1.0) * lower;
        EXPECT_WITHIN(std::abs(found[i] - wanted), .count = 256, .epsilon = kFloat, .condition = 10.0, .size = wanted);
    }
}

TEST_F(ViewStressOfTables, SaysWhatIsInTheWay) {
    const Tables t = tables("");
    EXPECT_TRUE(fails_with([&] { SurfaceStress(t, folder_.path() / "a", DrawnSurface(t)); }, "columns = \"all\""));
}

}  // namespace
}  // namespace haptable::test
