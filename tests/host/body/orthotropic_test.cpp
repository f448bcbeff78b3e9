// SPDX-License-Identifier: GPL-2.0-or-later
// Materials that are not isotropic against the textbook (Jones, Mechanics of Composite Materials, 2nd ed., chapter 2).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <numbers>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/body/assembly.hpp"
#include "tests/conditioning.hpp"
#include "tests/error_of.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using test::kElements, test::kCubeSide_m;
// A tendon-like law, and one that hardly changes its volume.
const Orthotropic kTendon{{5e4, 1e4, 4e3}, {0.4, 0.3, 0.25}, {6e3, 5e3, 2e3}};
const Orthotropic kFull{{2e4, 1e4, 1e4}, {0.499, 0.499, 0.745}, {6e3, 6e3, 2.9e3}};

/// A cube that nothing holds, of one law with its directions 1 and 2.
Scene bar(const Orthotropic& law, const Matrix3d& axes, Element element) {
    Scene scene = test::cube_of("bar", 4, like(law), element);
    for (std::size_t k = 0; k < 2; ++k)
        Vector3d::Map(scene.material.orthotropic->axes.direction[k].data()) = axes.col(int(k));
    return scene;
}

/// What a constant stress pulls at the nodes with.
Eigen::VectorXd pull(const Body& body, const Matrix3d& stress) {
    return test::surface_load(body, [&](const Vector3d& area, const auto&) -> Vector3d { return stress * area; });
}

/// Largest difference of the forces that the strain asks for to those of the stress, and what rounding allows.
void expect_balance(const Scene& scene, const Matrix3d& strain, const Matrix3d& stress) {
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const Eigen::SparseMatrix<double> k = test::assembled(assemble_free(scene, body));
    const Eigen::VectorXd u = test::displace(body, [&](const Vector3d& x) { return Vector3d(strain * x); });
    const double size = (k.cwiseAbs() * u.cwiseAbs()).maxCoeff();
    EXPECT_WITHIN((k * u - pull(body, stress)).cwiseAbs().maxCoeff(), .count = 64, .size = size)
        << word(scene.mesh.element);
}

TEST(Orthotropic, ABarAlongEachAxisStretchesAndShearsAsItsConstantsSay) {
    const double s = 100.0;
    for (const Orthotropic& law : {kTendon, kFull})
        for (Element element : kElements) {
            const auto& [e, nu, g, axes] = law;
            const Scene scene = bar(law, Matrix3d::Identity(), element);
            const double strain[3][3] = {{s / e[0], -nu[0] * s / e[0], -nu[1] * s / e[0]},
                                         {-nu[0] * s / e[0], s / e[1], -nu[2] * s / e[1]},
                                         {-nu[1] * s / e[0], -nu[2] * s / e[1], s / e[2]}};
            for (int k = 0; k < 3; ++k)
                expect_balance(scene, Vector3d(strain[k]).asDiagonal(),
                               s * Vector3d::Unit(k).asDiagonal().toDenseMatrix());
            for (const auto& [i, j, shear_pa] : {std::tuple{0, 1, g[0]}, {0, 2, g[1]}, {1, 2, g[2]}}) {
                Matrix3d stress = Matrix3d::Zero();
                stress(i, j) = stress(j, i) = s;
                expect_balance(scene, stress / (2.0 * shear_pa), stress);
            }
        }
}

