// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/assembly.hpp"

#include <utility>

#include "host/fem/stiffness.hpp"

namespace haptable {

std::vector<Lame> materials_of(const Scene& scene, const Body& body) {
    const auto lame = [](const Material& m) { return Lame::from_young(m.young_pa, m.poisson); };
    std::vector<Lame> material;
    for (std::int32_t region : body.region)
        material.push_back(
            lame(region < 0 ? scene.material : scene.regions[static_cast<std::size_t>(region)].material));
    return material;
}

Stiffness assemble_free(const Scene& scene, const Body& body) {
    const std::vector<Lame> material = materials_of(scene, body);
    StiffnessParts parts =
        assemble_stiffness({scene.mesh.element, body.mesh.position_m, body.mesh.tet, material, body.mesh.middle},
                           body.unknown, static_cast<std::int32_t>(body.free_node.size()));
    for (std::int32_t& node : parts.node) node = body.unknown[static_cast<std::size_t>(node)];
    return {parts.a, parts.g, std::move(parts.node)};
}

}  // namespace haptable
