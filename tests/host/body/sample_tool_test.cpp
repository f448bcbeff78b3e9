// SPDX-License-Identifier: GPL-2.0-or-later
// Sampled tools press into a half-space as Hertz and Boussinesq have it.
#include "host/body/sample_tool.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <numbers>

#include "host/dense/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using Kind = ToolShape::Kind;

/// Depth of one mask (1 - r^2 / rho^2)^2 under a unit load of another, `distance` / rho away, times pi E* rho:
/// the masks' Hankel transforms are 48 J3(k) / k^3, that of 1 / r is 1 / k.
double coupled(double distance) {
    constexpr double kStep = 0.1, kEnd = 20.0;  // what is beyond is below 1e-6
    double sum = 0.0;
    for (double k = 0.5 * kStep; k < kEnd; k += kStep) {
        const double mask = 48.0 * std::cyl_bessel_j(3.0, k) / (k * k * k);
        sum += kStep * mask * mask * std::cyl_bessel_j(0.0, k * distance);
    }
    return sum;
}

/// A half-space with E* = 1 under points' masks, without friction.
class HalfSpace {
public:
    HalfSpace(const std::vector<Eigen::Vector3d>& point, double mask_radius) {
        const auto n = Eigen::Index(point.size());
        compliance_.resize(n, n);
        for (Eigen::Index i = 0; i < n; ++i)
            for (Eigen::Index j = 0; j <= i; ++j) {
                const Eigen::Vector3d away = point[std::size_t(i)] - point[std::size_t(j)];
                compliance_(i, j) = compliance_(j, i) =
                    coupled(std::hypot(away.x(), away.y()) / mask_radius) / (std::numbers::pi * mask_radius);
            }
    }

    /// The loads of those that press: the others' surface is deeper than they are.
    Eigen::VectorXd press(const Eigen::VectorXd& depth) const {
        std::vector<Eigen::Index> in;
        for (Eigen::Index i = 0; i < depth.size(); ++i)
            if (depth[i] > 0.0) in.push_back(i);
        for (;;) {
            Eigen::VectorXd load = Eigen::VectorXd::Zero(depth.size());
            if (in.empty()) return load;
            load(in) = solve_spd(compliance_(in, in), depth(in));
            Eigen::Index least = 0;
            if (load.minCoeff(&least) >= 0.0) return load;
            std::erase(in, least);
        }
    }

private:
    Eigen::MatrixXd compliance_;
};

double mask_of(const ToolShape& shape, double share) { return share * sample_tool(shape, 0.0).spacing_m; }

TEST(ToolSample, FlatPunchAndItsTilt) {
    constexpr double kRadius = 0.006, kTilt = 0.02;
    for (const int count : {8, 10, 12, 14, 16, 19, 24, 32}) {
        const ToolShape shape{.kind = Kind::kDisc, .points = count, .radius_m = kRadius};
        const double mask_radius = mask_of(shape, 0.7);
        const ToolSample sample = sample_tool(shape, mask_radius);
        ASSERT_EQ(sample.point_m.size(), std::size_t(count));
        const HalfSpace body(sample.point_m, mask_radius);
        const Eigen::VectorXd flat = Eigen::VectorXd::Constant(count, 1e-3);
        const Eigen::VectorXd load = body.press(flat);
        EXPECT_NEAR(load.sum() / (2.0 * kRadius * 1e-3), 1.0, 0.05) << count;
        for (const auto& across : {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()}) {
            Eigen::VectorXd arm(count);
            for (Eigen::Index i = 0; i < count; ++i) arm[i] = sample.point_m[std::size_t(i)].dot(across);
            const double moment = arm.dot(body.press(flat + kTilt * arm) - load);
            EXPECT_NEAR(moment / (4.0 / 3.0 * std::pow(kRadius, 3) * kTilt), 1.0, 0.05) << count;
        }
    }
}

TEST(ToolSample, SphereIsHertzFromFivePointsOn) {
    const ToolShape shape{.kind = Kind::kSphere, .points = 19, .radius_m = 0.01, .angle_deg = 35.0};
    const double mask_radius = mask_of(shape, 0.8);
    const ToolSample sample = sample_tool(shape, mask_radius);
    const HalfSpace body(sample.point_m, mask_radius);
    double before = 0.0;
    for (double depth = 0.8e-3; depth < 3e-3; depth += 0.1e-3) {
        Eigen::VectorXd depths(19);
        for (Eigen::Index i = 0; i < 19; ++i) depths[i] = depth - shape.radius_m - sample.point_m[std::size_t(i)].z();
        const Eigen::VectorXd load = body.press(depths);
        const double hertz = 4.0 / 3.0 * std::sqrt(shape.radius_m) * std::pow(depth, 1.5);
        const bool is_sampled = (load.array() > 0.0).count() >= 5;
        EXPECT_NEAR(load.sum() / hertz, 1.0, is_sampled ? 0.06 : 0.2) << depth;
        // Points come to touch one after the other: no step.
        EXPECT_GT(load.sum(), before);
        before = load.sum();
    }
}

