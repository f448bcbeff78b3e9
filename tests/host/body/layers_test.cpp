// SPDX-License-Identifier: GPL-2.0-or-later
// Membranes, beds and a body's own weight against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/body/assembly.hpp"
#include "host/body/gravity.hpp"
#include "host/body/under_constrained.hpp"
#include "host/fem/gravity.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/middles.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/npy.hpp"
#include "tests/bodies.hpp"
#include "tests/conditioning.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

using test::box, test::displace, test::kElements, test::kCubeSide_m;
const Selection kTop = box(-1, -1, 0.999 * kCubeSide_m, 1, 1, 1), kBottom = box(-1, -1, -1, 1, 1, 1e-9);

/// A cube that nothing holds; without lateral strain it is a bundle of springs.
Scene block(Element element, double poisson = 0.0) { return test::cube_of("block", 4, {1e4, poisson}, element); }

Body body_of(const Scene& scene) { return make_body(scene, make_mesh(scene.mesh)); }

Eigen::SparseMatrix<double> stiffness_of(const Scene& scene) {
    return test::assembled(assemble_free(scene, body_of(scene)));
}

/// Nodal displacements of a body that nothing holds.
std::vector<Vector3d> find_sag(const Scene& scene, const Body& body) {
    return find_sag(scene, body, Factor(assemble_free(scene, body)));
}

/// Nodal forces of a traction on the top.
Eigen::VectorXd on_top(const Body& body, const Vector3d& traction_pa) {
    return test::surface_load(body, [&](const Vector3d& area, const std::array<Vector3d, 3>& at) -> Vector3d {
        const bool is_top = std::min({at[0].z(), at[1].z(), at[2].z()}) > 0.999 * kCubeSide_m;
        return (is_top ? area.norm() : 0.0) * traction_pa;
    });
}

TEST(Membrane, UnderALoadInItsPlaneItPullsAtItsRimAsPlaneStressDoes) {
    const double t = 1e-3, e = 2e6, nu = 0.4, exx = 0.01, eyy = -0.004, exy = 0.003;
    const double plane = t * e / (1.0 - nu * nu);
    const double nxx = plane * (exx + nu * eyy), nyy = plane * (eyy + nu * exx), nxy = t * e / (1.0 + nu) * exy;
    for (Element element : kElements) {
        Scene scene = block(element);
        const Body body = body_of(scene);
        const Eigen::SparseMatrix<double> without = stiffness_of(scene);
        scene.membranes = {{kTop, t, e, nu}};
        const Eigen::SparseMatrix<double> k = stiffness_of(scene) - without;
        const Eigen::VectorXd u = displace(body, [&](const Vector3d& x) {
            return Vector3d(exx * x.x() + exy * x.y(), exy * x.x() + eyy * x.y(),
                            0.7 * x.x() - 0.2);  // and a rigid turn
        });
        const Eigen::VectorXd f = k * u;
        const double size = (stiffness_of(scene).cwiseAbs() * u.cwiseAbs()).maxCoeff();
        Vector3d right = Vector3d::Zero(), back = Vector3d::Zero();
        double inner = 0.0;
        for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i) {
            const Vector3d& x = body.mesh.position_m[i];
            const Vector3d force = f.segment<3>(3 * Index(i));
            const bool in_x = x.x() > 1e-9 && x.x() < kCubeSide_m - 1e-9;
            const bool in_y = x.y() > 1e-9 && x.y() < kCubeSide_m - 1e-9;
            if (x.z() < kCubeSide_m - 1e-9 || (in_x && in_y)) inner = std::max(inner, force.norm());
            inner = std::max(inner, std::abs(force.z()));
            // Half of the strip's force stands at each of its two rims.
            if (x.x() > kCubeSide_m - 1e-9 && in_y) right += force;
            if (x.y() > kCubeSide_m - 1e-9 && in_x) back += force;
        }
        EXPECT_WITHIN(inner, .count = 64, .size = size) << word(element);
        // A rim's inner nodes carry 2 of 3 cells of the edge; with middles the corners keep a sixth of a cell each.
        const double length =
            element == Element::kQuadratic ? kCubeSide_m * (1.0 - 1.0 / 9.0) : kCubeSide_m * 2.0 / 3.0;
        EXPECT_WITHIN((right - length * Vector3d(nxx, nxy, 0)).norm(), .count = 64, .size = size) << word(element);
        EXPECT_WITHIN((back - length * Vector3d(nxy, nyy, 0)).norm(), .count = 64, .size = size) << word(element);
    }
}