TEST(Orthotropic, ABarThatIsTurnedByThirtyDegreesShearsAsItStretches) {
    const double t = std::numbers::pi / 6.0, c = std::cos(t), s = std::sin(t), pull_pa = 100.0;
    const Matrix3d axes = Eigen::AngleAxisd(t, Vector3d::UnitZ()).toRotationMatrix();
    for (const Orthotropic& law : {kTendon, kFull})
        for (Element element : kElements) {
            const auto& [e, nu, g, unused] = law;
            // Jones, equations 2.97: the apparent constants of a bar along x.
            const double mixed = 1.0 / g[0] - 2.0 * nu[0] / e[0];
            const double by_young = std::pow(c, 4) / e[0] + mixed * s * s * c * c + std::pow(s, 4) / e[1];
            const double by_poisson = nu[0] / e[0] * (std::pow(s, 4) + std::pow(c, 4)) -
                                      (1.0 / e[0] + 1.0 / e[1] - 1.0 / g[0]) * s * s * c * c;
            const double shear = (2.0 / e[0] + 2.0 * nu[0] / e[0] - 1.0 / g[0]) * s * c * c * c -
                                 (2.0 / e[1] + 2.0 * nu[0] / e[0] - 1.0 / g[0]) * s * s * s * c;
            const double thick = -nu[1] / e[0] * c * c - nu[2] / e[1] * s * s;
            Matrix3d strain;
            strain << by_young, 0.5 * shear, 0, 0.5 * shear, -by_poisson, 0, 0, 0, thick;
            Matrix3d stress = Matrix3d::Zero();
            stress(0, 0) = pull_pa;
            expect_balance(bar(law, axes, element), pull_pa * strain, stress);
        }
}

TEST(Orthotropic, IsotropicConstantsGiveTheIsotropicBody) {
    for (Element element : kElements)
        for (double poisson : {0.0, 0.3, 0.49}) {
            const double e = 1e4, g = e / (2.0 * (1.0 + poisson));
            const Orthotropic law{{e, e, e}, {poisson, poisson, poisson}, {g, g, g}};
            const Matrix3d axes = Eigen::AngleAxisd(1.0, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
            Scene scene = bar(law, axes, element);
            const Body body = make_body(scene, make_mesh(scene.mesh));
            const Eigen::SparseMatrix<double> k = test::assembled(assemble_free(scene, body));
            scene.material = {e, poisson};
            const Body plain = make_body(scene, make_mesh(scene.mesh));
            const Eigen::SparseMatrix<double> expected = test::assembled(assemble_free(scene, plain));
            // Hooke's law from its inverse: the bulk modulus against the shear modulus.
            EXPECT_WITHIN((k - expected).norm() / expected.norm(), .count = 32,
                          .condition = (1.0 + poisson) / (1.0 - 2.0 * poisson))
                << word(element) << ", nu = " << poisson;
        }
}

TEST(Orthotropic, LayersInSeriesAddTheirCompliancesAndInParallelTheirStiffnesses) {
    const Orthotropic hard{{5e4, 4e4, 3e4}, {0, 0, 0}, {1e4, 1e4, 1e4}},
        soft{{2e3, 3e3, 4e3}, {0, 0, 0}, {1e3, 1e3, 1e3}};
    // lambda + 2 mu: across the pull nothing moves.
    const auto modulus_pa = [](const Material& m) {
        return m.young_pa * (1.0 - m.poisson) / ((1.0 + m.poisson) * (1.0 - 2.0 * m.poisson));
    };
    const double pull_pa = 100.0, area = kCubeSide_m * kCubeSide_m;
    for (Element element : kElements)
        for (const auto& [across, is_isotropic] :  // the layers' normal; pulled along z
             {std::pair(0, false), {2, false}, {0, true}, {2, true}}) {
            SCOPED_TRACE(testing::Message() << element << ", " << across);
            Scene scene = bar(hard, Matrix3d::Identity(), element);
            Selection half = test::box(-1, -1, -1, 1, 1, 1);
            (*half.box_m)[std::size_t(across) + 3] = kCubeSide_m / 3.0;
            scene.regions.push_back({half, bar(soft, Matrix3d::Identity(), element).material});
            if (is_isotropic) {
                scene.material = {1e5, 0.499};
                scene.regions[0].material = {1e3, 0.3};
            }
            const double hard_pa = is_isotropic ? modulus_pa(scene.material) : 3e4,
                         soft_pa = is_isotropic ? modulus_pa(scene.regions[0].material) : 4e3;
            const Body body = make_body(scene, make_mesh(scene.mesh));
            const Eigen::SparseMatrix<double> k = test::assembled(assemble_free(scene, body));
            // In series one stress, in parallel one strain: u along z, piecewise linear.
            const double hard_strain = pull_pa / hard_pa, soft_strain = across == 2 ? pull_pa / soft_pa : hard_strain;
            const Eigen::VectorXd u = test::displace(body, [&](const Vector3d& x) {
                const double in_soft = std::min(x.z(), kCubeSide_m / 3.0);
                return Vector3d(0, 0, soft_strain * in_soft + hard_strain * (x.z() - in_soft));
            });
            const Eigen::VectorXd force = k * u;  // along z it is balanced inside
            const double size = (k.cwiseAbs() * u.cwiseAbs()).maxCoeff();
            double top = 0.0;
            for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i) {
                const double z = body.mesh.position_m[i].z(), along = force[3 * Eigen::Index(i) + 2];
                const bool on_top = z > 0.999 * kCubeSide_m;
                if (on_top) top += along;
                EXPECT_WITHIN(on_top || z == 0.0 ? 0.0 : std::abs(along), .count = 64, .size = size);
            }
            const double expected = across == 2 ? pull_pa * area : hard_strain * area * (soft_pa + 2.0 * hard_pa) / 3.0;
            EXPECT_WITHIN(std::abs(top - expected), .count = 64, .condition = 10, .size = size);
        }
}

