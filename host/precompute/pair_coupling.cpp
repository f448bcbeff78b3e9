// SPDX-License-Identifier: GPL-2.0-or-later
// C_kl = w_k^T L w_l,   C ~ Phi Phi^T + E,   Phi Phi^T = C Q (Q^T C Q)^-1 Q^T C
#include "host/precompute/pair_coupling.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "firmware/haptable_pair.h"
#include "host/base/error.hpp"
#include "host/precompute/compliance.hpp"
#include "host/solve/dense.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Block = std::array<double, 9>;

constexpr std::size_t kBlockBytes = 36, kNearBytes = 20, kVectorBytes = 6, kBeginBytes = 4;
constexpr int kOversampled = 8;  // columns of the random basis beyond the rank

Eigen::Index dof(std::integral auto place) { return 3 * static_cast<Eigen::Index>(place); }

Block rows_of(const Matrix3d& m) {
    return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
Matrix3d matrix_of(const Block& b) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(b.data()); }

/// w_k^T L, [3, 3 m].
MatrixXd row_of(const PairControls& controls, const MatrixXd& l, std::size_t k) {
    const NodeWeights& w = controls.weights[k];
    MatrixXd row = MatrixXd::Zero(3, l.cols());
    for (std::size_t i = 0; i < w.node.size(); ++i) row += w.weight[i] * l.middleRows<3>(dof(w.node[i]));
    return row;
}

Matrix3d block_of(const PairControls& controls, const MatrixXd& row, std::size_t l) {
    const NodeWeights& w = controls.weights[l];
    Matrix3d block = Matrix3d::Zero();
    for (std::size_t i = 0; i < w.node.size(); ++i) block += w.weight[i] * row.middleCols<3>(dof(w.node[i]));
    return block;
}

/// W x: what loads on controls are on nodes; and W^T x.
MatrixXd to_nodes(const PairControls& controls, const MatrixXd& x) {
    MatrixXd y = MatrixXd::Zero(dof(controls.node.size()), x.cols());
    for (std::size_t k = 0; k < controls.weights.size(); ++k)
        for (std::size_t i = 0; i < controls.weights[k].node.size(); ++i)
            y.middleRows<3>(dof(controls.weights[k].node[i])) +=
                controls.weights[k].weight[i] * x.middleRows<3>(dof(k));
    return y;
}
MatrixXd to_controls(const PairControls& controls, const MatrixXd& x) {
    MatrixXd y = MatrixXd::Zero(dof(controls.weights.size()), x.cols());
    for (std::size_t k = 0; k < controls.weights.size(); ++k)
        for (std::size_t i = 0; i < controls.weights[k].node.size(); ++i)
            y.middleRows<3>(dof(k)) +=
                controls.weights[k].weight[i] * x.middleRows<3>(dof(controls.weights[k].node[i]));
    return y;
}

MatrixXd times_c(const PairControls& controls, const MatrixXd& l, const MatrixXd& x) {
    return to_controls(controls, product(l, to_nodes(controls, x)));
}

/// 1 / sqrt(|C_kk|) of every control, three rows each: what a far pair is off counts by what its places give way
/// themselves.
Eigen::VectorXd scale_of(const PairControls& controls, const MatrixXd& l) {
    Eigen::VectorXd scale(dof(controls.weights.size()));
    for (std::size_t k = 0; k < controls.weights.size(); ++k) {
        const double size = block_of(controls, row_of(controls, l, k), k).norm();
        scale.segment<3>(dof(k)).setConstant(size > 0.0 ? 1.0 / std::sqrt(size) : 0.0);
    }
    return scale;
}

