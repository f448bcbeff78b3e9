// SPDX-License-Identifier: GPL-2.0-or-later
// Displacements of all nodes against CalculiX, another program, on the same elements.
#include "host/bench/error/calculix.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "host/inverse/factor.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/gravity.hpp"
#include "tests/bodies.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// Largest difference, as a share of the largest displacement, under an oblique force on one node of the surface and
/// another on a second one: a corner and a middle where there are some.
double difference(const Scene& scene, const std::string& sections = {}, const std::string& loads = {}) {
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
    const auto theirs = run_calculix({body.mesh.position_m, elements, held, scene.material, false, sections, loads},
                                     std::span(&load, 1), folder.path())
                            .front();
    const Factor factor(assemble_free(scene, body));
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(factor.size(), 1), u;
    for (const auto& [node, f] : load) b.block<3, 1>(Eigen::Index{3} * body.unknown[std::size_t(node)], 0) = f;
    factor.solve(b, u);
    if (scene.gravity) {
        const std::vector<Vector3d> sag = find_sag(scene, body, factor);
        for (std::size_t i = 0; i < sag.size(); ++i)
            if (!body.is_fixed(std::int32_t(i))) u.block<3, 1>(Eigen::Index{3} * body.unknown[i], 0) += sag[i];
    }
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

TEST_F(CalculiX, QuadraticTetrahedraUpToPoissonsRatioOfASixth) {
    for (double poisson : {0.0, 0.16}) {
        Scene scene = cube_scene(5, poisson);
        scene.mesh.element = Element::kQuadratic;
        EXPECT_LT(difference(scene), kPrinted) << "nu = " << poisson;
    }
    Scene scene = mouse_scene();
    scene.mesh.element = Element::kQuadratic;
    scene.material.poisson = 0.16;
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
    scene.material = {1e4, 0.16};
    const TetMesh mesh = make_mesh(scene.mesh);
    double low = 1e9, high = -1e9;
    for (const Vector3d& x : mesh.position_m) {
        low = std::min(low, x.z());
        high = std::max(high, x.z());
    }
    scene.fixed.push_back({std::array<double, 6>{-1e3, -1e3, -1e3, 1e3, 1e3, low + 0.1 * (high - low)}, "", 1});
    EXPECT_LT(difference(scene), kPrinted);
}

constexpr double kMillimetres = 1e3, kMegapascals = 1e-6;

std::string constants(const char* name, const Orthotropic& law) {
    const auto& [e, nu, g, axes] = law;
    const auto& [one, two] = axes.direction;
    return fmt::format("*MATERIAL, NAME={}\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n", name) +
           fmt::format("{:.13g},{:.13g},{:.13g},{:.13g},{:.13g},{:.13g},{:.13g},{:.13g},\n{:.13g}\n",
                       kMegapascals * e[0], kMegapascals * e[1], kMegapascals * e[2], nu[0], nu[1], nu[2],
                       kMegapascals * g[0], kMegapascals * g[1], kMegapascals * g[2]) +
           fmt::format("*ORIENTATION, NAME=O{}\n{:.13g},{:.13g},{:.13g},{:.13g},{:.13g},{:.13g}\n", name, one[0],
                       one[1], one[2], two[0], two[1], two[2]);
}

std::string density(double kg_per_m3) { return fmt::format("*DENSITY\n{:.13g}\n", 1e-12 * kg_per_m3); }

/// The body's tetrahedra by their regions, with fibres in the first.
std::string solids(const Scene& scene, const Body& body) {
    std::string text;
    for (std::int32_t r : {-1, 0}) {
        text += fmt::format("*ELSET, ELSET=R{}\n", r + 1);
        for (std::size_t t = 0; t < body.region.size(); ++t)
            if (body.region[t] == r) text += fmt::format("{},\n", t + 1);
    }
    const Orthotropic& law = *scene.regions[0].material.orthotropic;
    text += constants("FIBRES", law) + density(scene.density_of(0)) +
            "*SOLID SECTION, ELSET=R1, MATERIAL=FIBRES, ORIENTATION=OFIBRES\n";
    text += fmt::format("*MATERIAL, NAME=BODY\n*ELASTIC\n{:.13g},{:.13g}\n", kMegapascals * scene.material.young_pa,
                        scene.material.poisson);
    return text + density(scene.density_of(-1)) + "*SOLID SECTION, ELSET=R0, MATERIAL=BODY\n";
}

/// One spring of its own for each pair of nodes and direction: what a bed's stiffness couples.
class Springs {
public:
    explicit Springs(std::size_t first) : next_(first) {}
    void add(std::int32_t a, std::int32_t b, int axis, double n_per_mm) {
        const bool to_ground = a == b;
        text_ += fmt::format("*ELEMENT, TYPE=SPRING{}, ELSET=S{}\n", to_ground ? 1 : 2, next_);
        text_ += to_ground ? fmt::format("{},{}\n*SPRING, ELSET=S{}\n{}\n", next_, a + 1, next_, axis + 1)
                           : fmt::format("{},{},{}\n*SPRING, ELSET=S{}\n{},{}\n", next_, a + 1, b + 1, next_, axis + 1,
                                         axis + 1);
        text_ += fmt::format("{:.13g}\n", n_per_mm);
        ++next_;
    }
    const std::string& text() const { return text_; }

private:
    std::size_t next_;
    std::string text_;
};

/// Faces normal to x. int N_a N_b dA is A / 12 for two corners and A / 6 for one with itself.
std::string bed(const Scene& scene, const Body& body) {
    std::map<std::array<std::int32_t, 2>, double> area_mm2;
    for (const LayeredFace& face : body.layered)
        if (face.layer.has_bed())
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b <= a; ++b) {
                    const auto [low, high] = std::minmax(face.node[a], face.node[b]);
                    area_mm2[{low, high}] +=
                        kMillimetres * kMillimetres * area_of(body.mesh.position_m, face) / (a == b ? 6.0 : 12.0);
                }
    std::map<std::int32_t, double> row_mm2;
    for (const auto& [pair, area] : area_mm2)
        for (std::size_t c = 0; c < (pair[0] == pair[1] ? 1 : 2); ++c) row_mm2[pair[c]] += area;
    Springs springs(100000);
    for (int axis = 0; axis < 3; ++axis) {
        const double k = 1e-9 * (axis == 0 ? scene.beds[0].normal_n_per_m3 : scene.beds[0].tangential_n_per_m3);
        for (const auto& [node, area] : row_mm2) springs.add(node, node, axis, k * area);
        for (const auto& [pair, area] : area_mm2)
            if (pair[0] != pair[1]) springs.add(pair[0], pair[1], axis, -k * area);
    }
    return springs.text();
}