TEST(Orthotropic, AroundAnAxisFibresRunInRings) {
    Scene scene = bar(kTendon, Matrix3d::Identity(), Element::kLinear);
    scene.material.orthotropic->axes = {};
    scene.material.orthotropic->axes.around = {{{0.015, 0.014, 0.5}, {0, 0, 2.0}}};
    const Body body = make_body(scene, make_mesh(scene.mesh));
    for (std::size_t t = 0; t < body.mesh.tet.size(); ++t) {
        Vector3d out = -Vector3d(0.015, 0.014, 0.0);
        for (std::int32_t i : body.mesh.tet[t]) out += 0.25 * body.mesh.position_m[std::size_t(i)];
        out.z() = 0.0;
        out.normalize();
        Matrix3d expected;
        expected << Vector3d::UnitZ().cross(out), Vector3d::UnitZ(), out;
        ASSERT_WITHIN((body.axes[t] - expected).norm(), .count = 64, .condition = 10);
    }
    scene.mesh.nodes_per_side = 2;  // its inner tetrahedron has its centre in the middle
    scene.material.orthotropic->axes.around = {{{0.015, 0.015, 0.0}, {0, 0, 1}}};
    EXPECT_THROW(make_body(scene, make_mesh(scene.mesh)), Error);
}

TEST(Orthotropic, WhatIsNotPositiveDefiniteIsNamed) {
    const auto law = [](double nu12, double nu13, double nu23) {
        return Orthotropic{{4e4, 1e4, 1e4}, {nu12, nu13, nu23}, {1e4, 1e4, 1e4}};
    };
    EXPECT_EQ(violated(law(0.3, 0.3, 0.3)), "");
    EXPECT_TRUE(test::says(violated(law(2.1, 0.0, 0.0)), "nu12 = 2.1 must lie between -2 and 2, the root of E1 / E2"));
    EXPECT_TRUE(test::says(violated(law(0.0, 0.0, -1.0)), "nu23"));
    EXPECT_TRUE(test::says(violated(law(1.3, 1.3, 0.3)), "1 - nu12 nu21 - nu23 nu32 - nu31 nu13"));
    // The condition is that of the stiffness: just within it is positive definite, just beyond it is not.
    for (double nu12 : {0.99 * std::sqrt(1.4), 1.01 * std::sqrt(1.4)}) {  // 1 - nu23 = 2 nu12 nu21 at nu12 = nu13
        const Orthotropic one = law(nu12, nu12, 0.3);
        Eigen::Matrix3d compliance;
        compliance << 1 / 4e4, -nu12 / 4e4, -nu12 / 4e4, -nu12 / 4e4, 1 / 1e4, -0.3 / 1e4, -nu12 / 4e4, -0.3 / 1e4,
            1 / 1e4;
        EXPECT_EQ(violated(one).empty(), compliance.determinant() > 0.0) << nu12;
    }
}

