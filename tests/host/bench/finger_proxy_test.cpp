// SPDX-License-Identifier: GPL-2.0-or-later
// The finger proxy that the bench times beside the servo: it does what it is compared for.
#include "host/bench/proxy/finger_proxy.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/shapes.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.03;           // m
constexpr double kRadius = 1e-4;         // m
constexpr double kGap = 0.03 * kRadius;  // three planes, a hundredth of the radius each

FingerProxy on(const Shape& shape) { return {shape.point, shape.patch, kRadius}; }

/// A finger that goes there in steps of at most a tenth of a millimetre, and stays.
Vector3d walk(FingerProxy& proxy, const Vector3d& from, const Vector3d& to) {
    const int steps = 1 + static_cast<int>((to - from).norm() / 1e-4);
    Vector3d at = from;
    for (int i = 0; i <= steps + 6; ++i) at = proxy.to(from + std::min(1.0, double(i) / steps) * (to - from));
    return at;
}

TEST(FingerProxy, IsTheFingerInFreeAir) {
    FingerProxy proxy = on(box_shape(4, Vector3d::Constant(kSide)));
    const Vector3d above(0.01, 0.02, kSide + 0.005);
    proxy.begin(above);
    EXPECT_EQ(proxy.to(above + Vector3d(0.001, 0, 0)), above + Vector3d(0.001, 0, 0));
}

// On one face it lies over the finger, in a concave crease over the line where two planes meet.
TEST(FingerProxy, RestsOnItsPlanes) {
    FingerProxy face = on(box_shape(4, Vector3d::Constant(kSide)));
    face.begin({0.01, 0.02, kSide + 0.001});
    Vector3d at = walk(face, {0.01, 0.02, kSide + 0.001}, {0.013, 0.012, kSide - 0.002});
    EXPECT_LT((at - Vector3d(0.013, 0.012, kSide + kRadius)).norm(), kGap);

    const Shape l = l_shape(4, kSide);  // the quarter beyond half the side in x and z is missing
    FingerProxy crease = on(l);
    const Vector3d out(0.8 * kSide, 0.4 * kSide, 0.8 * kSide), in(0.45 * kSide, 0.5 * kSide, 0.4 * kSide);
    crease.begin(out);
    at = walk(crease, out, in);
    EXPECT_LT((at - Vector3d(0.5 * kSide + kRadius, 0.5 * kSide, 0.5 * kSide + kRadius)).norm(), kGap);
}

// Random walks around and into a sphere: the proxy's sphere never enters a patch, and is no farther than the finger.
TEST(FingerProxy, NeverEnters) {
    const Shape shape = sphere_shape(3, kSide);
    FingerProxy proxy = on(shape);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    Vector3d x(0, 0, 1.1 * kSide);
    proxy.begin(x);
    int inside = 0;
    for (int tick = 0; tick < 20000; ++tick) {
        const Vector3d step = 2e-4 * Vector3d(normal(random), normal(random), normal(random));
        x += step - (x.norm() > 1.2 * kSide ? 1e-4 : 0.0) * x.normalized();
        const Vector3d& at = proxy.to(x);
        ASSERT_GT(at.norm(), 0.99 * kSide) << tick;  // an icosahedron divided thrice is within 0.7 % of the sphere
        inside += x.norm() < 0.99 * kSide ? 1 : 0;
    }
    EXPECT_GT(inside, 2000);
}

}  // namespace
}  // namespace haptable::test
