// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/polynomial.hpp"

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

double factorial(int n) {
    double product = 1.0;
    for (int k = 2; k <= n; ++k) product *= k;
    return product;
}

/// Exponents of a patch's control points.
std::vector<std::array<int, 3>> exponents(int degree) {
    std::vector<std::array<int, 3>> all;
    for (int i = 0; i <= degree; ++i)
        for (int j = 0; i + j <= degree; ++j) all.push_back({i, j, degree - i - j});
    return all;
}

std::size_t control_block(const ServoModel& model, std::size_t patch, const std::array<int, 3>& n) {
    const ServoCompliance& c = model.compliance;
    const auto& v = model.patch[patch];
    const auto per_edge = static_cast<std::size_t>(c.degree - 1);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        if (n[k] == c.degree) return v[k];
        if (n[k] != 0 || n[a] == 0 || n[b] == 0) continue;
        const auto from_low = static_cast<std::size_t>((v[a] < v[b] ? n[b] : n[a]) - 1);
        return c.vertex.size() + c.patch_edge[patch][k] * per_edge + from_low;
    }
    const auto corner = static_cast<std::size_t>(n[0] == 2 ? 0 : n[1] == 2 ? 1 : 2);
    return c.vertex.size() + c.edge.size() + 3 * patch + corner;
}

}  // namespace

BernsteinPoint::BernsteinPoint(int degree, const std::array<double, 3>& at_alpha) : alpha(at_alpha) {
    for (const std::array<int, 3>& n : exponents(degree)) {
        double polynomial = factorial(degree);
        for (std::size_t k = 0; k < 3; ++k) polynomial *= std::pow(alpha[k], n[k]) / factorial(n[k]);
        weight.push_back(polynomial);
    }
}

std::vector<std::size_t> control_blocks(const ServoModel& model, std::size_t patch) {
    std::vector<std::size_t> blocks;
    for (const std::array<int, 3>& n : exponents(model.compliance.degree))
        blocks.push_back(control_block(model, patch, n));
    return blocks;
}

std::vector<std::array<float, 6>> compliance_blocks(const ServoModel& model) {
    std::vector<std::array<float, 6>> blocks;
    for (const auto* list : {&model.compliance.vertex, &model.compliance.edge, &model.compliance.patch})
        blocks.insert(blocks.end(), list->begin(), list->end());
    return blocks;
}

Eigen::Matrix3d compliance_at(const ServoModel& model, std::size_t patch, const std::vector<Eigen::Matrix3d>& control,
                              const BernsteinPoint& point) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    double fixed = 0.0;
    for (std::size_t n = 0; n < control.size(); ++n) sum += point.weight[n] * control[n];
    for (std::size_t k = 0; k < 3; ++k)
        if (model.patch[patch][k] >= model.free_count) fixed += point.alpha[k];
    if (fixed > 0.0)
        sum += std::max(0.0, fixed / static_cast<double>(model.rigid_stiffness_n_per_m) - sum.trace() / 3.0) *
               Eigen::Matrix3d::Identity();
    return sum;
}

Eigen::Matrix3d symmetric(const std::array<float, 6>& block) {
    const auto s = [&](std::size_t i) { return static_cast<double>(block[i]); };
    Eigen::Matrix3d m;
    m << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
    return m;
}

}  // namespace haptable
