// SPDX-License-Identifier: GPL-2.0-or-later
// C_kl = w_k^T L w_l
#include "host/compliance/pair_coupling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "codegen/pair.hpp"
#include "host/base/error.hpp"
#include "host/base/index.hpp"
#include "host/compliance/compliance.hpp"
#include "host/compliance/pair_clusters.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Block = std::array<double, 9>;

constexpr std::size_t kBlockBytes = 36, kLoadBytes = 14, kBeginBytes = 4, kPlaceBytes = 2;
constexpr double kShareSteps = 32767.0;
/// Of what is in clusters (cluster_pairs). Controls of masks are only tried where each two of their clusters have so
/// many bytes: with fewer they never reach theirs.
constexpr double kMostBound = 0.25, kMostControlBound = 0.01;
constexpr std::size_t kControlBytes = 80;

Block rows_of(const Matrix3d& m) {
    return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}
Matrix3d matrix_of(const Block& b) { return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(b.data()); }

/// w_k^T L, [3, 3 m], by columns of the symmetric L, which lie together.
MatrixXd row_of(const PairControls& controls, const MatrixXd& l, std::size_t k) {
    const NodeWeights& w = controls.weights[k];
    MatrixXd column = MatrixXd::Zero(l.rows(), 3);
    for (std::size_t i = 0; i < w.node.size(); ++i) column += w.weight[i] * l.middleCols<3>(dof(w.node[i]));
    return column.transpose();
}

Matrix3d block_of(const PairControls& controls, const MatrixXd& row, std::size_t l) {
    const NodeWeights& w = controls.weights[l];
    Matrix3d block = Matrix3d::Zero();
    for (std::size_t i = 0; i < w.node.size(); ++i) block += w.weight[i] * row.middleCols<3>(dof(w.node[i]));
    return block;
}

PairTables all_pairs(const PairControls& controls, const MatrixXd& l) {
    PairTables tables;
    for (std::size_t k = 0; k < controls.weights.size(); ++k) {
        const MatrixXd row = row_of(controls, l, k);
        for (std::size_t j = 0; j <= k; ++j) tables.block.push_back(rows_of(block_of(controls, row, j)));
    }
    return tables;
}

/// S = C_kk^-1 of every node.
std::vector<Matrix3d> stiffness_of(const MatrixXd& l) {
    std::vector<Matrix3d> s;
    for (Eigen::Index k = 0; k < l.rows(); k += 3) s.push_back(l.block<3, 3>(k, k).inverse());
    return s;
}

/// Pairs of free corners of patches with a fixed one.
std::set<std::pair<std::size_t, std::size_t>> beside_fixed(const PairControls& controls) {
    std::set<std::pair<std::size_t, std::size_t>> to;
    for (const auto& control : controls.of)
        if (!controls.is_mask && std::min({control[0], control[1], control[2]}) < 0)
            for (std::size_t c = 0; c < 3; ++c)
                if (const auto [low, high] = std::minmax(control[c], control[(c + 1) % 3]); low >= 0)
                    to.emplace(low, high);
    return to;
}

/// Coupling of the loaded nodes, as the force asks for them: S_k L_kl S_l, or L_kl.
PlaceMatrix node_matrix(const PairControls& controls, const MatrixXd& l, bool is_stiffness) {
    const auto rows = [&l, s = is_stiffness ? stiffness_of(l)
                                            : std::vector<Matrix3d>{}](const std::vector<std::size_t>& place) {
        MatrixXd to(dof(place.size()), l.cols());
        for (std::size_t i = 0; i < place.size(); ++i) {
            to.middleRows<3>(dof(i)) = l.middleRows<3>(dof(place[i]));
            if (!s.empty()) to.middleRows<3>(dof(i)) = s[place[i]] * to.middleRows<3>(dof(i)).eval();
        }
        for (std::size_t j = 0; j < s.size(); ++j) to.middleCols<3>(dof(j)) = to.middleCols<3>(dof(j)).eval() * s[j];
        return to;
    };
    return {controls.node_m, rows, beside_fixed(controls)};
}

/// Vertices, and the middles of edges.
std::vector<Vector3d> positions_of(const PairControls& controls) {
    std::vector<Vector3d> position(controls.weights.size(), Vector3d::Zero());
    for (std::size_t p = 0; p < controls.of.size(); ++p)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto& corner = controls.corner_m[p];
            position[static_cast<std::size_t>(controls.of[p][c])] = corner[c];
            position[static_cast<std::size_t>(controls.of[p][3 + c])] =
                0.5 * (corner[(c + 1) % 3] + corner[(c + 2) % 3]);
        }
    return position;
}

