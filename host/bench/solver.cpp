// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/solver.hpp"

#include <algorithm>

#include "host/body/assembly.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

Solver::Solver(const std::filesystem::path& scene_file) {
    const Scene scene = read_scene(scene_file);
    body_ = make_body(scene, make_mesh(scene.mesh));
    factor_ = std::make_unique<Factor>(assemble_free(scene, body_));
    force_.resize(factor_->size(), 1);
}

const Eigen::MatrixXd& Solver::solve(const std::vector<NodalForce>& loads) {
    force_.setZero();
    for (const NodalForce& load : loads) {
        const std::int32_t unknown = body_.unknown[static_cast<std::size_t>(load.node)];
        for (int c = 0; unknown >= 0 && c < 3; ++c)
            force_(3 * unknown + c, 0) += static_cast<double>(load.force_n[static_cast<std::size_t>(c)]);
    }
    factor_->solve(force_, moved_);
    return moved_;
}

Eigen::Vector3d Solver::displacement(std::int32_t node) const {
    const std::int32_t unknown = body_.unknown[static_cast<std::size_t>(node)];
    if (unknown < 0) return Eigen::Vector3d::Zero();
    return moved_.block<3, 1>(Eigen::Index{3} * unknown, 0);
}

std::vector<NodalForce> three_loads(const Tables& tables, std::size_t patch) {
    std::vector<NodalForce> loads;
    for (std::int32_t node : tables.patch[patch]) loads.push_back({node, {0.3F, -0.2F, -0.9F}});
    return loads;
}

double displacement_error(Deformation& deformation, Solver& solver, const Tables& tables, std::size_t patches) {
    double worst = 0.0;
    for (std::size_t i = 0; i < patches; ++i) {
        const auto loads = three_loads(tables, i * tables.patch.size() / patches);
        const auto moved = deformation.displace(loads);
        solver.solve(loads);
        double largest = 0.0;
        double difference = 0.0;
        for (std::size_t r = 0; r < tables.row_id.size(); ++r) {
            const Eigen::Vector3d exact = solver.displacement(tables.row_id[r]);
            largest = std::max(largest, exact.norm());
            const Eigen::Vector3f drawn(moved[3 * r], moved[3 * r + 1], moved[3 * r + 2]);
            difference = std::max(difference, (drawn.cast<double>() - exact).norm());
        }
        if (largest > 0.0) worst = std::max(worst, difference / largest);  // 0: a patch of fixed nodes
    }
    return worst;
}

}  // namespace haptable