/// Every point of a curved shape lies within it by the mask's mean of its profile.
TEST(ToolSample, StandsBackByTheMasksMean) {
    const ToolShape sphere{.kind = Kind::kSphere, .points = 16, .radius_m = 0.01, .angle_deg = 60.0};
    for (const Eigen::Vector3d& p : sample_tool(sphere, 0.004).point_m) {
        EXPECT_NEAR(p.norm(), 0.01 - 0.004 * 0.004 / (8.0 * 0.01), 1e-12);
        EXPECT_LE(std::acos(-p.z() / p.norm()), 60.0 * std::numbers::pi / 180.0);
    }
    const ToolShape capsule{
        .kind = Kind::kCapsule, .points = 16, .radius_m = 0.004, .length_m = 0.03, .angle_deg = 30.0};
    double longest = 0.0;
    for (const Eigen::Vector3d& p : sample_tool(capsule, 0.003).point_m) {
        const Eigen::Vector3d from_axis = p - Eigen::Vector3d(std::clamp(p.x(), -0.015, 0.015), 0.0, 0.0);
        EXPECT_NEAR(from_axis.norm(), 0.004 - 0.003 * 0.003 / (16.0 * 0.004), 1e-12);
        longest = std::max(longest, p.x());
    }
    EXPECT_GT(longest, 0.015);  // the ends are sampled too
}

/// A square blade of 20 mm by 10 mm whose under side is its triangles 1 and 2; above it has a ridge.
constexpr const char* kBlade = R"(solid blade
facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 10 0 vertex 20 0 0 endloop endfacet
facet normal 0 0 -1 outer loop vertex 20 10 0 vertex 20 0 0 vertex 0 10 0 endloop endfacet
facet normal 0 0 1 outer loop vertex 0 0 0 vertex 20 0 0 vertex 10 5 4 endloop endfacet
facet normal 0 0 1 outer loop vertex 20 0 0 vertex 20 10 0 vertex 10 5 4 endloop endfacet
facet normal 0 0 1 outer loop vertex 20 10 0 vertex 0 10 0 vertex 10 5 4 endloop endfacet
facet normal 0 0 1 outer loop vertex 0 10 0 vertex 0 0 0 vertex 10 5 4 endloop endfacet
endsolid blade
)";

class ToolSampleOfMesh : public ::testing::Test {
protected:
    ToolShape blade(const std::string& text = kBlade) {
        std::ofstream(folder_.path() / "blade.stl") << text;
        return {.kind = Kind::kMesh, .points = 12, .file = folder_.path() / "blade.stl", .scale_m = 0.001};
    }
    TemporaryFolder folder_;
};

TEST_F(ToolSampleOfMesh, UnderSideAndItsBorder) {
    const ToolSample sample = sample_tool(blade(), 0.003);
    EXPECT_NEAR(sample.spacing_m, std::sqrt(2.0 * 200e-6 / (std::sqrt(3.0) * 12)), 1e-9);
    ASSERT_EQ(sample.point_m.size(), 12U);
    EXPECT_EQ(sample.point_m, sample_tool(blade(), 0.003).point_m) << "the same input, the same points";
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& p : sample.point_m) {
        box.extend(p);
        EXPECT_NEAR(p.z(), 0.0, 1e-12);  // flat: no point stands back
        for (const Eigen::Vector3d& q : sample.point_m)
            EXPECT_TRUE(&p == &q || (p - q).norm() > 0.5 * sample.spacing_m);
    }
    const double inset = 0.265 * sample.spacing_m;
    EXPECT_GE(box.min().x(), inset - 1e-9);
    EXPECT_NEAR(box.min().x(), inset, 0.0006);
    EXPECT_NEAR(box.max().x(), 0.02 - inset, 0.0006);
    EXPECT_NEAR(box.min().y(), inset, 0.0006);
    EXPECT_NEAR(box.max().y(), 0.01 - inset, 0.0006);
}

TEST_F(ToolSampleOfMesh, SaysWhatIsWrong) {
    ToolShape turned = blade();
    turned.angle_deg = 10.0;
    EXPECT_NO_THROW(sample_tool(turned, 0.003));
    const std::string ridge =
        "solid ridge\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 20 0 0 vertex 10 5 4 endloop endfacet\n"
        "endsolid ridge\n";
    EXPECT_TRUE(fails_with([&] { sample_tool(blade(ridge), 0.003); },
                           "blade.stl: none of its 1 triangles faces along -z within 60 degrees"));
    const ToolShape missing{.kind = Kind::kMesh, .file = folder_.path() / "none.stl"};
    EXPECT_TRUE(fails_with([&] { sample_tool(missing, 0.003); }, "none.stl"));
}

}  // namespace
}  // namespace haptable::test
