// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/stress.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/precompute/precompute.hpp"
#include "tests/bodies.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSize = 0.02;  // of a displacement's gradient
const Material kIsotropic{1e4, 0.3};
constexpr double kShear_pa = 1e4 / 2.6;

/// A cube of 30 mm that nothing holds: every node has a row.
Scene free_cube(const Material& material, Element element = Element::kLinear) {
    Scene scene = cube_of("cube", 4, material, element);
    set_free(scene);
    scene.tables.columns = ColumnRows::kAll;
    return scene;
}

class ViewStress : public testing::Test {
protected:
    void make(const Scene& scene) {
        Progress quiet(true);
        precompute(scene, folder_.path(), quiet, {.code = false});
        tables_ = read_tables(folder_.path());
    }
    Vector3d at_m(std::int32_t node) const { return Vector3d(tables_.position[std::size_t(node)].data()); }

    template <typename Field>
    std::vector<float> stress_of(const DrawnSurface& surface, const Field& field) const {
        std::vector<float> u, found;
        for (const std::int32_t node : tables_.row_id)
            for (const double x : Vector3d(field(at_m(node)))) u.push_back(float(x));
        SurfaceStress(tables_, folder_.path(), surface).find(u, found);
        return found;
    }
    /// What is found where all nodes are displaced by `field`, against `wanted` at each node, Pa; `size` of the
    /// largest.
    template <typename Field, typename Wanted>
    void expect_stress(const Field& field, const Wanted& wanted, double size) const {
        const DrawnSurface surface(tables_);
        const std::vector<float> found = stress_of(surface, field);
        ASSERT_EQ(found.size(), surface.nodes());
        for (std::size_t i = 0; i < found.size(); ++i) {
            const Vector3d x = at_m(surface.node_id[i]);
            EXPECT_WITHIN(std::abs(found[i] - wanted(x)), .count = 256, .epsilon = kFloat, .condition = 10.0,
                          .size = size)
                << x.transpose();
        }
    }

    const TemporaryFolder folder_;
    Tables tables_;
};

// Of plane shear gamma it is sqrt(3) mu gamma, of a stretch e and -nu e across 3 mu e 2 (1 + nu) / 3; a turn and a
// change of volume have none, though lambda is 1000 mu. What average nodal pressure averages has no part in it.
TEST_F(ViewStress, IsThatOfTheFieldAtEveryNodeWhateverTheElement) {
    const double mu_pa = 1e4 / 2.999, nu = 0.3;
    Matrix3d shear = Matrix3d::Zero();
    shear(0, 2) = kSize;
    const Matrix3d turn = shear - shear.transpose(), grown = kSize * Matrix3d::Identity(),
                   pulled = kSize * Vector3d(1.0, -nu, -nu).asDiagonal();
    for (const Element element : kElements) {
        make(free_cube({1e4, 0.4995}, element));
        for (const auto& [gradient, wanted_pa] : {std::pair(shear, std::sqrt(3.0) * mu_pa * kSize),
                                                  {pulled, 2.0 * mu_pa * (1.0 + nu) * kSize},
                                                  {turn, 0.0},
                                                  {grown, 0.0}}) {
            SCOPED_TRACE(testing::Message() << element << '\n' << gradient);
            expect_stress([&](const Vector3d& x) { return gradient * x; }, [&](const Vector3d&) { return wanted_pa; },
                          std::sqrt(3.0) * mu_pa * kSize);
        }
    }
}

// Quadratic elements have a shear that grows with z, exactly, at their corners and between them.
TEST_F(ViewStress, GrowsWithinAQuadraticElement) {
    make(free_cube(kIsotropic, Element::kQuadratic));
    const auto wanted_pa = [](const Vector3d& x) { return std::sqrt(3.0) * kShear_pa * 2.0 * x.z(); };
    expect_stress([](const Vector3d& x) { return Vector3d(x.z() * x.z(), 0, 0); }, wanted_pa,
                  wanted_pa({0, 0, kCubeSide_m}));
}

// Stretched by e along z and by nothing across, with fibres along 1 that lie oblique to z: stress by the inverse of the
// compliances, each strain turned by hand.
TEST_F(ViewStress, OfFibresIsThatOfTheirOwnLaw) {
    constexpr double kAlong = 3e4, kAcross = 1e4, kNu = 0.25, kNuAcross = 0.4, kShear = 6e3;
    for (const double degrees : {0.0, 30.0, 90.0}) {
        const double c = std::cos(degrees * M_PI / 180.0), s = std::sin(degrees * M_PI / 180.0);
        // Along (s, 0, c): direction 1; 2 is y.
        Matrix3d axes, strain = Matrix3d::Zero(), compliance;
        axes.col(0) = Vector3d(s, 0, c), axes.col(1) = Vector3d(0, 1, 0), axes.col(2) = axes.col(0).cross(axes.col(1));
        strain(2, 2) = kSize;
        const Matrix3d own = axes.transpose() * strain * axes;
        compliance << 1 / kAlong, -kNu / kAlong, -kNu / kAlong, -kNu / kAlong, 1 / kAcross, -kNuAcross / kAcross,
            -kNu / kAlong, -kNuAcross / kAcross, 1 / kAcross;
        const Vector3d normal = compliance.inverse() * Vector3d(own.diagonal());
        Matrix3d stress = normal.asDiagonal();
        stress(0, 2) = stress(2, 0) = 2.0 * kShear * own(0, 2);
        const Matrix3d deviator = stress - stress.trace() / 3.0 * Matrix3d::Identity();
        const double wanted_pa = std::sqrt(1.5) * deviator.norm();
        Material material = like(fibre(kAlong, kAcross, kNu, kNuAcross, kShear));
        material.orthotropic->axes.direction[0] = {s, 0, c};
        for (const Element element : {Element::kLinear, Element::kQuadratic}) {
            make(free_cube(material, element));
            expect_stress([&](const Vector3d& x) { return strain * x; }, [&](const Vector3d&) { return wanted_pa; },
                          wanted_pa);
        }
    }
}

// The upper third is four times as stiff; a node of both has the mean of its elements, which lies between.
TEST_F(ViewStress, OfRegionsIsTheirOwnMaterials) {
    Scene scene = free_cube(kIsotropic);
    scene.regions = {{box(-1, -1, 0.0199, 1, 1, 1), {4e4, 0.3}}};
    make(scene);
    const double lower = std::sqrt(3.0) * kShear_pa * kSize;
    const DrawnSurface surface(tables_);
    const std::vector<float> found =
        stress_of(surface, [](const Vector3d& x) { return Vector3d(kSize * x.z(), 0, 0); });
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double z = at_m(surface.node_id[i]).z();
        if (std::abs(z - 0.02) < 1e-6) {
            EXPECT_GT(found[i], 1.1 * lower);
            EXPECT_LT(found[i], 3.9 * lower);
            continue;
        }
        const double wanted = (z > 0.02 ? 4.0 : 1.0) * lower;
        EXPECT_WITHIN(std::abs(found[i] - wanted), .count = 256, .epsilon = kFloat, .condition = 10.0, .size = wanted);
    }
}

TEST_F(ViewStress, SaysWhatIsInTheWay) {
    Scene scene = free_cube(kIsotropic);
    scene.tables.columns = ColumnRows::kSurface;
    make(scene);
    EXPECT_TRUE(
        fails_with([&] { SurfaceStress(tables_, folder_.path(), DrawnSurface(tables_)); }, "columns = \"all\""));
}

}  // namespace
}  // namespace haptable::test
