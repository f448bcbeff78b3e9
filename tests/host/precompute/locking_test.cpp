// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/locking.hpp"

#include <gtest/gtest.h>

#include "tests/bodies.hpp"

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
        EXPECT_NEAR(expected_locking(scene, make_mesh(scene.mesh)) / m.locking, 1.0, 0.25)
            << m.poisson << ' ' << m.nodes << ' ' << m.radius_mm;
    }
}

TEST(Locking, IsWarnedOfOnlyWhereItIsFelt) {
    const auto warnings = [](double poisson, int nodes, Element element) {
        Scene scene = test::cube_scene(nodes, poisson);
        scene.mesh.element = element;
        return locking_warnings(scene, make_mesh(scene.mesh));
    };
    EXPECT_EQ(warnings(0.3, 5, Element::kLinear).size(), 0U);
    EXPECT_EQ(warnings(0.45, 33, Element::kLinear).size(), 0U);
    EXPECT_EQ(warnings(0.49, 13, Element::kLinear).size(), 1U);
    EXPECT_EQ(warnings(0.4999, 13, Element::kAverageNodalPressure).size(), 0U);
    Scene scene = test::cube_scene(5, 0.3);
    scene.regions.push_back({{}, {1e5, 0.499}});
    EXPECT_EQ(locking_warnings(scene, make_mesh(scene.mesh)).size(), 1U) << "a region's Poisson's ratio";
}

}  // namespace

}  // namespace haptable
