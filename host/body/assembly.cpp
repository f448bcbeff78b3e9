// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/assembly.hpp"

#include <numeric>
#include <utility>

#include "host/base/index.hpp"
#include "host/body/mask.hpp"
#include "host/fem/mass.hpp"

namespace haptable {

namespace {

/// Mass matrix of these nodes, the unknown ones of `count`.
Eigen::SparseMatrix<double> mass_of(const Scene& scene, const Body& body, std::span<const std::int32_t> unknown,
                                    std::size_t count) {
    std::vector<double> density;
    for (const std::int32_t region : body.region) density.push_back(scene.density_of(region));
    const Laws laws = laws_of(scene, body);
    return mass_matrix(element_mesh(scene, body, laws), density, unknown, static_cast<std::int32_t>(count));
}

/// By its densities, held nodes with it.
double whole_mass_kg(const Scene& scene, const Body& body) {
    std::vector<std::int32_t> all(body.unknown.size());
    std::iota(all.begin(), all.end(), 0);
    return mass_of(scene, body, all, all.size()).sum() / 3.0;
}

}  // namespace

std::vector<Lame> materials_of(const Scene& scene, const Body& body) {
    const auto lame = [](const Material& m) { return Lame::from_young(m.young_pa, m.poisson); };
    std::vector<Lame> material;
    for (std::int32_t region : body.region) material.push_back(lame(scene.material_of(region)));
    return material;
}

Laws laws_of(const Scene& scene, const Body& body) {
    Laws laws{materials_of(scene, body), {}, {}};
    if (body.axes.empty()) return laws;
    std::size_t last = 0;  // that had the law at the end of the list: neighbours in the list are often alike
    for (std::size_t t = 0; t < body.axes.size(); ++t) {
        const auto& own = scene.material_of(body.region[t]).orthotropic;
        if (own && (laws.law.empty() || body.region[last] != body.region[t] || body.axes[last] != body.axes[t])) {
            laws.law.push_back(turned(orthotropic_hooke(own->young_pa, own->poisson, own->shear_pa), body.axes[t]));
            last = t;
        }
        laws.law_of.push_back(own ? static_cast<std::int32_t>(laws.law.size()) - 1 : -1);
    }
    return laws;
}

ElementMesh element_mesh(const Scene& scene, const Body& body, const Laws& laws) {
    return {scene.mesh.element, body.mesh.position_m, body.mesh.tet, laws.like, body.mesh.middle,
            laws.law,           laws.law_of,          body.layered};
}

Stiffness assemble_free(const Scene& scene, const Body& body, const Eigen::SparseMatrix<double>& also) {
    const Laws laws = laws_of(scene, body);
    StiffnessParts parts = assemble_stiffness(element_mesh(scene, body, laws), body.unknown,
                                              static_cast<std::int32_t>(body.free_node.size()));
    if (also.size() > 0) parts.a += also;
    for (std::int32_t& node : parts.node) node = body.unknown[static_cast<std::size_t>(node)];
    return {parts.a, parts.g, std::move(parts.node)};
}

Eigen::SparseMatrix<double> assemble_mass(const Scene& scene, const Body& body) {
    Eigen::SparseMatrix<double> mass = mass_of(scene, body, body.unknown, body.free_node.size());
    if (scene.mass_kg() > 0.0) mass *= scene.mass_kg() / whole_mass_kg(scene, body);
    return mass;
}

Eigen::Matrix3Xd spread(const Eigen::VectorXd& x, std::span<const std::int32_t> unknown) {
    Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, std::ssize(unknown));
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (unknown[i] >= 0) u.col(static_cast<Eigen::Index>(i)) = x.segment<3>(dof(unknown[i]));
    return u;
}

Eigen::VectorXd gather(const Eigen::Matrix3Xd& f, std::span<const std::int32_t> unknown, Eigen::Index size) {
    Eigen::VectorXd x(size);
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (unknown[i] >= 0) x.segment<3>(dof(unknown[i])) = f.col(static_cast<Eigen::Index>(i));
    return x;
}

Eigen::MatrixXd load_matrix(const NodeWeights& load, std::span<const std::int32_t> unknown, Eigen::Index size) {
    Eigen::MatrixXd w = Eigen::MatrixXd::Zero(size, 3);
    for (std::size_t k = 0; k < load.node.size(); ++k)
        if (const std::int32_t i = unknown[at(load.node[k])]; i >= 0)
            w.middleRows<3>(dof(i)) += load.weight[k] * Eigen::Matrix3d::Identity();
    return w;
}

}  // namespace haptable
