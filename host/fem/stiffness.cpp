// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "host/fem/assembly.hpp"
#include "host/fem/nodal_pressure.hpp"

namespace haptable {

namespace {

using Unknowns = std::span<const std::int32_t>;

/// lambda_e, which an element keeps for itself. Half of mu is far from locking, holds down what the averages do not
/// see, and is measured best of 0 to 1.5 mu (docs/design/elements.md).
double own_lambda_pa(Element element, const Lame& material) {
    return element == Element::kLinear ? material.lambda_pa : std::min(material.lambda_pa, 0.5 * material.mu_pa);
}

Eigen::SparseMatrix<double> assemble_elements(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count) {
    Lists nodes;
    for (const auto& tet : mesh.corner) nodes.append(tet);
    const auto fill = [&](std::size_t t, Eigen::MatrixXd& k) {
        const Lame own{own_lambda_pa(mesh.element, mesh.material[t]), mesh.material[t].mu_pa};
        k = element_stiffness(tet_geometry(corners_of(mesh, t)), own);
    };
    return assemble(nodes, fill, unknown, unknown_count);
}

/// Row by row what the elements leave to the nodes.
void assemble_cells(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count, StiffnessParts& parts) {
    const NodalCells cells(mesh);
    std::vector<Eigen::Triplet<double>> entry;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const Lame& material = cells.material(cell);
        const double lambda_pa = material.lambda_pa - own_lambda_pa(mesh.element, material);
        if (!(lambda_pa > 0.0)) continue;
        const NodalCells::Average theta = cells.average(cell);
        const double scale = std::sqrt(lambda_pa / theta.volume_m3);
        const auto row = static_cast<int>(parts.node.size());
        const std::size_t before = entry.size();
        for (std::size_t i = 0; i < 3 * theta.node.size(); ++i) {
            const std::int32_t place = unknown[static_cast<std::size_t>(theta.node[i / 3])];
            if (place >= 0)
                entry.emplace_back(row, 3 * place + static_cast<int>(i % 3),
                                   scale * theta.d_m2[static_cast<Eigen::Index>(i)]);
        }
        if (entry.size() > before) parts.node.push_back(cells.node(cell));
    }
    parts.g.resize(static_cast<Eigen::Index>(parts.node.size()), 3 * static_cast<Eigen::Index>(unknown_count));
    parts.g.setFromTriplets(entry.begin(), entry.end());
}

}  // namespace

Corners corners_of(const ElementMesh& mesh, std::size_t t) {
    Corners corner_m;
    for (std::size_t c = 0; c < 4; ++c) corner_m[c] = mesh.position_m[static_cast<std::size_t>(mesh.corner[t][c])];
    return corner_m;
}

StiffnessParts assemble_stiffness(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count) {
    StiffnessParts parts;
    parts.a = assemble_elements(mesh, unknown, unknown_count);
    parts.g.resize(0, parts.a.cols());
    if (mesh.element != Element::kLinear) assemble_cells(mesh, unknown, unknown_count, parts);
    return parts;
}

}  // namespace haptable