/// Coupling of the controls themselves: W L W^T.
PlaceMatrix control_matrix(const PairControls& controls, const MatrixXd& l) {
    const auto rows = [&](const std::vector<std::size_t>& place) {
        MatrixXd to(dof(place.size()), dof(controls.weights.size()));
        for (std::size_t i = 0; i < place.size(); ++i) {
            const MatrixXd row = row_of(controls, l, place[i]);
            for (std::size_t k = 0; k < controls.weights.size(); ++k)
                to.block<3, 3>(dof(i), dof(k)) = block_of(controls, row, k);
        }
        return to;
    };
    return {positions_of(controls), rows, {}};
}

/// The nodes of each patch that its controls load, with each one's share of every control.
using Loads = std::vector<std::map<std::int32_t, std::array<double, 6>>>;

Loads loads_of(const PairControls& controls) {
    Loads loads;
    for (const auto& control : controls.of) {
        auto& load = loads.emplace_back();
        for (std::size_t c = 0; c < 6; ++c) {
            const NodeWeights& w = controls.weights[static_cast<std::size_t>(control[c])];
            for (std::size_t i = 0; i < w.node.size(); ++i) load[w.node[i]][c] += w.weight[i];
        }
    }
    return loads;
}

std::size_t most_loaded(const Loads& loads) {
    std::size_t most = 0;
    for (const auto& load : loads) most = std::max(most, load.size());
    return most;
}

/// Two patches have fewer blocks of their controls than of the nodes that these load, in the mean.
bool has_fewer_controls(const Loads& loads) {
    std::size_t pairs = 0;
    for (const auto& load : loads) pairs += load.size() * load.size();
    return pairs > 36 * loads.size();
}

std::size_t load_bytes(const Loads& loads) {
    std::size_t bytes = kBeginBytes * (loads.size() + 1);
    for (const auto& load : loads) bytes += kLoadBytes * load.size();
    return bytes;
}

/// place: of each node.
void add_loads(const Loads& loads, const std::vector<std::int32_t>& place, PairClusters& to) {
    to.load_begin.push_back(0);
    for (const auto& load : loads) {
        std::map<std::int32_t, std::array<double, 6>> placed;
        for (const auto& [node, share] : load) placed[place[static_cast<std::size_t>(node)]] = share;
        for (const auto& [at, share] : placed) {
            to.load_place.push_back(at);
            auto& steps = to.load_share.emplace_back();
            for (std::size_t c = 0; c < 6; ++c)
                steps[c] = static_cast<std::int16_t>(std::lround(kShareSteps * share[c]));
        }
        to.load_begin.push_back(static_cast<std::int32_t>(to.load_place.size()));
    }
}