/// Phi [3 n, r], the r largest of a Nystroem approximation of C over the mean of C_kk and C_ll.
MatrixXd far_field(const PairControls& controls, const MatrixXd& l, Eigen::Index rank) {
    const Eigen::VectorXd scale = scale_of(controls, l);
    const auto times = [&](const MatrixXd& x) {
        return MatrixXd(scale.asDiagonal() * times_c(controls, l, scale.asDiagonal() * x));
    };
    const Eigen::Index rows = dof(controls.weights.size()), columns = std::min(rows, rank + kOversampled);
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    MatrixXd q(rows, columns);
    for (Eigen::Index j = 0; j < columns; ++j)
        for (Eigen::Index i = 0; i < rows; ++i) q(i, j) = normal(random);
    for (int turn = 0; turn < 2; ++turn) q = orthonormal(times(q));
    const MatrixXd y = times(q), core = product(q.transpose(), y);
    // (Q^T C Q)^-1/2 by eigenvalues: those that are rounding are left out.
    const SymmetricEigen eigen = symmetric_eigen(0.5 * (core + core.transpose()));
    const double least = 1e-12 * eigen.values.tail<1>()[0];
    MatrixXd root = eigen.vectors;
    for (Eigen::Index j = 0; j < root.cols(); ++j)
        root.col(j) *= eigen.values[j] > least ? 1.0 / std::sqrt(eigen.values[j]) : 0.0;
    const MatrixXd phi = product(y, root);
    const MatrixXd turned = symmetric_eigen(product(phi.transpose(), phi)).vectors;
    const Eigen::VectorXd back = scale.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; });
    return back.asDiagonal() * product(phi, turned.rightCols(std::min(rank, columns)));
}

PairTables all_pairs(const PairControls& controls, const MatrixXd& l) {
    PairTables tables;
    for (std::size_t k = 0; k < controls.weights.size(); ++k) {
        const MatrixXd row = row_of(controls, l, k);
        for (std::size_t j = 0; j <= k; ++j) tables.block.push_back(rows_of(block_of(controls, row, j)));
    }
    return tables;
}

/// How much a far pair is off, over the mean of what each gives way itself: squared.
std::vector<float> lacking(const PairControls& controls, const MatrixXd& l, const MatrixXd& phi) {
    const std::size_t n = controls.weights.size();
    std::vector<double> own(n);
    std::vector<float> size;
    size.reserve(n * (n + 1) / 2);
    for (std::size_t k = 0; k < n; ++k) {
        const MatrixXd row = row_of(controls, l, k);
        own[k] = block_of(controls, row, k).norm();
        for (std::size_t j = 0; j <= k; ++j) {
            const Matrix3d e =
                block_of(controls, row, j) - phi.middleRows<3>(dof(k)) * phi.middleRows<3>(dof(j)).transpose();
            const double scale = own[k] * own[j];
            size.push_back(scale > 0.0 ? static_cast<float>(e.squaredNorm() / scale) : 0.0F);
        }
    }
    return size;
}

/// The largest `count` of what the far field lacks.
void add_near(const PairControls& controls, const MatrixXd& l, const MatrixXd& phi, std::size_t count,
              PairTables& tables) {
    const std::size_t n = controls.weights.size();
    const std::vector<float> size = lacking(controls, l, phi);
    std::vector<std::size_t> order(size.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    count = std::min(count, order.size());
    const auto larger = [&](std::size_t a, std::size_t b) { return size[a] != size[b] ? size[a] > size[b] : a < b; };
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(), larger);
    order.resize(count);
    std::sort(order.begin(), order.end());
    std::size_t next = 0;
    tables.near_begin.push_back(0);
    for (std::size_t k = 0; k < n; ++k) {
        const MatrixXd row = row_of(controls, l, k);
        for (; next < order.size() && order[next] < (k + 1) * (k + 2) / 2; ++next) {
            const std::size_t j = order[next] - k * (k + 1) / 2;
            tables.near.push_back(static_cast<std::int32_t>(j));
            tables.block.push_back(rows_of(block_of(controls, row, j) -
                                           phi.middleRows<3>(dof(k)) * phi.middleRows<3>(dof(j)).transpose()));
        }
        tables.near_begin.push_back(static_cast<std::uint32_t>(next));
    }
}

