// SPDX-License-Identifier: GPL-2.0-or-later
// Modes and the static rest of them against a dense eigenproblem and closed forms; tests/lab has another program's.
#include "host/inverse/natural_modes.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "host/body/assembly.hpp"
#include "host/body/rigid_body.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/inverse/free_inverse.hpp"
#include "host/inverse/rest_inverse.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEigen = 1e-6;  // relative, against the dense eigenproblem
constexpr double kDensity = 1000.0;
constexpr int kModes = 8;

Scene cube(int nodes_per_side, Element element, bool is_free, double poisson = 0.45) {
    Scene scene = test::cube_scene(nodes_per_side, poisson);
    scene.mesh.element = element;
    if (is_free) test::set_free(scene, kDensity);
    scene.body_modes = BodyModes{kModes, 0.05, is_free ? 0.0 : kDensity, 0.0, 1};
    return scene;
}

/// A body with its modes.
struct Ringing {
    explicit Ringing(const Scene& given) : scene(given) {
        if (scene.free_body) {
            rigid = rigid_body_of(scene, body);
            rigid.momentum = mass * rigid.motion;
            relieved.emplace(cholmod, rigid.motion, rigid.momentum);
        }
        rest.emplace(relieved ? static_cast<Inverse&>(*relieved) : cholmod, mass, scene.body_modes->modes);
        const Stiffness held =
            scene.free_body ? assemble_free(scene, body, hold_springs(body, k.diagonal())) : assemble_free(scene, body);
        Progress quiet(true);
        rest->analyse(held, {{}, {}, {}, false, 6});
        rest->factorize(held, quiet);
    }
    const NaturalModes& modes() const { return rest->modes(); }
    double hz(Index mode) const { return modes().omega_rad_per_s[mode] / (2.0 * std::numbers::pi); }
    MatrixXd dense(const Stiffness& matrix) const { return matrix * MatrixXd::Identity(matrix.size(), matrix.size()); }

    Scene scene;
    Body body = make_body(scene, make_mesh(scene.mesh));
    Stiffness k = assemble_free(scene, body);
    Eigen::SparseMatrix<double> mass = assemble_mass(scene, body);
    RigidBody rigid;
    CholmodInverse cholmod;
    std::optional<FreeInverse> relieved;
    std::optional<RestInverse> rest;
};

class ModesOf : public testing::TestWithParam<std::tuple<Element, bool>> {
protected:
    const bool is_free = std::get<1>(GetParam());
    Ringing ringing{cube(4, std::get<0>(GetParam()), is_free)};
};

// M^-1/2 K M^-1/2, whose eigenvalues are omega^2; of a free body the first six are those of rigid motion.
TEST_P(ModesOf, AreThoseOfTheDenseEigenproblem) {
    const auto mass = dense::eigen(MatrixXd(ringing.mass));
    const MatrixXd root =
        dense::product(mass.vectors * mass.values.cwiseSqrt().cwiseInverse().asDiagonal(), mass.vectors.transpose());
    const VectorXd omega2 = dense::eigenvalues(dense::product(root, dense::product(ringing.dense(ringing.k), root)));
    const Index rigid = is_free ? 6 : 0;
    for (Index k = 0; k < kModes; ++k) {
        const double wanted = std::sqrt(omega2[rigid + k]);
        EXPECT_WITHIN(std::abs(ringing.modes().omega_rad_per_s[k] - wanted), .epsilon = kEigen, .size = wanted)
            << "mode " << k;
    }
    const MatrixXd& phi = ringing.modes().shape;
    EXPECT_LT((transposed_product(phi, ringing.mass * phi) - MatrixXd::Identity(kModes, kModes)).norm(), kEigen);
    for (Index k = 0; k < kModes; ++k) {
        const double omega = ringing.modes().omega_rad_per_s[k];
        const VectorXd inertia = omega * omega * (ringing.mass * phi.col(k));
        EXPECT_LT((ringing.k * phi.col(k) - inertia).norm(), kEigen * inertia.norm()) << "mode " << k;
    }
    if (!is_free) return;
    EXPECT_LT(transposed_product(ringing.rigid.momentum, phi).norm(), kEigen * ringing.rigid.momentum.norm());
}

