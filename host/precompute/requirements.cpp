// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/requirements.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/codegen.hpp"
#include "codegen/model.hpp"
#include "host/body/rigid_body.hpp"
#include "host/compliance/compliance.hpp"
#include "host/inverse/natural_modes.hpp"
#include "host/precompute/plan.hpp"

namespace haptable {

namespace {

// A pivot below this fraction of its diagonal entry is zero to rounding: 2.2e-16 times the growth of a few hundred
// updates. Bodies of the tests that are constrained keep above 1e-3.
constexpr double kZeroPivot = 1e-13;
// Solves with a larger residual than this would be seen in the float32 tables.
constexpr double kLargestResidual = 1e-6;

}  // namespace

std::vector<Support> require_constrained(const Scene& scene, const Body& body) {
    if (scene.free_body) {
        require_one_body(scene, body);
        return find_supports(body, {});
    }
    const std::vector<std::int32_t> nodes = find_under_constrained(body);
    if (!nodes.empty())
        throw Error(fmt::format("{}: fixed: {}", scene.file.string(), describe_under_constrained(nodes, body)));
    return find_supports(body, nodes);
}

void require_servo(const Scene& scene, const Body& body) {
    Tables tables;
    for (const Eigen::Vector3d& p : body.mesh.position_m) tables.position.push_back({p.x(), p.y(), p.z()});
    tables.patch = body.touch_patch;
    tables.node_id = body.touch_node;
    tables.precision = scene.tables.precision;
    if (scene.contact.force == ForceLaw::kInterpolated)
        tables.stiffness.assign(body.touch_node.size(), {1, 0, 0, 0, 1, 0, 0, 0, 1});
    in_scene(scene, [&] {
        const ServoModel model = build_model(tables);
        require_flash(flash_tables(model), model, scene.tables.flash_budget);
    });
}

void require_rows_and_modes(const Scene& scene, const Body& body) {
    const std::vector<std::int32_t>& rows = rows_of(scene, body);
    for (const std::int32_t node : scene.tables.display_rows) {
        if (std::find(rows.begin(), rows.end(), node) != rows.end()) continue;
        const bool is_known = static_cast<std::size_t>(node) < body.mesh.position_m.size();
        throw Error(fmt::format("{}: tables.display_rows: node {} {}", scene.file.string(), node,
                                is_known ? "has no columns: it is fixed, or lies inside (columns = \"all\" keeps those)"
                                         : fmt::format("is none of the mesh's {} nodes", body.mesh.position_m.size())));
    }
    const int most = most_modes(3 * static_cast<Eigen::Index>(body.free_node.size()));
    if (scene.body_modes && scene.body_modes->modes > most)
        throw Error(fmt::format("{}:{}: body.modes: {} of a body that has {} free nodes: ask for at most {}",
                                scene.file.string(), scene.body_modes->line, scene.body_modes->modes,
                                body.free_node.size(), most));
}

double require_pivots(const Scene& scene, const Body& body, const Stiffness& k, const LinearSolver& solver,
                      const FactorFacts& facts) {
    const double least = facts.weakest ? facts.weakest->ratio : least_scaled_eigenvalue(k, solver);
    if (least > kZeroPivot) return least;
    const auto mesh_node = [&](std::int32_t unknown) { return body.free_node[static_cast<std::size_t>(unknown)]; };
    std::vector<std::int32_t> softest = find_softest_nodes(k);
    for (std::int32_t& node : softest) node = mesh_node(node);
    const std::string what = facts.weakest ? fmt::format("the pivot of node {} is zero",
                                                         mesh_node(static_cast<std::int32_t>(facts.weakest->row / 3)))
                                           : "K is singular";
    throw Error(fmt::format("{}: fixed: {} to rounding: {}", scene.file.string(), what,
                            describe_under_constrained(softest, body)));
}

void require_residual(const Scene& scene, double residual) {
    if (!(residual < kLargestResidual))
        throw Error(
            fmt::format("{}: the solves leave a residual of {:.3g}, more than {}: K is too badly conditioned; "
                        "mend slivers in the mesh, lower a Poisson's ratio near 0.5, or make regions, layers and "
                        "directions less unlike in stiffness",
                        scene.file.string(), residual, kLargestResidual));
}

}  // namespace haptable