/// A far field of a rank, and near pairs in what is left of the bytes.
PairTables with_rank(const PairControls& controls, const MatrixXd& l, const MatrixXd& phi, std::uintmax_t near_bytes) {
    const std::size_t n = controls.weights.size();
    PairTables tables;
    tables.control_count = n;
    tables.rank = static_cast<std::size_t>(phi.cols());
    for (std::size_t k = 0; k < n; ++k)
        for (Eigen::Index j = 0; j < phi.cols(); ++j) {
            const Vector3d v = phi.block<3, 1>(dof(k), j);
            tables.column.push_back({v[0], v[1], v[2]});
        }
    add_near(controls, l, phi, (near_bytes - kVectorBytes * tables.column.size()) / kNearBytes, tables);
    return tables;
}

/// Of some ranks that leave at least half of the bytes to near pairs, the one whose forces are best.
PairTables low_rank(const PairControls& controls, const MatrixXd& l, double meeting_m, std::uintmax_t most_bytes,
                    const ContactOptions& contact) {
    constexpr std::size_t kTried = 1000;
    const std::size_t n = controls.weights.size(), begin = kBeginBytes * (n + 1);
    const std::uintmax_t least = begin + 2 * kVectorBytes * n;
    if (most_bytes < least)
        throw Error(
            fmt::format("tables.coupling_bytes = {} is too little for the coupling of {} places: give {} or "
                        "more, or touch a smaller region",
                        most_bytes, n, least));
    const auto most = std::min<std::uintmax_t>(HAPTABLE_PAIR_RANK, (most_bytes - begin) / 2 / (kVectorBytes * n));
    const MatrixXd phi = far_field(controls, l, static_cast<Eigen::Index>(most));
    PairTables best;
    double smallest = HUGE_VAL;
    for (Eigen::Index rank = phi.cols(); rank >= 1; rank /= 2) {
        PairTables tables = with_rank(controls, l, phi.rightCols(rank), most_bytes - begin);
        tables.meeting_m = meeting_m;
        const PairError error = measure_pair(controls, l, tables, contact, kTried);
        if (error.worst >= smallest) continue;
        smallest = error.worst;
        best = std::move(tables);
    }
    return best;
}

/// Masks by mesh nodes to places among the loaded nodes; a fixed node takes no load.
NodeWeights placed(const NodeWeights& mesh, const std::map<std::int32_t, std::int32_t>& place) {
    NodeWeights to;
    for (std::size_t i = 0; i < mesh.node.size(); ++i) {
        const auto found = place.find(mesh.node[i]);
        if (found == place.end()) continue;
        to.node.push_back(found->second);
        to.weight.push_back(mesh.weight[i]);
    }
    return to;
}

void load_masks(const Body& body, const Masks& masks, const std::vector<std::int32_t>& vertex, PairControls& controls) {
    std::map<std::int32_t, std::int32_t> place;
    for (std::size_t c = 0; c < masks.vertex.size() + masks.edge.size(); ++c)
        for (const std::int32_t node : masks.weights(c).node)
            if (!body.is_fixed(node)) place.emplace(node, 0);
    for (auto& [node, at] : place) {
        at = static_cast<std::int32_t>(controls.node.size());
        controls.node.push_back(node);
    }
    for (const std::int32_t node : vertex) {
        const auto at = std::lower_bound(masks.vertex_id.begin(), masks.vertex_id.end(), node);
        controls.weights.push_back(placed(masks.vertex[static_cast<std::size_t>(at - masks.vertex_id.begin())], place));
    }
    for (const NodeWeights& edge : masks.edge) controls.weights.push_back(placed(edge, place));
}

/// The servo's vertices: free ones in the tables' order, then the fixed ones, ascending.
std::vector<std::int32_t> vertices_of(const Body& body) {
    std::vector<std::int32_t> vertex = body.touch_node;
    for (const std::int32_t node : nodes_of(body.touch_patch))
        if (body.is_fixed(node)) vertex.push_back(node);
    return vertex;
}