/// Two tetrahedra, the second of which stands the other way round, and a triangle between them in the list of cells.
const char* kVtu = R"(<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid><Piece NumberOfPoints="5" NumberOfCells="3">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0  1 0 0  0 1 0  0 0 1  1 1 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3  0 1 2  1 2 4 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4 7 11</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10 5 10</DataArray></Cells>
<CellData><DataArray type="Float64" Name="grain" NumberOfComponents="3" format="ascii">
0 2 0  9 9 9  0 3 4</DataArray></CellData>
</Piece></UnstructuredGrid></VTKFile>)";
const char* kVtk =
    "# vtk DataFile Version 2.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0  1 0 0  0 1 0  0 0 1  1 1 1\nCELLS 3 14\n4 0 1 2 3\n3 0 1 2\n4 1 2 4 3\nCELL_TYPES 3\n10\n5\n10\n"
    "CELL_DATA 3\n";

template <typename T>
std::string big_endian(T value) {
    auto bytes = std::bit_cast<std::array<char, sizeof value>>(value);
    std::ranges::reverse(bytes);
    return {bytes.begin(), bytes.end()};
}
std::string binary_vtk() {
    std::string text = "# vtk DataFile Version 2.0\ntwo\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n";
    for (double x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}) text += big_endian(x);
    text += "\nCELLS 3 14\n";
    for (int i : {4, 0, 1, 2, 3, 3, 0, 1, 2, 4, 1, 2, 4, 3}) text += big_endian(std::int32_t{i});
    text += "\nCELL_TYPES 3\n";
    for (int i : {10, 5, 10}) text += big_endian(std::int32_t{i});
    text += "\nCELL_DATA 3\nVECTORS grain double\n";
    for (double x : {0, 2, 0, 9, 9, 9, 0, 3, 4}) text += big_endian(x);
    return text + "\n";
}

TEST(Orthotropic, DirectionsFollowCellVectorsOfTheMeshFile) {
    const test::TemporaryFolder folder;
    const std::string values = "0 2 0\n9 9 9\n0 3 4\n";
    Scene scene = bar(kTendon, Matrix3d::Identity(), Element::kLinear);
    scene.mesh.generate.clear();
    scene.mesh.scale_m = 0.01;
    scene.mesh.directions = {"grain"};
    scene.material.orthotropic->axes = {};
    scene.material.orthotropic->axes.field[0] = "grain";
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>{"a.vtu", kVtu},
          {"vectors.vtk", kVtk + ("VECTORS grain double\n" + values)},
          {"field.vtk",
           kVtk + ("SCALARS s double 1\nLOOKUP_TABLE default\n1 2 3\nFIELD f 1\ngrain 3 3 float\n" + values)},
          {"binary.vtk", binary_vtk()}}) {
        scene.mesh.file = folder.path() / name;
        write_file(scene.mesh.file, text);
        const Body body = make_body(scene, make_mesh(scene.mesh));
        ASSERT_EQ(body.axes.size(), 2U) << name;
        EXPECT_WITHIN((body.axes[0].col(0) - Vector3d(0, 1, 0)).norm(), .count = 8) << name;
        EXPECT_WITHIN((body.axes[1].col(0) - Vector3d(0, 0.6, 0.8)).norm(), .count = 8) << name;
        for (const Matrix3d& axes : body.axes) EXPECT_WITHIN(std::abs(axes.determinant() - 1.0), .count = 24) << name;
        for (const char* missing : {"Grain", "s"}) {
            scene.mesh.directions = {missing};
            EXPECT_THROW(make_mesh(scene.mesh), Error) << name;
        }
        scene.mesh.directions = {"grain"};
    }
}

}  // namespace
}  // namespace haptable
