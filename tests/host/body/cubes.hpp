// SPDX-License-Identifier: GPL-2.0-or-later
// Cubes that nothing holds, what tests of them select, and each of the elements.
#pragma once

#include <string>

#include "host/body/assembly.hpp"
#include "host/body/body.hpp"
#include "host/mesh/cube.hpp"
#include "host/scene/scene.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"

namespace haptable::test {

inline constexpr double kCubeSide_m = 0.03;
inline constexpr Element kElements[] = {Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};

inline Selection box(double x0, double y0, double z0, double x1, double y1, double z1) {
    return {std::array<double, 6>{x0, y0, z0, x1, y1, z1}, "", 1};
}

inline Scene cube_of(const std::string& name, int nodes_per_side, const Material& material,
                     Element element = Element::kLinear) {
    Scene scene;
    scene.file = name + ".toml";
    scene.name = name;
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.mesh.side_m = kCubeSide_m;
    scene.mesh.element = element;
    scene.material = material;
    return scene;
}

enum class Law { kIsotropic, kOrthotropic, kFibre, kRings };
inline constexpr Law kLaws[] = {Law::kIsotropic, Law::kOrthotropic, Law::kFibre, Law::kRings};

inline Material material_of(Law law) {
    if (law == Law::kIsotropic) return {1e4, 0.45};
    Material material = like(law == Law::kOrthotropic ? Orthotropic{{4e4, 1e4, 8e3}, {0.3, 0.2, 0.4}, {6e3, 5e3, 3e3}}
                                                      : fibre(6e4, 8e3, 0.35, 0.45, 5e3));
    MaterialAxes& axes = material.orthotropic->axes;
    if (law == Law::kRings)
        axes.around = {{{-0.01, 0.012, 0.0}, {0, 0, 1}}};
    else
        axes.direction = {{{0.48, 0.6, 0.64}, {0.8, -0.64, 0}}};
    return material;
}

/// In a skin, on a bed, of two materials, under its weight: K is factorised without its stress and with it.
inline Scene layered_cube(Element element, Law law) {
    Scene scene = cube_of("cube", 3, material_of(law), element);
    scene.regions = {
        {box(-1, -1, -1, 1, 1, 0.015), law == Law::kIsotropic ? Material{3e4, 0.3} : Material{1e4, 0.45}, 900.0}};
    scene.membranes = {{box(-1, -1, 0.0299, 1, 1, 1), 1e-4, 1e6, 0.3}};
    scene.beds = {{box(-1, -1, -1, 1, 1, 1e-9), 2e6, 7e5}};
    scene.gravity = Gravity{1100.0, {0, 0, -9.81}, true};
    return scene;
}

/// L = K^-1 of a body as a solver.
class DenseInverse : public LinearSolver {
public:
    DenseInverse(const Scene& scene, const Body& body) : l(dense::inverse_spd(assembled(assemble_free(scene, body)))) {}
    Eigen::Index size() const override { return l.rows(); }
    void solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const override { x = l * b; }
    const Eigen::MatrixXd l;
};

/// Two cubes of so many nodes a side, two sides apart.
inline TetMesh two_cubes(int nodes_per_side, double side_m) {
    const TetMesh one = make_cube(nodes_per_side, side_m);
    TetMesh mesh = one;
    const auto n = std::int32_t(one.position_m.size());
    for (const Eigen::Vector3d& p : one.position_m)
        mesh.position_m.push_back(p + 3.0 * side_m * Eigen::Vector3d::UnitX());
    for (const auto& [a, b, c, d] : one.tet) mesh.tet.push_back({a + n, b + n, c + n, d + n});
    return mesh;
}

/// u of all nodes of a body that nothing holds.
template <typename Field>
Eigen::VectorXd displace(const Body& body, Field field) {
    Eigen::VectorXd u(3 * Eigen::Index(body.mesh.position_m.size()));
    for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i)
        u.segment<3>(3 * Eigen::Index(i)) = field(body.mesh.position_m[i]);
    return u;
}

/// Nodal forces of what loads a body's surface: force(area, corners) of each face, its area as a vector outwards. Each
/// corner has a third; with middles they. [3 nodes] N
template <typename Force>
Eigen::VectorXd surface_load(const Body& body, Force force) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(3 * Eigen::Index(body.mesh.position_m.size()));
    const auto& x = body.mesh.position_m;
    const auto add = [&](const std::int32_t* corner, const std::int32_t* loaded) {
        const std::array at{x[std::size_t(corner[0])], x[std::size_t(corner[1])], x[std::size_t(corner[2])]};
        const Eigen::Vector3d area = 0.5 * (at[1] - at[0]).cross(at[2] - at[0]), of_face = force(area, at);
        for (int k = 0; k < 3; ++k) sum.segment<3>(3 * loaded[k]) += of_face / 3.0;
    };
    for (const QuadraticFace& face : body.surface.face) add(face.data(), face.data() + 3);
    if (body.surface.face.empty())
        for (const Patch& patch : body.surface.patch) add(patch.data(), patch.data());
    return sum;
}

}  // namespace haptable::test