void add_patches(const Body& body, const Masks& masks, const std::vector<std::int32_t>& vertex,
                 PairControls& controls) {
    std::map<std::int32_t, std::int32_t> of;
    for (std::size_t v = 0; v < vertex.size(); ++v) of[vertex[v]] = static_cast<std::int32_t>(v);
    for (const Patch& patch : body.touch_patch) {
        auto& control = controls.of.emplace_back(std::array<std::int32_t, 6>{-1, -1, -1, -1, -1, -1});
        auto& rigid = controls.rigid.emplace_back();
        auto& corner = controls.corner_m.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) {
            corner[c] = body.mesh.position_m[static_cast<std::size_t>(patch[c])];
            rigid[c] = body.is_fixed(patch[c]) ? 1.0 : 0.0;
            if (controls.is_mask || !body.is_fixed(patch[c])) control[c] = of.at(patch[c]);
            if (!controls.is_mask) continue;
            const auto [low, high] = std::minmax(patch[(c + 1) % 3], patch[(c + 2) % 3]);
            const auto edge = std::lower_bound(masks.edge_id.begin(), masks.edge_id.end(), std::array{low, high});
            control[3 + c] =
                static_cast<std::int32_t>(vertex.size()) + static_cast<std::int32_t>(edge - masks.edge_id.begin());
        }
    }
}

// ---- how good they are
// ------------------------------------------------------------------------------------------------

/// A place that is pressed: its controls with the matrices by which they take a displacement of 1, and what it gives
/// way alone.
struct Pressed {
    std::array<std::int32_t, 6> control{};
    std::array<Matrix3d, 6> share;
    Matrix3d own;
    Vector3d at_m, u_m;
};

class Presser {
public:
    Presser(const PairControls& controls, const MatrixXd& l, const ContactOptions& contact)
        : controls_(controls), l_(l), contact_(contact) {}

    Matrix3d block(std::size_t k, std::size_t l) const {
        const NodeWeights &a = controls_.weights[k], &b = controls_.weights[l];
        Matrix3d sum = Matrix3d::Zero();
        for (std::size_t i = 0; i < a.node.size(); ++i)
            for (std::size_t j = 0; j < b.node.size(); ++j)
                sum += a.weight[i] * b.weight[j] * l_.block<3, 3>(dof(a.node[i]), dof(b.node[j]));
        return sum;
    }