/// A ball of bulk modulus kappa in a membrane, under an even tension p at its surface:
/// p = 3 kappa w / R + 2 E t / (1 - nu) w / R^2. Returns the measured w over that one.
double blown_up(int n, Element element) {
    const double radius = 0.02, t = 5e-4, e = 5e5, nu = 0.45, pull_pa = 50.0;
    Scene scene = block(element, 0.3);
    TetMesh mesh = mesh_of(test::sphere_cells(n, radius));
    for (Tet& tet : mesh.tet)
        if (six_volumes(mesh.position_m, tet) < 0.0) std::swap(tet[2], tet[3]);
    if (element == Element::kQuadratic) add_middles(mesh);
    scene.membranes = {{box(-1, -1, -1, 1, 1, 1), t, e, nu}};
    scene.beds = {{box(-1, -1, -1, 1, 1, 1), 0.0, 1.0}};  // holds it still: nothing slides along the surface
    Vector3d centre = Vector3d::Zero();
    for (const Vector3d& x : mesh.position_m) centre += x / double(mesh.position_m.size());
    const Body body = make_body(scene, std::move(mesh));
    Eigen::MatrixXd u;
    const Eigen::MatrixXd force =
        test::surface_load(body, [&](const Vector3d& area, const auto&) -> Vector3d { return pull_pa * area; });
    Factor(assemble_free(scene, body)).solve(force, u);
    double w = 0.0;
    for (std::int32_t i : body.surface.node)
        w += (body.mesh.position_m[std::size_t(i)] - centre).normalized().dot(u.block<3, 1>(3 * i, 0)) /
             double(body.surface.node.size());
    const double kappa = 1e4 / (3.0 * (1.0 - 0.6));
    return w * (3.0 * kappa / radius + 2.0 * e * t / (1.0 - nu) / (radius * radius)) / pull_pa;
}

TEST(Membrane, ABalloonGrowsAsLaplacesLawSays) {
    for (Element element : {Element::kLinear, Element::kAverageNodalPressure}) {
        const double coarse = std::abs(blown_up(6, element) - 1.0), fine = std::abs(blown_up(12, element) - 1.0);
        EXPECT_LT(fine, 0.03) << word(element);          // (h / R)^2 of 12 cells across
        EXPECT_GT(coarse, 2.5 * fine) << word(element);  // second order
    }
    EXPECT_NEAR(blown_up(6, Element::kQuadratic), 1.0, 0.08);
}

TEST(Bed, ABlockSinksByItsLoadOverTheBedAndNothingElseHoldsIt) {
    const double press_pa = 80.0, normal = 3e5, tangential = 1e5;
    for (Element element : kElements) {
        SCOPED_TRACE(word(element));
        Scene scene = block(element);
        scene.beds = {{kBottom, normal, tangential}};
        const Body body = body_of(scene);
        EXPECT_EQ(body.fixed_count(), 0U);
        EXPECT_TRUE(find_under_constrained(body).empty());
        const Stiffness k = assemble_free(scene, body);
        const test::Bound bound = test::inverse_bound(k);
        Eigen::MatrixXd u;
        Factor(k).solve(on_top(body, {0, 0, -press_pa}), u);
        for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i) {
            const double sinks = press_pa / normal + press_pa / 1e4 * body.mesh.position_m[i].z();
            ASSERT_WITHIN((u.block<3, 1>(3 * Index(i), 0) + sinks * Vector3d::UnitZ()).norm() / sinks, bound)
                << "node " << i;
        }
        // Pushed aside as a whole it pushes back with the tangential springs alone.
        const Eigen::VectorXd aside = displace(body, [](const Vector3d&) { return Vector3d::UnitX(); });
        const double force = aside.dot(test::assembled(k) * aside);
        EXPECT_WITHIN(std::abs(force / (tangential * kCubeSide_m * kCubeSide_m) - 1.0), .count = 64, .condition = 100);
    }
}

TEST(Bed, OneThatOnlyPressesLetsABodySlide) {
    Scene scene = block(Element::kLinear);
    scene.beds = {{kBottom, 3e5, 0.0}};
    const Body sliding = body_of(scene);
    EXPECT_EQ(find_under_constrained(sliding).size(), 64U);
    EXPECT_TRUE(test::says(describe_under_constrained({0, 1}, sliding), "give its [[bed]] tangential too"));
    scene.beds.push_back({box(-1, -1, -1, 1e-9, 1, 1), 3e5, 0.0});  // and a wall
    EXPECT_EQ(find_under_constrained(body_of(scene)).size(), 64U);
    scene.beds.push_back({box(-1, -1, -1, 1, 1e-9, 1), 3e5, 0.0});  // and another
    EXPECT_TRUE(find_under_constrained(body_of(scene)).empty());
    EXPECT_EQ(find_supports(body_of(scene), {}).front().bed_faces, 3U * 18U);
}

Scene hanging(Element element, int cells, double young_pa) {
    Scene scene = test::cube_of("block", cells + 1, {young_pa, 0.0}, element);
    scene.fixed = {kTop};
    scene.gravity = Gravity{1100.0, {0, 0, -9.81}, false};
    return scene;
}

