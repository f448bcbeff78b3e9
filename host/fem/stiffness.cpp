// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "host/fem/assembly.hpp"
#include "host/fem/nodal_pressure.hpp"

namespace haptable {

namespace {

using Unknowns = std::span<const std::int32_t>;

/// What is left of lambda for the averages; nothing where it is rounding.
double averaged_lambda_pa(Element element, const Lame& material) {
    const double left = material.lambda_pa - own_lambda_pa(element, material);
    return left > 1e-12 * std::abs(material.lambda_pa) ? left : 0.0;
}

Eigen::SparseMatrix<double> assemble_elements(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count) {
    const auto fill = [&](std::size_t t, Eigen::MatrixXd& k) {
        if (t >= mesh.corner.size()) {
            k = layer_stiffness(mesh.position_m, mesh.face[t - mesh.corner.size()]);
            return;
        }
        const auto element = [&](const auto& own) {
            if (mesh.is_quadratic())
                k = element_stiffness(ten_nodes_of(mesh, t), own);
            else
                k = element_stiffness(tet_geometry(corners_of(mesh, t)), own);
        };
        if (const Hooke* law = law_of(mesh, t))
            element(own_law(mesh, t, *law));
        else
            element(Lame{own_lambda_pa(mesh.element, mesh.material[t]), mesh.material[t].mu_pa});
    };
    return assemble(node_lists(mesh), fill, unknown, unknown_count);
}

/// Row by row what the elements leave to the nodes.
void assemble_cells(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count, StiffnessParts& parts) {
    const NodalCells cells(mesh);
    std::vector<Eigen::Triplet<double>> entry;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const Lame& material = cells.material(cell);
        const double lambda_pa = averaged_lambda_pa(mesh.element, material);
        if (lambda_pa == 0.0) continue;
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

// Half of mu: far from locking, it holds down what the averages do not see, and under a finger of one edge's radius
// quadratic tetrahedra are a third as far from the body as with all of lambda (docs/design/elements.md).
double own_lambda_pa(Element element, const Lame& material) {
    return element == Element::kLinear ? material.lambda_pa : std::min(material.lambda_pa, 0.5 * material.mu_pa);
}

const Hooke* law_of(const ElementMesh& mesh, std::size_t t) {
    return mesh.law_of.empty() || mesh.law_of[t] < 0 ? nullptr : &mesh.law[static_cast<std::size_t>(mesh.law_of[t])];
}

Hooke own_law(const ElementMesh& mesh, std::size_t t, const Hooke& law) {
    Hooke own = law;
    own.topLeftCorner<3, 3>().array() -= averaged_lambda_pa(mesh.element, mesh.material[t]);
    return own;
}

Corners corners_of(const ElementMesh& mesh, std::size_t t) {
    Corners corner_m;
    for (std::size_t c = 0; c < 4; ++c) corner_m[c] = mesh.position_m[static_cast<std::size_t>(mesh.corner[t][c])];
    return corner_m;
}

std::vector<std::int32_t> nodes_of(const ElementMesh& mesh, std::size_t t) {
    std::vector<std::int32_t> nodes(mesh.corner[t].begin(), mesh.corner[t].end());
    if (mesh.is_quadratic()) nodes.insert(nodes.end(), mesh.middle[t].begin(), mesh.middle[t].end());
    return nodes;
}

Lists node_lists(const ElementMesh& mesh) {
    Lists lists;
    for (std::size_t t = 0; t < mesh.corner.size(); ++t) lists.append(nodes_of(mesh, t));
    for (const LayeredFace& face : mesh.face) lists.append(nodes_of(face));
    return lists;
}

TenNodes ten_nodes_of(const ElementMesh& mesh, std::size_t t) {
    return ten_nodes(mesh.position_m, mesh.corner[t], mesh.middle[t]);
}

StiffnessParts assemble_stiffness(const ElementMesh& mesh, Unknowns unknown, std::int32_t unknown_count) {
    StiffnessParts parts;
    parts.a = assemble_elements(mesh, unknown, unknown_count);
    parts.g.resize(0, parts.a.cols());
    if (mesh.element != Element::kLinear) assemble_cells(mesh, unknown, unknown_count, parts);
    return parts;
}

}  // namespace haptable
