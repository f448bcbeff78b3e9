// SPDX-License-Identifier: GPL-2.0-or-later
// Displacements of all nodes against CalculiX, another program, on the same elements.
#include "host/bench/error/calculix.hpp"

#include <gtest/gtest.h>

#include "host/inverse/factor.hpp"
#include "host/precompute/assembly.hpp"
#include "tests/bodies.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Largest difference, as a share of the largest displacement, under an oblique force on one node of the surface and
/// another on a second one: a corner and a middle where there are some.
double difference(const Scene& scene) {
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const auto& free = body.free_surface_node;
    const Vector3d force(0.03, -0.02, -0.09);
    const NodalForces load{{free[free.size() / 3], force}, {free[5 * free.size() / 6], -0.4 * force}};
    std::vector<std::vector<std::int32_t>> elements(body.mesh.tet.size());
    for (std::size_t t = 0; t < elements.size(); ++t)
        for_each_node(body.mesh, t, [&](std::int32_t node) { elements[t].push_back(node); });
    std::vector<std::int32_t> held;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(body.unknown.size()); ++i)
        if (body.is_fixed(i)) held.push_back(i);
    const TemporaryFolder folder;
    const auto theirs =
        run_calculix({body.mesh.position_m, elements, held, scene.material}, std::span(&load, 1), folder.path())
            .front();
    const Factor factor(assemble_free(scene, body));
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(factor.size(), 1), u;
    for (const auto& [node, f] : load) b.block<3, 1>(Eigen::Index{3} * body.unknown[std::size_t(node)], 0) = f;
    factor.solve(b, u);
    double off = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < theirs.size(); ++i) {
        const Vector3d ours = body.is_fixed(std::int32_t(i))
                                  ? Vector3d::Zero().eval()
                                  : u.block<3, 1>(Eigen::Index{3} * body.unknown[i], 0).eval();
        off = std::max(off, (ours - theirs[i]).norm());
        largest = std::max(largest, theirs[i].norm());
    }
    return off / largest;
}

class CalculiX : public testing::Test {
protected:
    void SetUp() override {
        if (run("command -v ccx").status != 0) GTEST_SKIP() << "no ccx: sh scripts/setup.sh test";
    }
};

// CalculiX prints seven digits: of each component 5e-7 of itself at the most.
constexpr double kPrinted = 1e-6;

TEST_F(CalculiX, LinearTetrahedra) {
    Scene scene = cube_scene(5, 0.49);
    EXPECT_LT(difference(scene), kPrinted);
}

TEST_F(CalculiX, QuadraticTetrahedraUpToPoissonsRatioThreeTenths) {
    for (double poisson : {0.0, 0.3}) {
        Scene scene = cube_scene(5, poisson);
        scene.mesh.element = Element::kQuadratic;
        EXPECT_LT(difference(scene), kPrinted) << "nu = " << poisson;
    }
    Scene scene = mouse_scene();
    scene.mesh.element = Element::kQuadratic;
    scene.material.poisson = 0.3;
    EXPECT_LT(difference(scene), kPrinted) << "mouse";
}

TEST_F(CalculiX, QuadraticTetrahedraThatAverageAboveItAreSofter) {
    Scene scene = cube_scene(5, 0.49);
    scene.mesh.element = Element::kQuadratic;
    EXPECT_GT(difference(scene), 100.0 * kPrinted);
}

// A ball of curved tetrahedra, as its file has them.
TEST_F(CalculiX, CurvedTetrahedra) {
    Scene scene;
    scene.file = "ball.toml";
    scene.name = "ball";
    scene.mesh.element = Element::kQuadratic;
    scene.mesh.file = "../shared/meshes/sphere_p2_1310.msh";
    if (!std::filesystem::exists(scene.mesh.file)) GTEST_SKIP() << "no ../shared/meshes";
    scene.material = {1e4, 0.3};
    const TetMesh mesh = make_mesh(scene.mesh);
    double low = 1e9, high = -1e9;
    for (const Vector3d& x : mesh.position_m) {
        low = std::min(low, x.z());
        high = std::max(high, x.z());
    }
    scene.fixed.push_back({std::array<double, 6>{-1e3, -1e3, -1e3, 1e3, 1e3, low + 0.1 * (high - low)}, "", 1});
    EXPECT_LT(difference(scene), kPrinted);
}

}  // namespace
}  // namespace haptable::test
