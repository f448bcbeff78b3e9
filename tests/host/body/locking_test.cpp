// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/locking.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "host/body/assembly.hpp"
#include "host/mesh/cube.hpp"
#include "tests/bodies.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

// Masks on the cube of 30 mm against the body itself (hexahedra of 27 nodes, refined), by Poisson's ratio, nodes a
// side, radius in mm.
struct Measured {
    double poisson;
    int nodes;
    double radius_mm, locking;
};
constexpr Measured kMeasured[] = {{0.45, 13, 5.0, 0.052},  {0.49, 9, 5.0, 0.290},   {0.49, 13, 5.0, 0.167},
                                  {0.49, 17, 5.0, 0.111},  {0.49, 25, 5.0, 0.064},  {0.49, 9, 7.5, 0.160},
                                  {0.49, 17, 7.5, 0.064},  {0.499, 13, 5.0, 0.386}, {0.4999, 9, 5.0, 0.76},
                                  {0.4999, 13, 5.0, 0.56}, {0.4999, 25, 5.0, 0.34}, {0.4999, 13, 7.5, 0.336}};

TEST(Locking, IsForeseenWithinAFourth) {
    for (const Measured& m : kMeasured) {
        Scene scene = test::cube_scene(m.nodes, m.poisson);
        scene.contact.mask_radius_m = 1e-3 * m.radius_mm;
        EXPECT_NEAR(foresee_locking(scene, make_mesh(scene.mesh)).excess / m.locking, 1.0, 0.25)
            << m.poisson << ' ' << m.nodes << ' ' << m.radius_mm;
    }
}

/// The cube with its inner nodes moved by a fifth of an edge: its grid is kinder than most.
Body uneven_body(const Scene& scene) {
    TetMesh mesh = make_cube(6, 0.03);
    for (std::size_t i = 0; i < mesh.position_m.size(); ++i) {
        Eigen::Vector3d& x = mesh.position_m[i];
        if (x.minCoeff() < 0.003 || x.maxCoeff() > 0.027) continue;
        for (int c = 0; c < 3; ++c) x[c] += 0.0012 * std::sin(double(7 * i) + 2.0 * c);
    }
    return make_body(scene, std::move(mesh));
}

/// Shares of the nodes in a pad of (1 - r^2 / R^2)^2, node by node, of the patches that face its way.
Eigen::VectorXd pad_at(const Body& body, std::int32_t node, const Eigen::Vector3d& outward, double radius_m) {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(Eigen::Index{3} * std::ssize(body.free_node));
    double sum = 0.0;
    for (std::size_t j = 0; j < body.mesh.position_m.size(); ++j) {
        const double q =
            (body.mesh.position_m[j] - body.mesh.position_m[std::size_t(node)]).squaredNorm() / (radius_m * radius_m);
        double area = 0.0;
        for (const Patch& p : body.touch_patch) {
            if (std::find(p.begin(), p.end(), std::int32_t(j)) == p.end()) continue;
            const auto at = [&](std::size_t c) { return body.mesh.position_m[std::size_t(p[c])]; };
            const Eigen::Vector3d twice = (at(1) - at(0)).cross(at(2) - at(0));
            if (twice.dot(outward) > 0.0) area += twice.norm() / 6.0;
        }
        if (q >= 1.0 || area == 0.0) continue;
        sum += area * (1.0 - q) * (1.0 - q);
        if (body.unknown[j] >= 0)
            load.segment<3>(Eigen::Index{3} * body.unknown[j]) = area * (1.0 - q) * (1.0 - q) * outward;
    }
    return load / sum;
}

/// The compliance of pads by nodal pressures over that of linear tetrahedra, less 1: the most of five.
double locking_of_pads(const Scene& scene, const Body& body, const Eigen::MatrixXd& linear) {
    Scene other = scene;
    other.mesh.element = Element::kAverageNodalPressure;
    const test::DenseInverse averaged(other, body);
    double most = 0.0;
    for (const FingerLoad& finger : fingers_on(body, {})) {
        const Eigen::VectorXd w = pad_at(body, finger.load.node[0], finger.outward, scene.contact.mask_radius_m);
        most = std::max(most, w.dot(averaged.l * w) / w.dot(linear * w));
    }
    return most - 1.0;
}

TEST(Locking, IsMeasuredFromBelowOnTheBodyItself) {
    double last = 0.0;
    for (const auto& [poisson, short_by] : {std::pair{0.45, 0.01}, {0.49, 0.01}, {0.499, 0.02}, {0.4999, 0.1}}) {
        SCOPED_TRACE(poisson);
        Scene scene = test::cube_scene(6, poisson);
        scene.contact.mask_radius_m = 0.01;
        const Body body = uneven_body(scene);
        const test::DenseInverse linear(scene, body);
        const Locking found = measure_locking(scene, body, {}, linear);
        const double known = locking_of_pads(scene, body, linear.l);
        EXPECT_EQ(found.places, 5U);
        EXPECT_EQ(found.finger_radius_m, 0.01);
        // 180 free nodes; K's condition grows with lambda over mu.
        const double rounding = 64.0 * test::kDouble * 180.0 * 1e3 / (1.0 - 2.0 * poisson);
        EXPECT_LE(found.excess, known * (1.0 + rounding));
        EXPECT_GE(found.excess, known * (1.0 - short_by));
        EXPECT_GT(found.excess, last) << "the nearer to 0.5, the more";
        last = found.excess;
    }
}

TEST(Locking, OfElementsThatDoNotLockIsNone) {
    Scene scene = test::cube_scene(6, 0.3);
    const Body body = uneven_body(scene);
    EXPECT_EQ(measure_locking(scene, body, {}, test::DenseInverse(scene, body)).excess, 0.0);
    scene.material.poisson = 0.499;
    scene.mesh.element = Element::kAverageNodalPressure;
    EXPECT_EQ(measure_locking(scene, body, {}, test::DenseInverse(scene, body)).excess, 0.0);
}

TEST(Locking, IsWarnedOfOnlyWhereItIsFelt) {
    const auto warnings = [](double poisson, int nodes, Element element) {
        Scene scene = test::cube_scene(nodes, poisson);
        scene.mesh.element = element;
        return locking_warnings(scene, foresee_locking(scene, make_mesh(scene.mesh)));
    };
    EXPECT_EQ(warnings(0.3, 5, Element::kLinear).size(), 0U);
    EXPECT_EQ(warnings(0.45, 33, Element::kLinear).size(), 0U);
    EXPECT_EQ(warnings(0.49, 13, Element::kLinear).size(), 1U);
    EXPECT_EQ(warnings(0.4999, 13, Element::kAverageNodalPressure).size(), 0U);
    Scene scene = test::cube_scene(5, 0.3);
    scene.regions.push_back({{}, {1e5, 0.499}});
    EXPECT_EQ(locking_warnings(scene, foresee_locking(scene, make_mesh(scene.mesh))).size(), 1U)
        << "a region's Poisson's ratio";
}

}  // namespace
}  // namespace haptable
