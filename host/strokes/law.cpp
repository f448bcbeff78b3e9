// SPDX-License-Identifier: GPL-2.0-or-later
// P(alpha) = sum degree! / (i! j! k!) alpha_0^i alpha_1^j alpha_2^k B_ijk;   S = P of degree 1, or C = P and S = C^-1
#include "host/strokes/law.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "host/strokes/motion.hpp"

namespace haptable {

namespace {

// What is left of each place's compliance by itself, at the least: the mean of C_1^-1 N.
constexpr double kLeastOwn = 1.0 / 64.0;

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d matrix_of(const std::array<double, 9>& rows) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

/// What f^T B f sees of it.
Matrix3d symmetric(const Matrix3d& b) { return 0.5 * (b + b.transpose()); }

double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

double power(double x, int n) {
    double product = 1.0;
    for (; n > 0; --n) product *= x;
    return product;
}

/// What controls of a place weigh: corners, then of a mask the edges opposite to them.
std::array<double, HAPTABLE_PAIR_CONTROLS> weights_of(const haptable_pair_law& law, const SurfacePoint& g) {
    std::array<double, HAPTABLE_PAIR_CONTROLS> weight{};
    const auto a = [&](std::size_t k) { return g.alpha[static_cast<int>(k % 3)]; };
    for (std::size_t k = 0; k < 3; ++k) {
        weight[k] = law.controls == 3 ? a(k) : a(k) * a(k);
        if (law.controls == HAPTABLE_PAIR_CONTROLS) weight[3 + k] = 2.0 * a(k + 1) * a(k + 2);
    }
    return weight;
}

}  // namespace

Vector3d corner_of(const ServoModel& servo, std::size_t patch, std::size_t corner) {
    return to_vector(servo.vertex_m[servo.patch[patch][corner]].data());
}

Vector3d point_of(const ServoModel& servo, const SurfacePoint& g) {
    return g.alpha[0] * corner_of(servo, g.patch, 0) + g.alpha[1] * corner_of(servo, g.patch, 1) +
           g.alpha[2] * corner_of(servo, g.patch, 2);
}

Law::Law(const Tables& tables, const ServoModel& servo)
    : servo_(servo),
      degree_(std::max(1, tables.compliance.degree)),
      rigid_n_per_m_(tables.rigid_stiffness_n_per_m),
      curve_(tables.stiffening) {
    for (int i = degree_; i >= 0; --i)
        for (int j = degree_ - i, k = 0; j >= 0; --j, ++k)
            term_.push_back({{i, j, k}, factorial(degree_) / factorial(i) / factorial(j) / factorial(k)});
    for (const auto& edge : tables.compliance.edge_id) edge_.emplace(edge, edge_.size());
    for (std::size_t p = 0; p < servo.patch.size(); ++p)
        for (const Term& term : term_) control_.push_back(symmetric(control(tables, p, term.exponent)));
    if (degree_ != 2) return;
    for (const auto& v : servo.patch) {
        auto& pairs = pair_.emplace_back();
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b)
                if (v[a] >= servo.free_count || v[b] >= servo.free_count)
                    pairs[3 * a + b].setZero();
                else
                    pairs[3 * a + b] =
                        a == b ? vertex_compliance(tables, v[a]) : edge_compliance(tables, v[a], v[b], 0);
    }
}

Matrix3d Law::vertex_compliance(const Tables& tables, std::uint16_t vertex) const {
    const ComplianceTables& from = tables.compliance;
    if (degree_ == 4) {
        const auto at = std::find(from.vertex_id.begin(), from.vertex_id.end(), servo_.node[vertex]);
        return matrix_of(from.vertex[static_cast<std::size_t>(at - from.vertex_id.begin())]);
    }
    if (vertex >= servo_.free_count) return Block::Zero();
    return matrix_of(tables.stiffness[vertex]).inverse();
}

/// Rows are a's; that far from a. The tables begin at the node with the lower number.
Matrix3d Law::edge_compliance(const Tables& tables, std::size_t a, std::size_t b, int from_a) const {
    const std::int32_t node_a = servo_.node[a], node_b = servo_.node[b];
    if (node_b < node_a) return edge_compliance(tables, b, a, degree_ - 2 - from_a).transpose();
    const auto per_edge = static_cast<std::size_t>(degree_ - 1);
    return matrix_of(tables.compliance.edge[edge_.at({node_a, node_b}) * per_edge + static_cast<std::size_t>(from_a)]);
}

/// S_a of a corner, rigid where fixed; or B_ijk as docs/SPEC.md has them: of vertices, of edges, and within patches.
Matrix3d Law::control(const Tables& tables, std::size_t patch, const std::array<int, 3>& n) const {
    const auto& v = servo_.patch[patch];
    const auto whole = static_cast<std::size_t>(std::max_element(n.begin(), n.end()) - n.begin());
    const auto none = static_cast<std::size_t>(std::min_element(n.begin(), n.end()) - n.begin());
    if (degree_ == 1 && v[whole] >= servo_.free_count) return rigid_n_per_m_ * Block::Identity();
    if (degree_ == 1) return matrix_of(tables.stiffness[v[whole]]);
    if (n[whole] == degree_) return vertex_compliance(tables, v[whole]);
    if (n[none] != 0) return matrix_of(tables.compliance.patch[3 * servo_.leaf_order[patch] + whole]);
    const std::size_t a = (none + 1) % 3, b = (none + 2) % 3;
    return edge_compliance(tables, v[a], v[b], n[b] - 1);
}