    Pressed press(std::size_t patch, const Vector3d& alpha, double depth_m) const {
        const auto& corner = controls_.corner_m[patch];
        Pressed to;
        to.control = controls_.of[patch];
        to.at_m = alpha[0] * corner[0] + alpha[1] * corner[1] + alpha[2] * corner[2];
        to.u_m = -depth_m * (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
        if (contact_.force == ForceLaw::kInterpolated)
            interpolate(patch, alpha, to);
        else
            comply(patch, alpha, to);
        return to;
    }

private:
    void interpolate(std::size_t patch, const Vector3d& alpha, Pressed& to) const {
        const double rigid = contact_.rigid_stiffness_n_per_m;
        std::array<Matrix3d, 3> s;
        Matrix3d sum = Matrix3d::Zero();
        for (std::size_t c = 0; c < 3; ++c) {
            const auto k = static_cast<std::size_t>(to.control[c]);
            s[c] = to.control[c] < 0 ? Matrix3d(rigid * Matrix3d::Identity()) : Matrix3d(block(k, k).inverse());
            sum += alpha[static_cast<Eigen::Index>(c)] * s[c];
        }
        to.own = sum.inverse();
        for (std::size_t c = 0; c < 3; ++c) to.share[c] = alpha[static_cast<Eigen::Index>(c)] * s[c] * to.own;
        for (std::size_t c = 3; c < 6; ++c) to.share[c] = Matrix3d::Zero();
        (void)patch;
    }

    void comply(std::size_t patch, const Vector3d& alpha, Pressed& to) const {
        double rigid = 0.0;
        for (Eigen::Index c = 0; c < 3; ++c) {
            const Eigen::Index a = (c + 1) % 3, b = (c + 2) % 3;
            const double corner = controls_.is_mask ? alpha[c] * alpha[c] : alpha[c];
            to.share[static_cast<std::size_t>(c)] = corner * Matrix3d::Identity();
            to.share[static_cast<std::size_t>(3 + c)] = 2.0 * alpha[a] * alpha[b] * Matrix3d::Identity();
            rigid += alpha[c] * controls_.rigid[patch][static_cast<std::size_t>(c)];
        }
        to.own = Matrix3d::Zero();
        for (std::size_t k = 0; k < 6; ++k)
            for (std::size_t j = 0; j < 6; ++j)
                if (to.control[k] >= 0 && to.control[j] >= 0)
                    to.own += to.share[k](0, 0) * to.share[j](0, 0) *
                              block(static_cast<std::size_t>(to.control[k]), static_cast<std::size_t>(to.control[j]));
        const double missing = rigid / contact_.rigid_stiffness_n_per_m - to.own.trace() / 3.0;
        if (rigid > 0.0 && missing > 0.0) to.own += missing * Matrix3d::Identity();
    }

    const PairControls& controls_;
    const MatrixXd& l_;
    const ContactOptions& contact_;
};

using Pair = Eigen::Matrix<double, 6, 6>;

template <typename BlockOf>
Pair compliance_of(const Pressed& a, const Pressed& b, double meeting_m, const BlockOf& block) {
    Matrix3d x = Matrix3d::Zero();
    for (std::size_t k = 0; k < 6; ++k)
        for (std::size_t j = 0; j < 6; ++j)
            if (a.control[k] >= 0 && b.control[j] >= 0)
                x += a.share[k].transpose() *
                     block(static_cast<std::size_t>(a.control[k]), static_cast<std::size_t>(b.control[j])) * b.share[j];
    const double near = std::max(0.0, 1.0 - (a.at_m - b.at_m).squaredNorm() / (meeting_m * meeting_m));
    x *= 1.0 - static_cast<double>(HAPTABLE_PAIR_MEETING) * near * near;
    Pair c;
    c << a.own, x, x.transpose(), b.own;
    return c;
}

double least_eigenvalue(const MatrixXd& symmetric) { return symmetric_eigenvalues(symmetric)[0]; }

}  // namespace

PairControls pair_controls(const Scene& scene, const Body& body, const Masks& masks) {
    PairControls controls;
    controls.is_mask = scene.contact.force == ForceLaw::kPressureMask;
    const std::vector<std::int32_t> vertex = vertices_of(body);
    if (controls.is_mask) {
        load_masks(body, masks, vertex, controls);
    } else {
        controls.node = body.touch_node;
        for (std::size_t i = 0; i < controls.node.size(); ++i)
            controls.weights.push_back({{static_cast<std::int32_t>(i)}, {1.0}});
    }
    add_patches(body, masks, vertex, controls);
    return controls;
}

double meeting_distance(const Scene& scene, const Body& body) {
    if (scene.contact.mask_radius_m > 0.0) return scene.contact.mask_radius_m;
    double sum = 0.0;
    for (const Patch& patch : body.touch_patch)
        for (std::size_t c = 0; c < 3; ++c)
            sum += (body.mesh.position_m[static_cast<std::size_t>(patch[c])] -
                    body.mesh.position_m[static_cast<std::size_t>(patch[(c + 1) % 3])])
                       .norm();
    return 0.5 * sum / (3.0 * static_cast<double>(body.touch_patch.size()));
}

double pair_memory(const PairControls& controls) {
    return 9.0 * sizeof(double) * std::pow(static_cast<double>(controls.node.size()), 2.0);
}

