// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/assembly.hpp"

#include <utility>

namespace haptable {

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

}  // namespace haptable