// E u'' = -rho g: u = rho g / E (L s - s^2 / 2) at s from where it hangs; nodes of tetrahedra share it with the bar's
// shape functions, which are exact at nodes in one dimension only: in three the corners differ a little.
TEST(Gravity, ABarHangsAsItsWeightSays) {
    constexpr double kWeight_n_per_m3 = 1100.0 * 9.81, kCell = 1.0 / 6.0;
    for (Element element : kElements) {
        const Scene scene = hanging(element, 6, 1e4);
        const Body body = body_of(scene);
        const std::vector<Vector3d> sag = find_sag(scene, body);
        double lowest = 0.0, sum = 0.0;
        int count = 0;
        for (std::size_t i = 0; i < sag.size(); ++i) {
            lowest = std::min(lowest, sag[i].z());
            if (body.mesh.position_m[i].z() > 1e-9) continue;
            sum += sag[i].z();
            ++count;
        }
        const double expected = -kWeight_n_per_m3 * kCubeSide_m * kCubeSide_m / 2e4;
        EXPECT_NEAR(sum / count / expected, 1.0, std::pow(kCell, element == Element::kQuadratic ? 3 : 2));
        EXPECT_LE(std::abs(lowest / expected), 1.0 + kCell);
        const Laws laws = laws_of(scene, body);
        const std::vector<double> density(body.mesh.tet.size(), 1100.0);
        const double weight = weight_of(element_mesh(scene, body, laws), density, {0, 0, -9.81}).row(2).sum();
        EXPECT_WITHIN(std::abs(weight / (-kWeight_n_per_m3 * std::pow(kCubeSide_m, 3)) - 1.0),
                      .count = 8.0 * std::sqrt(double(body.mesh.tet.size())));
    }
}

// The energy's second variation: an even stress s under a rigid turn or stretch with gradient H gives s : H^T H V.
TEST(Gravity, GeometricStiffnessIsTheWorkOfStressOnASecondDisplacement) {
    for (Element element : kElements)
        for (double poisson : {0.0, 0.49}) {
            Scene scene = block(element, poisson);
            scene.membranes = {{kTop, 1e-3, 1e5, 0.3}};
            const Body body = body_of(scene);
            Eigen::Matrix3d first, second;
            first << 0.01, 0.002, 0, 0.002, -0.004, 0.001, 0, 0.001, 0.003;
            second << 0.3, -0.2, 0.5, 0.1, 0.4, 0.7, -0.6, 0.2, 0.1;
            const Eigen::VectorXd u = displace(body, [&](const Vector3d& x) { return Vector3d(first * x); });
            const Eigen::VectorXd v = displace(body, [&](const Vector3d& x) { return Vector3d(second * x); });
            std::vector<Vector3d> sag;
            for (Index i = 0; i < u.size(); i += 3) sag.push_back(u.segment<3>(i));
            const Eigen::SparseMatrix<double> k = prestress_of(scene, body, sag);
            const Lame lame = Lame::from_young(1e4, poisson);
            const Eigen::Matrix3d stress =
                lame.lambda_pa * first.trace() * Eigen::Matrix3d::Identity() + 2.0 * lame.mu_pa * first;
            const Eigen::Matrix2d in_plane = first.topLeftCorner<2, 2>();
            Eigen::Matrix3d tension = Eigen::Matrix3d::Zero();
            tension.topLeftCorner<2, 2>() =
                1e2 / (1.0 - 0.09) * (0.7 * in_plane + 0.3 * in_plane.trace() * Eigen::Matrix2d::Identity());
            const double expected = (stress * (second.transpose() * second)).trace() * std::pow(kCubeSide_m, 3) +
                                    (tension * (second.transpose() * second)).trace() * kCubeSide_m * kCubeSide_m;
            const double size = v.cwiseAbs().dot(k.cwiseAbs() * v.cwiseAbs());
            EXPECT_WITHIN(std::abs(v.dot(k * v) - expected), .count = 256, .condition = 1.0 / (1.0 - 2.0 * poisson),
                          .size = size)
                << word(element) << ", nu = " << poisson;
        }
}