std::string skin(const Scene& scene, const Body& body) {
    std::string text = "*ELEMENT, TYPE=M3D3, ELSET=SKIN\n";
    std::size_t next = 50000;
    for (const LayeredFace& face : body.layered)
        if (face.layer.has_membrane())
            text += fmt::format("{},{},{},{}\n", next++, face.node[0] + 1, face.node[1] + 1, face.node[2] + 1);
    const Membrane& m = scene.membranes[0];
    return text + fmt::format(
                      "*MATERIAL, NAME=SKIN\n*ELASTIC\n{:.13g},{:.13g}\n*MEMBRANE SECTION, ELSET=SKIN, "
                      "MATERIAL=SKIN\n{:.13g}\n",
                      kMegapascals * m.young_pa, m.poisson, kMillimetres * m.thickness_m);
}

/// A cube held at its bottom, with fibres in half of it, a skin on its top, a bed at one side, and its weight.
Scene whole_scene() {
    Scene scene = cube_scene(5, 0.4);
    Region half{
        {std::array<double, 6>{-1, -1, -1, 1, 0.015, 1}, "", 1}, like(fibre(6e4, 8e3, 0.35, 0.45, 5e3)), 1300.0};
    half.material.orthotropic->axes.direction = {{{0.48, 0.6, 0.64}, {0.8, -0.64, 0}}};
    scene.regions = {half};
    scene.membranes = {{{std::array<double, 6>{-1, -1, 0.0299, 1, 1, 1}, "", 1}, 1e-4, 3e6, 0.3}};
    scene.beds = {{{std::array<double, 6>{-1, -1, -1, 1e-9, 1, 1}, "", 1}, 2e6, 7e5}};
    scene.gravity = Gravity{1100.0, {0, 0, -9.81}, false};
    return scene;
}

TEST_F(CalculiX, FibresSkinBedAndWeightInOneBody) {
    const Scene scene = whole_scene();
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const std::string all = solids(scene, body) + skin(scene, body) + bed(scene, body);
    const std::string weight = "*DLOAD\nR0,GRAV,9810.,0.,0.,-1.\nR1,GRAV,9810.,0.,0.,-1.\n";
    EXPECT_LT(difference(scene, all, weight), kPrinted);
}

}  // namespace
}  // namespace haptable::test
