// SPDX-License-Identifier: GPL-2.0-or-later
// How stiff a body is under a mask, against the body itself: 27-node bricks with a pressure in each, on a graded grid.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "host/bench/error/bricks.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/mask.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

const Vector3d kMiddle(0.015, 0.015, 0.03);  // of the cube's top

/// N/m of the cube itself, a quarter of it.
double stiffness_of_the_body(double radius_m, double poisson) {
    const auto across = graded_planes(0.015, 0.03, 0.015, 0.0225, 6, 2);
    const Box quarter{{across, across, graded_planes(0.0, 0.03, 0.0225, 0.03, 4, 3)}, true};
    const Footprint pad{kMiddle, radius_m};
    return 1.0 / brick_compliances(quarter, Lame::from_young(1e4, poisson), std::span(&pad, 1))[0](2, 2);
}

/// N/m of 9 corners a side under the mask that stands on the middle.
double stiffness_of_quadratic(double radius_m, double poisson) {
    Scene scene = cube_scene(9, poisson, true);
    scene.mesh.element = Element::kQuadratic;
    const Body body = make_body(scene, make_mesh(scene.mesh));
    Workers alone(1);
    Progress quiet(true);
    const Masks masks = make_masks(body.mesh.position_m, body.touch_patch, radius_m, alone, quiet, body.touch_quarter);
    LoadShares shares;
    for (std::size_t v = 0; v < masks.vertex_id.size(); ++v) {
        if ((body.mesh.position_m[static_cast<std::size_t>(masks.vertex_id[v])] - kMiddle).norm() > 1e-9) continue;
        for (std::size_t k = 0; k < masks.vertex[v].node.size(); ++k)
            shares[masks.vertex[v].node[k]] = masks.vertex[v].weight[k];
    }
    CholmodInverse inverse(1);
    const Stiffness k = assemble_free(scene, body);
    inverse.analyse(k, {{}, {}, {}, false, 3});
    inverse.factorize(k, quiet);
    return compliances(inverse, std::span(&shares, 1), body.unknown)[0].inverse()(2, 2);
}

// A finger of little more than an edge: 3.75 mm between corners. With all of lambda in the elements (C3D10) a pressure
// that is integrated exactly meets 6.4 % too much at a ratio of 0.3, for the mesh is too coarse: half of that is
// allowed.
TEST(MaskStiffness, OfQuadraticTetrahedraIsTheBodysWhereAFingerIsAsWideAsTwoEdges) {
    for (const auto& [radius_m, poisson] : {std::pair{0.004, 0.3}, {0.005, 0.3}, {0.004, 0.4999}}) {
        const double body = stiffness_of_the_body(radius_m, poisson);
        EXPECT_NEAR(stiffness_of_quadratic(radius_m, poisson) / body, 1.0, 0.032)
            << "nu " << poisson << ", " << radius_m << " m: " << body << " N/m";
    }
}

}  // namespace
}  // namespace haptable::test