// A slender column that stands: Euler's and Greenhill's critical weight, q L = 7.837 E I / L^2.
TEST(Gravity, AColumnBucklesUnderItsOwnWeightWhereGreenhillSays) {
    const double width = 0.01, height = 0.12;
    Scene scene = block(Element::kQuadratic, 0.0);
    // A cube of two cells a side, 12 times one on top of the other.
    const TetMesh cube = make_cube(3, width);
    TetMesh mesh = cube;
    for (int k = 1; k < 12; ++k) {
        for (const auto& [a, b, c, d] : cube.tet) mesh.tet.push_back({a + 18 * k, b + 18 * k, c + 18 * k, d + 18 * k});
        for (std::size_t i = 9; i < 27; ++i) mesh.position_m.push_back(cube.position_m[i] + Vector3d(0, 0, width * k));
    }
    add_middles(mesh);
    scene.fixed = {kBottom};
    const double inertia = std::pow(width, 4) / 12.0;
    const double critical = 7.837 * 1e4 * inertia / std::pow(height, 3) / (width * width) / 9.81;  // kg/m^3
    scene.gravity = Gravity{critical / 2.0, {0, 0, -9.81}, true};
    const Body body = make_body(scene, std::move(mesh));
    const Factor factor(assemble_free(scene, body));
    const double found = buckling_factor(prestress_of(scene, body, find_sag(scene, body, factor)), factor);
    // Shear softens a column of 12 to 1 by (pi / 24)^2 / 12 x E / G, about 0.4 %; six faces across stiffen it a little.
    EXPECT_NEAR(found, 2.0, 0.06);
    GravityFacts facts;
    facts.load_factor = found;
    EXPECT_NO_THROW(require_unbuckled(scene, facts));
    facts.load_factor = found / 2.5;
    EXPECT_THROW(require_unbuckled(scene, facts), Error);
    // Hanging instead it is stiffer, and can only buckle at the top of what would push: nowhere.
    scene.gravity->acceleration_m_per_s2 = {0, 0, 9.81};
    EXPECT_GT(buckling_factor(prestress_of(scene, body, find_sag(scene, body, factor)), factor), 20.0);
}

class GravityRun : public testing::Test {
protected:
    Summary run(const Scene& scene, const char* name) {
        Progress progress(true);
        return precompute(scene, folder_.path() / name, progress, {}).summary;
    }
    std::string bytes(const char* run, const char* file) { return read_file(folder_.path() / run / file); }
    nlohmann::json summary(const char* run) { return parse_json(bytes(run, "summary.json")); }
    const test::TemporaryFolder folder_;
};

TEST_F(GravityRun, WithoutPrestressTheStiffnessIsTheSameBitsAndTheSurfaceSags) {
    Scene scene = hanging(Element::kLinear, 4, 3e3);
    run(scene, "weighed");
    const Gravity gravity = *scene.gravity;
    scene.gravity.reset();
    run(scene, "plain");
    EXPECT_TRUE(bytes("weighed", "stiffness.npy") == bytes("plain", "stiffness.npy"));
    EXPECT_TRUE(bytes("weighed", "columns.npy") == bytes("plain", "columns.npy"));
    const MappedNpy<double> with(folder_.path() / "weighed/position.npy"), rest(folder_.path() / "plain/position.npy"),
        sag(folder_.path() / "weighed/sag.npy");
    double lowest = 0.0;
    for (std::size_t k = 0; k < rest.values().size(); ++k) {
        EXPECT_EQ(with.values()[k], rest.values()[k] + sag.values()[k]);
        lowest = std::min(lowest, sag.values()[k]);
    }
    EXPECT_LT(lowest, -1e-3);
    const auto facts = summary("weighed")["gravity"];
    EXPECT_GT(facts["force_change"].get<double>(), GravityFacts::kFelt);
    EXPECT_TRUE(test::says(json_text(summary("weighed")["warnings"]), "write prestress = true"));
    // Again with another touch region: what an earlier run left is taken, with its sag.
    scene.gravity = gravity;
    scene.touch = {box(-1, -1, -1, 1, 1, 0.5 * kCubeSide_m)};
    EXPECT_TRUE(run(scene, "weighed").reused.all);
    EXPECT_EQ(summary("weighed")["gravity"], facts);
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "weighed/sag.npy"));
}

// That its tables are those of K and its stress Combinations shows (tests/host/precompute).
TEST_F(GravityRun, PrestressIsRefusedWhereItBuckles) {
    Scene scene = hanging(Element::kAverageNodalPressure, 3, 3e3);
    scene.gravity->prestress = true;
    run(scene, "loaded");
    EXPECT_EQ(json_text(summary("loaded")["warnings"]).find("prestress"), std::string::npos);
    scene.fixed = {kBottom};
    scene.material.young_pa = 400.0;  // stands under a weight that half of would do
    const std::string refused = test::error_of([&] { run(scene, "buckled"); });
    EXPECT_TRUE(test::says(refused, "gravity: the body buckles at 0."));
    EXPECT_TRUE(test::says(refused, "times its own weight"));
    scene.gravity->prestress = false;
    run(scene, "soft");
    const std::string warned = json_text(summary("soft")["warnings"]);
    EXPECT_TRUE(test::says(warned, "more than a tenth of its size, and sag is linear"));
    EXPECT_TRUE(test::says(warned, "it buckles at 0."));
    EXPECT_FALSE(test::says(warned, "write prestress"));
}

}  // namespace
}  // namespace haptable