MatrixXd loaded_compliance(const LinearSolver& inverse, const PairControls& controls,
                           std::span<const std::int32_t> unknown, Progress& progress) {
    const std::size_t count = controls.node.size();
    MatrixXd l(dof(count), dof(count)), b, x;
    const auto at = [&](std::size_t i) { return dof(unknown[static_cast<std::size_t>(controls.node[i])]); };
    for (std::size_t first = 0; first < count; first += kNodesPerBlock) {
        progress.done(static_cast<double>(first) / static_cast<double>(count));
        const std::size_t some = std::min(kNodesPerBlock, count - first);
        b.setZero(inverse.size(), dof(some));
        for (std::size_t c = 0; c < some; ++c) b.block<3, 3>(at(first + c), dof(c)).setIdentity();
        inverse.solve(b, x);
        for (std::size_t i = 0; i < count; ++i) l.block(dof(i), dof(first), 3, dof(some)) = x.middleRows<3>(at(i));
    }
    return 0.5 * (l + l.transpose());
}

PairTables make_pair_tables(const PairControls& controls, const MatrixXd& l, double meeting_m,
                            std::uintmax_t most_bytes, const ContactOptions& contact) {
    const std::size_t n = controls.weights.size();
    if (n >= HAPTABLE_NONE)
        throw Error(fmt::format("two fingers couple {} places, more than the servo's {}: touch a smaller region", n,
                                HAPTABLE_NONE - 1));
    PairTables tables = kBlockBytes * n * (n + 1) / 2 <= most_bytes
                            ? all_pairs(controls, l)
                            : low_rank(controls, l, meeting_m, most_bytes, contact);
    tables.control_count = n;
    tables.meeting_m = meeting_m;
    return tables;
}

Matrix3d pair_block(const PairTables& tables, std::size_t k, std::size_t l) {
    if (k < l) return pair_block(tables, l, k).transpose();
    if (tables.is_exact()) return matrix_of(tables.block[k * (k + 1) / 2 + l]);
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t j = 0; j < tables.rank; ++j) {
        const Eigen::Map<const Vector3d> a(tables.column[k * tables.rank + j].data());
        const Eigen::Map<const Vector3d> b(tables.column[l * tables.rank + j].data());
        sum += a * b.transpose();
    }
    const auto first = tables.near.begin() + tables.near_begin[k],
               last = tables.near.begin() + tables.near_begin[k + 1];
    const auto found = std::lower_bound(first, last, static_cast<std::int32_t>(l));
    if (found != last && *found == static_cast<std::int32_t>(l))
        sum += matrix_of(tables.block[static_cast<std::size_t>(found - tables.near.begin())]);
    return sum;
}

PairError measure_pair(const PairControls& controls, const MatrixXd& l, const PairTables& tables,
                       const ContactOptions& contact, std::size_t places) {
    const Presser presser(controls, l, contact);
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> patch(0, controls.of.size() - 1);
    std::exponential_distribution<double> part;
    std::uniform_real_distribution<double> depth(0.5, 1.0);
    const auto press = [&] {
        const Vector3d alpha(part(random), part(random), part(random));
        return presser.press(patch(random), alpha / alpha.sum(), depth(random));
    };
    std::vector<double> error;
    PairError to{places, 0.0, 0.0, HUGE_VAL, 0};
    while (error.size() < places) {
        const Pressed a = press(), b = press();
        if (!(a.own.trace() > 0.0 && b.own.trace() > 0.0)) continue;
        Eigen::Vector<double, 6> u;
        u << a.u_m, b.u_m;
        const Pair exact = compliance_of(a, b, tables.meeting_m, [&](auto k, auto j) { return presser.block(k, j); });
        const Pair kept =
            compliance_of(a, b, tables.meeting_m, [&](auto k, auto j) { return pair_block(tables, k, j); });
        const Eigen::Vector<double, 6> f = solve_spd(exact, u), g = solve_spd(kept, u);
        error.push_back((f - g).norm() / f.norm());
        to.least =
            std::min(to.least, least_eigenvalue(kept) / std::min(least_eigenvalue(a.own), least_eigenvalue(b.own)));
        to.meeting += (a.at_m - b.at_m).norm() < tables.meeting_m ? 1U : 0U;
    }
    std::sort(error.begin(), error.end());
    to.worst = error.back();
    to.p99 = error[error.size() * 99 / 100];
    return to;
}

}  // namespace haptable