std::vector<std::int32_t> inverse_of(const std::vector<std::size_t>& order) {
    std::vector<std::int32_t> place(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<std::int32_t>(i);
    return place;
}

/// Clusters of these places, within so many bytes with `besides`; `least` do for the bound. Exact where they do not
/// fit.
PairTables clustered(const PlaceMatrix& a, std::uintmax_t most_bytes, std::size_t besides, double most_bound,
                     std::vector<std::int32_t>& place, std::size_t& least, Progress& progress) {
    std::vector<std::size_t> order;
    PairTables tables;
    tables.clusters =
        cluster_pairs(a, most_bytes > besides ? most_bytes - besides : 0, most_bound, order, least, progress);
    place = inverse_of(order);
    least += besides;
    return tables;
}

/// Clusters of what is loaded: the controls' nodes. Of masks the controls themselves, where these are fewer and fit,
/// for a tick then takes half of the time; or where a patch loads more nodes than the servo has room for.
PairTables in_clusters(const PairControls& controls, const MatrixXd& l, std::uintmax_t most_bytes,
                       const ContactOptions& contact, Progress& progress) {
    const Loads loads = controls.is_mask ? loads_of(controls) : Loads{};
    const std::size_t n = controls.weights.size();
    const bool has_room = most_loaded(loads) <= kMostLoaded;
    std::vector<std::int32_t> place;
    PairTables tables;
    std::size_t least = 0;
    if (!has_room || (has_fewer_controls(loads) && most_bytes >= kControlBytes * core_count(n)))
        tables = clustered(control_matrix(controls, l), most_bytes, kPlaceBytes * n,
                           has_room ? kMostControlBound : kMostBound, place, least, progress);
    const bool is_loaded = controls.is_mask && has_room && tables.is_exact();
    if (is_loaded || !controls.is_mask)
        tables = clustered(node_matrix(controls, l, contact.force == ForceLaw::kInterpolated), most_bytes,
                           is_loaded ? load_bytes(loads) : kPlaceBytes * n, kMostBound, place, least, progress);
    if (tables.is_exact())
        throw Error(
            fmt::format("tables.coupling_bytes = {} is too little for the coupling of {} places: give {} or "
                        "more, or touch a smaller region",
                        most_bytes, place.size(), least));
    if (is_loaded)
        add_loads(loads, place, tables.clusters);
    else
        tables.clusters.place = place;
    return tables;
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
    std::size_t patch = 0;
    std::array<std::int32_t, 6> control{};
    std::array<double, 6> weight{};
    std::vector<std::pair<std::int32_t, double>> node;  // loaded, of the forces by a compliance
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

    /// C_12 of the nodes' own.
    Matrix3d between(const Pressed& a, const Pressed& b) const {
        Matrix3d sum = Matrix3d::Zero();
        for (const auto& [i, v] : a.node)
            for (const auto& [j, w] : b.node) sum += v * w * l_.block<3, 3>(dof(i), dof(j));
        return sum;
    }

    Pressed press(std::size_t patch, const Vector3d& alpha, double depth_m) const {
        const auto& corner = controls_.corner_m[patch];
        Pressed to;
        to.patch = patch;
        to.control = controls_.of[patch];
        to.at_m = alpha[0] * corner[0] + alpha[1] * corner[1] + alpha[2] * corner[2];
        to.u_m = -depth_m * (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
        if (contact_.force == ForceLaw::kInterpolated)
            interpolate(alpha, to);
        else
            comply(patch, alpha, to);
        return to;
    }

private:
    void interpolate(const Vector3d& alpha, Pressed& to) const {
        const double rigid = contact_.rigid_stiffness_n_per_m;
        std::array<Matrix3d, 3> s;
        Matrix3d sum = Matrix3d::Zero();
        for (std::size_t c = 0; c < 3; ++c) {
            const auto k = static_cast<std::size_t>(to.control[c]);
            s[c] = to.control[c] < 0 ? Matrix3d(rigid * Matrix3d::Identity()) : Matrix3d(block(k, k).inverse());
            sum += alpha[static_cast<Eigen::Index>(c)] * s[c];
        }
        to.own = sum.inverse();
        for (std::size_t c = 0; c < 3; ++c) {
            to.weight[c] = alpha[static_cast<Eigen::Index>(c)];
            to.share[c] = to.weight[c] * s[c] * to.own;
        }
        for (std::size_t c = 3; c < 6; ++c) to.share[c] = Matrix3d::Zero();
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
        for (std::size_t k = 0; k < 6; ++k) to.weight[k] = to.share[k](0, 0);
        std::map<std::int32_t, double> load;
        for (std::size_t k = 0; k < 6; ++k) {
            if (to.control[k] < 0) continue;
            const NodeWeights& w = controls_.weights[static_cast<std::size_t>(to.control[k])];
            for (std::size_t i = 0; i < w.node.size(); ++i) load[w.node[i]] += to.weight[k] * w.weight[i];
        }
        to.node.assign(load.begin(), load.end());
        to.own = between(to, to);
        const double missing = rigid / contact_.rigid_stiffness_n_per_m - to.own.trace() / 3.0;
        if (rigid > 0.0 && missing > 0.0) to.own += missing * Matrix3d::Identity();
    }

    const PairControls& controls_;
    const MatrixXd& l_;
    const ContactOptions& contact_;
};

using Pair = Eigen::Matrix<double, 6, 6>;

/// C_12 from blocks of controls.
template <typename BlockOf>
Matrix3d cross_of(const Pressed& a, const Pressed& b, const BlockOf& block) {
    Matrix3d x = Matrix3d::Zero();
    for (std::size_t k = 0; k < 6; ++k)
        for (std::size_t j = 0; j < 6; ++j)
            if (a.control[k] >= 0 && b.control[j] >= 0)
                x += a.share[k].transpose() *
                     block(static_cast<std::size_t>(a.control[k]), static_cast<std::size_t>(b.control[j])) * b.share[j];
    return x;
}

/// The places of the tables that are loaded, and how much.
std::vector<std::pair<std::size_t, double>> loaded(const PairClusters& clusters, const Pressed& by) {
    std::vector<std::pair<std::size_t, double>> to;
    if (clusters.load_begin.empty()) {
        for (std::size_t c = 0; c < 6; ++c)
            if (by.control[c] >= 0 && by.weight[c] != 0.0)
                to.emplace_back(clusters.place[static_cast<std::size_t>(by.control[c])], by.weight[c]);
        return to;
    }
    for (auto i = static_cast<std::size_t>(clusters.load_begin[by.patch]);
         i < static_cast<std::size_t>(clusters.load_begin[by.patch + 1]); ++i) {
        double weight = 0.0;
        for (std::size_t c = 0; c < 6; ++c) weight += by.weight[c] * clusters.load_share[i][c] / kShareSteps;
        to.emplace_back(clusters.load_place[i], weight);
    }
    return to;
}

/// C_12 of the tables.
Matrix3d kept_cross(const PairTables& tables, const Pressed& a, const Pressed& b, bool is_stiffness) {
    if (tables.is_exact()) return cross_of(a, b, [&](auto k, auto j) { return pair_block(tables, k, j); });
    Matrix3d x = Matrix3d::Zero();
    const auto other = loaded(tables.clusters, b);
    for (const auto& [i, v] : loaded(tables.clusters, a))
        for (const auto& [j, w] : other) x += v * w * cluster_block(tables.clusters, i, j);
    return is_stiffness ? Matrix3d(a.own * x * b.own) : x;
}

/// C of the pair, as the servo solves it: the coupling fades where they meet, and where two places load one node alone,
/// and so alike, what the second leaves of C_11 is lifted to a 64th of it.
Pair compliance_of(const Pressed& a, const Pressed& b, double meeting_m, Matrix3d x, bool is_stiffness) {
    constexpr double kLeast = 1.0 / 64.0;
    const double near = std::max(0.0, 1.0 - (a.at_m - b.at_m).squaredNorm() / (meeting_m * meeting_m));
    x *= 1.0 - static_cast<double>(HAPTABLE_PAIR_MEETING) * near * near;
    const Matrix3d left = a.own - x * b.own.inverse() * x.transpose();
    const double missing = is_stiffness ? 0.0 : (kLeast * a.own.trace() - left.trace()) / 3.0;
    Pair c;
    c << a.own + std::max(0.0, missing) * Matrix3d::Identity(), x, x.transpose(), b.own;
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
    for (const std::int32_t node : controls.node)
        controls.node_m.push_back(body.mesh.position_m[static_cast<std::size_t>(node)]);
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
                            std::uintmax_t most_bytes, const ContactOptions& contact, Progress& progress) {
    const std::size_t n = controls.weights.size();
    if (n >= HAPTABLE_NONE)
        throw Error(fmt::format("two fingers couple {} places, more than the servo's {}: touch a smaller region", n,
                                HAPTABLE_NONE - 1));
    PairTables tables = kBlockBytes * n * (n + 1) / 2 <= most_bytes
                            ? all_pairs(controls, l)
                            : in_clusters(controls, l, most_bytes, contact, progress);
    tables.control_count = n;
    tables.meeting_m = meeting_m;
    return tables;
}

Matrix3d pair_block(const PairTables& tables, std::size_t k, std::size_t l) {
    if (k < l) return pair_block(tables, l, k).transpose();
    return matrix_of(tables.block[k * (k + 1) / 2 + l]);
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
    const bool is_stiffness = contact.force == ForceLaw::kInterpolated;
    std::vector<double> error;
    PairError to{places, 0.0, 0.0, HUGE_VAL, 0};
    while (error.size() < places) {
        const Pressed a = press(), b = press();
        if (!(a.own.trace() > 0.0 && b.own.trace() > 0.0)) continue;
        Eigen::Vector<double, 6> u;
        u << a.u_m, b.u_m;
        const Matrix3d x =
            is_stiffness ? cross_of(a, b, [&](auto k, auto j) { return presser.block(k, j); }) : presser.between(a, b);
        const Pair exact = compliance_of(a, b, tables.meeting_m, x, is_stiffness);
        const Pair kept = compliance_of(a, b, tables.meeting_m, kept_cross(tables, a, b, is_stiffness), is_stiffness);
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