// What the modes come to under a load that is held, and the rest: L f. And the rest is orthogonal to the modes.
TEST_P(ModesOf, WithTheRestAreTheStaticBody) {
    const Inverse& whole = ringing.relieved ? static_cast<Inverse&>(*ringing.relieved) : ringing.cholmod;
    const MatrixXd load = MatrixXd::Random(ringing.k.size(), 3);
    MatrixXd u, rest;
    whole.solve(load, u);
    ringing.rest->solve(load, rest);
    const MatrixXd& phi = ringing.modes().shape;
    const VectorXd soft = ringing.modes().omega_rad_per_s.cwiseAbs2().cwiseInverse();
    const MatrixXd moved = dense::product(phi * soft.asDiagonal(), transposed_product(phi, load));
    EXPECT_LT((rest + moved - u).norm(), kEigen * u.norm());
    EXPECT_LT(transposed_product(phi, ringing.mass * rest).norm(),
              kEigen * std::sqrt(ringing.rigid.mass_kg + 0.027) * u.norm());
    EXPECT_GT(moved.norm(), 0.1 * u.norm()) << "the modes are a part of it";
    MatrixXd balanced = load;
    ringing.rest->balance(balanced);
    EXPECT_LT((ringing.k * rest - balanced).norm(), kEigen * load.norm());
    Progress quiet(true);
    const std::vector<NodePair> pairs{{0, 0}, {5, 9}, {9, 5}, {30, 2}};
    const auto part = [](const MatrixXd& of, const NodePair& p) {
        return Eigen::Matrix3d(of.block<3, 3>(3 * Index{p.row}, 3 * Index{p.column}));
    };
    const Blocks blocks = ringing.rest->blocks(pairs, Precision::kDouble, quiet);
    MatrixXd l;
    ringing.rest->solve(MatrixXd::Identity(load.rows(), load.rows()), l);
    const double size = part(l, pairs.front()).norm();
    for (std::size_t p = 0; p < pairs.size(); ++p)
        EXPECT_LT((blocks.l_ij[p] - part(l, pairs[p])).norm(), kEigen * size);
}

INSTANTIATE_TEST_SUITE_P(Elements, ModesOf, testing::Combine(testing::ValuesIn(every<Element>()), testing::Bool()));

/// The mode that moves most as u = (0, 0, f(z)).
template <typename Along>
Index mode_along(const Ringing& ringing, Along along) {
    VectorXd u = VectorXd::Zero(ringing.mass.rows());
    for (std::size_t i = 0; i < ringing.body.free_node.size(); ++i)
        u[3 * Index(i) + 2] = along(ringing.body.mesh.position_m[std::size_t(ringing.body.free_node[i])].z());
    Index best = 0;
    const VectorXd part = transposed_product(ringing.modes().shape, ringing.mass * u);
    part.cwiseAbs().maxCoeff(&best);
    double alike = 0.0;  // along x and y a free cube swings as fast
    for (Index k = 0; k < part.size(); ++k)
        if (std::abs(ringing.hz(k) - ringing.hz(best)) < 1e-3 * ringing.hz(best)) alike += part[k] * part[k];
    EXPECT_GT(alike, 0.999 * u.dot(ringing.mass * u)) << "it is that mode";
    return best;
}

// Without Poisson's effect a bar's waves along it are exact in three dimensions, however thick it is:
// f = sqrt(E / rho) / 2 l where both ends are free, / 4 l where one is held. A quarter of a wave on four quadratic
// elements is 1e-5 of its frequency off, (pi h / l)^4 / 720 and less.
TEST(BarModes, AreThoseOfTheClosedForm) {
    constexpr double kSide = 0.03, kError = 2e-4;
    for (const bool is_free : {false, true}) {
        Scene scene = cube(5, Element::kQuadratic, is_free, 0.0);
        scene.body_modes->modes = 24;
        const Ringing ringing(scene);
        const double turns = is_free ? 1.0 : 0.5;
        const Index k = mode_along(ringing, [&](double z) {
            const double at = turns * std::numbers::pi * z / kSide;
            return is_free ? std::cos(at) : std::sin(at);
        });
        const double wanted = turns / (2.0 * kSide) * std::sqrt(scene.material.young_pa / kDensity);
        EXPECT_NEAR(ringing.hz(k), wanted, kError * wanted) << (is_free ? "free" : "held");
    }
}

/// The same, but for the last bits of what it gives.
class OtherRounding : public LinearSolver {
public:
    explicit OtherRounding(const LinearSolver& solver) : solver_(solver) {}
    Index size() const override { return solver_.size(); }
    void solve(const MatrixXd& b, MatrixXd& x) const override {
        solver_.solve(b, x);
        x.array() *= 1.0 + 4.0 * test::kDouble * MatrixXd::Random(x.rows(), x.cols()).array();
    }

private:
    const LinearSolver& solver_;
};

// A cube swings along x as fast as along y, and every mixture of the two is a mode.
TEST(Modes, AreTheSameShapesHoweverSumsAreRounded) {
    const Ringing ringing(cube(5, Element::kLinear, false));
    const NaturalModes& modes = ringing.modes();
    int pairs = 0;
    for (Index k = 1; k < kModes; ++k)
        if (modes.omega_rad_per_s[k] - modes.omega_rad_per_s[k - 1] < 1e-12 * modes.omega_rad_per_s[k]) ++pairs;
    EXPECT_GT(pairs, 0) << "this body has no two modes of one frequency";
    for (int again = 0; again < 3; ++again) {
        const NaturalModes others = find_modes(OtherRounding(ringing.cholmod), ringing.mass, kModes);
        for (Index k = 0; k < kModes; ++k)
            EXPECT_WITHIN((others.shape.col(k) - modes.shape.col(k)).norm(), .epsilon = 1e-10,
                          .size = modes.shape.col(k).norm())
                << "mode " << k;
    }
}

TEST(Modes, SayWhereThereAreNone) {
    Scene scene = cube(2, Element::kLinear, false);  // 4 free nodes
    scene.body_modes->modes = 4;
    EXPECT_TRUE(test::fails_with([&] { Ringing{scene}; }, "4 of a body that has 12 unknowns"));
}

}  // namespace
}  // namespace haptable