Matrix3d Law::polynomial(const SurfacePoint& g) const {
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t n = 0; n < term_.size(); ++n) {
        const auto& [e, multinomial] = term_[n];
        const double weight = multinomial * power(g.alpha[0], e[0]) * power(g.alpha[1], e[1]) * power(g.alpha[2], e[2]);
        sum += weight * control_[g.patch * term_.size() + n];
    }
    return sum;
}

/// C + max(0, s / rigid_stiffness - trace C / 3) I, s the share of alpha on fixed vertices.
double Law::lift(const SurfacePoint& g, const Matrix3d& c) const {
    double share = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
        if (servo_.patch[g.patch][k] >= servo_.free_count) share += g.alpha[static_cast<Eigen::Index>(k)];
    return share > 0.0 ? std::max(0.0, share / rigid_n_per_m_ - c.trace() / 3.0) : 0.0;
}

Matrix3d Law::stiffness(const SurfacePoint& g) const {
    Matrix3d p = polynomial(g);
    if (degree_ == 1) return p;
    return (p + lift(g, p) * Matrix3d::Identity()).inverse();
}

/// sum w_k w_l C_kl by the pair's tables.
Matrix3d Law::coupling(const haptable_pair_model& pair, const SurfacePoint& one, const SurfacePoint& other) const {
    constexpr std::size_t kMost = HAPTABLE_PAIR_CONTROLS;
    const std::size_t controls = pair.law->controls;
    const auto v = weights_of(*pair.law, one), w = weights_of(*pair.law, other);
    std::array<float[9], kMost * kMost> blocks;
    pair.blocks(&pair, static_cast<std::uint16_t>(one.patch), static_cast<std::uint16_t>(other.patch), blocks.data());
    Matrix3d x = Matrix3d::Zero();
    for (std::size_t k = 0; k < controls; ++k)
        for (std::size_t l = 0; l < controls; ++l)
            x += v[k] * w[l] *
                 Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(blocks[k * controls + l]).cast<double>();
    return x;
}

Eigen::MatrixXd Law::compliance(const haptable_pair_model& pair, const std::vector<SurfacePoint>& g) const {
    const auto n = static_cast<Eigen::Index>(g.size());
    Eigen::MatrixXd c(3 * n, 3 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const SurfacePoint& at = g[static_cast<std::size_t>(i)];
        c.block<3, 3>(3 * i, 3 * i) = stiffness(at).inverse();
        for (Eigen::Index j = 0; j < i; ++j) {
            c.block<3, 3>(3 * i, 3 * j) = coupling(pair, at, g[static_cast<std::size_t>(j)]);
            c.block<3, 3>(3 * j, 3 * i) = c.block<3, 3>(3 * i, 3 * j).transpose();
        }
    }
    return c;
}

Eigen::Matrix<double, 6, 6> Law::stiffness_of_two(const haptable_pair_model& pair,
                                                  const std::array<SurfacePoint, 2>& g) const {
    const std::array<Matrix3d, 2> c{stiffness(g[0]).inverse(), stiffness(g[1]).inverse()};
    Matrix3d x = coupling(pair, g[0], g[1]);
    const double apart2 = (point_of(servo_, g[0]) - point_of(servo_, g[1])).squaredNorm();
    const double near = std::max(0.0, 1.0 - apart2 / std::pow(static_cast<double>(pair.meeting_m), 2));
    x *= 1.0 - static_cast<double>(HAPTABLE_PAIR_MEETING) * near * near;
    if (pair.law->is_stiffness != 0) x = c[0] * x * c[1];
    const double left = 1.0 - (c[0].inverse() * x * c[1].inverse() * x.transpose()).trace() / 3.0;
    if (left < kLeastOwn) x *= std::sqrt((1.0 - kLeastOwn) / (1.0 - left));
    Eigen::Matrix<double, 6, 6> both;
    both << c[0], x, x.transpose(), c[1];
    return both.inverse();
}

Matrix3d Law::nodal_forces(const SurfacePoint& g, const Matrix3d& s, const Vector3d& u) const {
    Matrix3d forces = s * u * g.alpha.transpose();
    for (std::size_t c = 0; degree_ == 1 && c < 3; ++c)
        forces.col(static_cast<int>(c)) = g.alpha[static_cast<int>(c)] * (control_[3 * g.patch + c] * u);
    return forces;
}

bool Law::draws(const SurfacePoint& g) const { return degree_ == 2 && lift(g, polynomial(g)) == 0.0; }

Vector3d Law::drawn(const SurfacePoint& g, const Matrix3d& nodal_n) const {
    Vector3d moved = Vector3d::Zero();
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b < 3; ++b)
            moved += g.alpha[static_cast<int>(a)] * (pair_[g.patch][3 * a + b] * nodal_n.col(static_cast<int>(b)));
    return moved;
}

}  // namespace haptable
