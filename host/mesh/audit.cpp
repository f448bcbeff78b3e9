// SPDX-License-Identifier: GPL-2.0-or-later
// q = 3 r / R,   r = 3 V / sum A_i,   R = |a^2 (b x c) + b^2 (c x a) + c^2 (a x b)| / (12 V)
#include "host/mesh/audit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "host/base/index.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/sets.hpp"
#include "host/mesh/shells.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kSliver = 0.1;
constexpr double kDegrees = 180.0 / 3.14159265358979323846;
// Nodes nearer than this share of the body's diagonal are at one place.
constexpr double kSamePlace = 1e-9;
// A middle node this share of its edge from the straight line makes it curved: 10 times the rounding of a float.
constexpr double kCurved = 1e-6;

struct Quality {
    double ratio = 0.0, least_deg = 180.0, greatest_deg = 0.0;
};

/// Outward normals n_c, twice the area long, opposite to corner c: the angle at the edge of two faces is pi - angle(n,
/// m).
Quality quality_of(const std::vector<Vector3d>& position_m, const Tet& tet) {
    const Vector3d a = position_m[at(tet[1])] - position_m[at(tet[0])];
    const Vector3d b = position_m[at(tet[2])] - position_m[at(tet[0])];
    const Vector3d c = position_m[at(tet[3])] - position_m[at(tet[0])];
    const Vector3d normal[4] = {(b - a).cross(c - a), c.cross(b), a.cross(c), b.cross(a)};
    double areas = 0.0;  // twice
    for (const Vector3d& n : normal) areas += n.norm();
    const double six = a.dot(b.cross(c));
    const double inner = six / areas;  // r = 3 V / sum A
    const double outer =
        (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)).norm() /
        (2.0 * six);
    Quality quality;
    quality.ratio = 3.0 * inner / outer;
    for (int p = 0; p < 4; ++p)
        for (int q = 0; q < p; ++q) {
            const double deg = kDegrees * std::atan2(normal[p].cross(normal[q]).norm(), -normal[p].dot(normal[q]));
            quality.least_deg = std::min(quality.least_deg, deg);
            quality.greatest_deg = std::max(quality.greatest_deg, deg);
        }
    return quality;
}

bool is_curved(const TenNodes& node_m) {
    for (std::size_t e = 0; e < 6; ++e) {
        const auto column = [&](std::size_t c) { return node_m.col(static_cast<Eigen::Index>(c)); };
        const auto a = column(kTetEdges[e][0]), b = column(kTetEdges[e][1]);
        if ((column(4 + e) - 0.5 * (a + b)).norm() > kCurved * (b - a).norm()) return true;
    }
    return false;
}

/// Judges the middle nodes of quadratic tetrahedra; takes their own volume too.
void judge_middles(const TetMesh& mesh, Audit& audit) {
    std::vector<std::int32_t> middle;
    audit.volume_m3 = 0.0;
    for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
        middle.insert(middle.end(), mesh.middle[t].begin(), mesh.middle[t].end());
        const TenNodes node_m = ten_nodes(mesh.position_m, mesh.tet[t], mesh.middle[t]);
        for (const Eigen::Vector4d& point : tet_points()) audit.volume_m3 += tet_point(node_m, point).det_m3 / 24.0;
        audit.curved += is_curved(node_m) ? 1 : 0;
        const DetRange det = det_range(node_m);
        audit.worst_jacobian_ratio = std::min(audit.worst_jacobian_ratio, det.least_m3 / det.greatest_m3);
    }
    std::sort(middle.begin(), middle.end());
    audit.middle_nodes = static_cast<std::size_t>(std::unique(middle.begin(), middle.end()) - middle.begin());
}

/// Keeps the list sorted and short.
void list_if_worst(const TetMesh& mesh, std::size_t t, double ratio, std::vector<ShapedTet>& worst) {
    if (worst.size() == kListed && ratio >= worst.back().ratio) return;
    const std::uint64_t number = mesh.tet_number.empty() ? t : mesh.tet_number[t];
    const auto place = std::find_if(worst.begin(), worst.end(), [&](const ShapedTet& w) { return ratio < w.ratio; });
    worst.insert(place, {static_cast<std::int32_t>(t), number, ratio, mesh.tet[t]});
    if (worst.size() > kListed) worst.pop_back();
}

void judge_shapes(const TetMesh& mesh, Audit& audit) {
    std::vector<double> ratio;
    audit.least_angle_deg = 180.0;
    for (std::size_t t = 0; t < mesh.tet.size(); ++t) {
        const Tet& tet = mesh.tet[t];
        const Quality quality = quality_of(mesh.position_m, tet);
        list_if_worst(mesh, t, quality.ratio, audit.worst);
        ratio.push_back(quality.ratio);
        audit.least_angle_deg = std::min(audit.least_angle_deg, quality.least_deg);
        audit.greatest_angle_deg = std::max(audit.greatest_angle_deg, quality.greatest_deg);
        audit.slivers += quality.ratio < kSliver ? 1 : 0;
        audit.volume_m3 += six_volumes(mesh.position_m, tet) / 6.0;
    }
    if (!mesh.middle.empty()) judge_middles(mesh, audit);
    std::sort(ratio.begin(), ratio.end());
    audit.worst_ratio = ratio.front();
    audit.median_ratio = 0.5 * (ratio[(ratio.size() - 1) / 2] + ratio[ratio.size() / 2]);
}

void judge_shells(const TetMesh& mesh, const Surface& surface, const Edges& edges, Audit& audit) {
    for (const auto& [edge, patches] : edges) {
        if (patches.size() <= 2) continue;
        ++audit.hinge_edges;
        if (audit.hinge_edge.size() < kListedHinges) audit.hinge_edge.push_back({edge[0], edge[1]});
    }
    const Shells shells = find_shells(mesh, surface, edges);
    audit.shells = shells.volume_m3.size();
    for (std::size_t k = 0; k < audit.shells; ++k) audit.cavities += shells.is_cavity(k) ? 1 : 0;
}

/// The patches around a node hang together over its edges; where they do not, the node is a hinge.
void count_hinge_nodes(const Surface& surface, const Edges& edges, std::size_t node_count, Audit& audit) {
    Sets corners(3 * surface.patch.size());
    const auto corner = [&](std::size_t p, std::int32_t node) {
        const Patch& patch = surface.patch[p];
        return 3 * p + static_cast<std::size_t>(std::find(patch.begin(), patch.end(), node) - patch.begin());
    };
    for (const auto& [edge, patches] : edges)
        for (std::size_t p : patches)
            for (std::int32_t node : edge) corners.join(corner(patches[0], node), corner(p, node));
    std::vector<int> rings(node_count, 0);
    for (std::size_t k = 0; k < 3 * surface.patch.size(); ++k) {
        const std::int32_t node = surface.patch[k / 3][k % 3];
        if (corners.find(k) != k || ++rings[at(node)] != 2) continue;
        ++audit.hinge_nodes;
        if (audit.hinge_node.size() < kListedHinges) audit.hinge_node.push_back(node);
    }
}

/// Nodes in order of x: only neighbours in that order can be at one place.
std::size_t count_coincident(const TetMesh& mesh, double tolerance_m) {
    std::vector<Vector3d> sorted = mesh.position_m;
    std::sort(sorted.begin(), sorted.end(), [](const Vector3d& a, const Vector3d& b) {
        return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    });
    std::size_t count = 0;
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i)
        count += (sorted[i + 1] - sorted[i]).norm() <= tolerance_m ? 1 : 0;
    return count;
}

/// Tetrahedra that lie on one side of a shared face, by their neighbours in such faces.
using Conflicts = std::map<std::int32_t, std::vector<std::int32_t>>;

/// Neighbours cannot both be right: of every part of the graph, the side with fewer tetrahedra is the folded one.
std::vector<std::int32_t> minority_of(const Conflicts& conflicts) {
    std::vector<std::int32_t> folded;
    std::map<std::int32_t, std::size_t> side;
    for (const auto& [first, unused] : conflicts) {
        if (side.contains(first)) continue;
        std::array<std::vector<std::int32_t>, 2> part{{{first}, {}}};
        side[first] = 0;
        for (std::vector<std::int32_t> open{first}; !open.empty();) {
            const std::int32_t tet = open.back();
            open.pop_back();
            for (std::int32_t other : conflicts.at(tet)) {
                if (!side.emplace(other, 1 - side[tet]).second) continue;
                part[side[other]].push_back(other);
                open.push_back(other);
            }
        }
        const auto& fewer = part[part[1].size() < part[0].size() ? 1 : 0];
        folded.insert(folded.end(), fewer.begin(), fewer.end());
    }
    std::sort(folded.begin(), folded.end());
    return folded;
}

}  // namespace

std::vector<std::int32_t> find_folded(const std::vector<Tet>& tets) {
    // Positively oriented neighbours on two sides of a face see it turned the other way round.
    constexpr std::size_t kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    struct Face {
        Patch key;
        bool even;
        std::int32_t tet;
    };
    std::vector<Face> faces;
    for (std::size_t t = 0; t < tets.size(); ++t)
        for (const auto& side : kFace) {
            Patch key{tets[t][side[0]], tets[t][side[1]], tets[t][side[2]]};
            const bool even = (key[0] < key[1]) ^ (key[1] < key[2]) ^ (key[0] < key[2]);
            std::sort(key.begin(), key.end());
            faces.push_back({key, even, static_cast<std::int32_t>(t)});
        }
    std::sort(faces.begin(), faces.end(),
              [](const Face& a, const Face& b) { return std::tie(a.key, a.tet) < std::tie(b.key, b.tet); });
    Conflicts conflicts;
    for (std::size_t k = 1; k < faces.size(); ++k)
        if (faces[k].key == faces[k - 1].key && faces[k].even == faces[k - 1].even) {
            conflicts[faces[k - 1].tet].push_back(faces[k].tet);
            conflicts[faces[k].tet].push_back(faces[k - 1].tet);
        }
    return minority_of(conflicts);
}

std::vector<std::size_t> number_bodies(const TetMesh& mesh) {
    Sets sets(mesh.position_m.size());
    for (std::size_t t = 0; t < mesh.tet.size(); ++t)
        for_each_node(mesh, t, [&](std::int32_t node) { sets.join(at(mesh.tet[t][0]), at(node)); });
    return sets.numbers();
}

Audit audit_mesh(const TetMesh& mesh, const Surface& surface) {
    const Edges edges = edges_of(surface.patch);
    Audit audit;
    audit.nodes = mesh.position_m.size();
    audit.tets = mesh.tet.size();
    audit.surface_nodes = surface.node.size();
    audit.patches = surface.patch.size();
    audit.unused_nodes = mesh.unused_nodes;
    audit.turned = mesh.turned;
    audit.folded = find_folded(mesh.tet).size();
    for (const Vector3d& p : mesh.position_m) audit.box_m.extend(p);
    const std::vector<std::size_t> body = number_bodies(mesh);
    audit.bodies = body.empty() ? 0 : *std::max_element(body.begin(), body.end()) + 1;
    judge_shells(mesh, surface, edges, audit);
    count_hinge_nodes(surface, edges, mesh.position_m.size(), audit);
    audit.euler = static_cast<std::int64_t>(surface.node.size()) + static_cast<std::int64_t>(surface.patch.size()) -
                  static_cast<std::int64_t>(edges.size());
    audit.coincident = count_coincident(mesh, kSamePlace * audit.box_m.diagonal().norm());
    judge_shapes(mesh, audit);
    return audit;
}

std::string doubt_scale(double size_m, double scale_m) {
    constexpr double kSmall_m = 1e-3, kLarge_m = 3.0;  // a finger's width, and what arms span
    if (size_m >= kSmall_m && size_m <= kLarge_m) return "";
    std::string doubt = fmt::format("the body is {:.3g} m long: is mesh.scale (metres per unit) right?", size_m);
    for (const auto& [unit_m, name] : {std::pair{1e-3, "millimetres"}, {1e-2, "centimetres"}, {1.0, "metres"}})
        if (const double other_m = size_m / scale_m * unit_m; other_m >= 10.0 * kSmall_m && other_m <= 0.5 * kLarge_m)
            return doubt + fmt::format(" If its file is in {}, it is {:.3g} m: write scale = {:g} in [mesh]", name,
                                       other_m, unit_m);
    return doubt;
}

std::vector<std::string> warnings_of(const Audit& audit, double scale_m) {
    std::vector<std::string> warnings;
    if (const std::string doubt = doubt_scale(audit.box_m.sizes().maxCoeff(), scale_m); !doubt.empty())
        warnings.push_back(doubt);
    if (audit.hinge_edges + audit.hinge_nodes > 0)
        warnings.push_back(
            fmt::format("parts hang on hinges: {} edges with more than two patches, {} nodes with more than "
                        "one ring of patches; they turn freely unless both sides are held",
                        audit.hinge_edges, audit.hinge_nodes));
    if (audit.coincident > 0)
        warnings.push_back(
            fmt::format("{} pairs of nodes coincide and are not joined, in {} bodies; merge them in your "
                        "mesh program if the parts should hold together",
                        audit.coincident, audit.bodies));
    return warnings;
}

std::string to_table(const Audit& a) {
    const Vector3d size_m = a.box_m.sizes();
    std::string text = fmt::format("  nodes {}, on the surface {}; tetrahedra {}; patches {}\n", a.nodes,
                                   a.surface_nodes, a.tets, a.patches);
    text +=
        fmt::format("  bodies {}, shells {}, inner cavities {}, Euler characteristic {}; hinges: {} edges, {} nodes\n",
                    a.bodies, a.shells, a.cavities, a.euler, a.hinge_edges, a.hinge_nodes);
    text += fmt::format("  turned {}, folded {}, unused nodes {}, coincident nodes {}\n", a.turned, a.folded,
                        a.unused_nodes, a.coincident);
    text += fmt::format(
        "  radius ratio: worst {:.2g}, median {:.2f}, {} under {}; dihedral angles {:.2g} to {:.4g} degrees\n",
        a.worst_ratio, a.median_ratio, a.slivers, kSliver, a.least_angle_deg, a.greatest_angle_deg);
    if (a.middle_nodes > 0)
        text +=
            fmt::format("  nodes in the middle of edges {}; curved tetrahedra {}, worst ratio of Jacobians {:.2g}\n",
                        a.middle_nodes, a.curved, a.worst_jacobian_ratio);
    return text + fmt::format("  box {:.4g} x {:.4g} x {:.4g} m, volume {:.6g} m^3\n", size_m.x(), size_m.y(),
                              size_m.z(), a.volume_m3);
}

nlohmann::ordered_json to_json(const Audit& a) {
    const Vector3d &low = a.box_m.min(), &high = a.box_m.max();
    nlohmann::ordered_json json{{"nodes", a.nodes},
                                {"surface_nodes", a.surface_nodes},
                                {"tetrahedra", a.tets},
                                {"surface_patches", a.patches},
                                {"bodies", a.bodies},
                                {"shells", a.shells},
                                {"inner_cavities", a.cavities},
                                {"euler_characteristic", a.euler},
                                {"hinge_edges", a.hinge_edges},
                                {"hinge_nodes", a.hinge_nodes},
                                {"turned", a.turned},
                                {"folded", a.folded},
                                {"unused_nodes", a.unused_nodes},
                                {"coincident_nodes", a.coincident},
                                {"worst_radius_ratio", a.worst_ratio},
                                {"median_radius_ratio", a.median_ratio},
                                {"slivers", a.slivers},
                                {"least_dihedral_deg", a.least_angle_deg},
                                {"greatest_dihedral_deg", a.greatest_angle_deg},
                                {"volume_m3", a.volume_m3},
                                {"box_m", {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()}}};
    json["worst_elements"] = nlohmann::ordered_json::array();
    for (const ShapedTet& w : a.worst)
        json["worst_elements"].push_back({{"tetrahedron", w.number}, {"radius_ratio", w.ratio}, {"nodes", w.node}});
    json["hinge_edges_at"] = a.hinge_edge;
    json["hinge_nodes_at"] = a.hinge_node;
    if (a.middle_nodes == 0) return json;
    json["middle_nodes"] = a.middle_nodes;
    json["curved_tetrahedra"] = a.curved;
    json["worst_jacobian_ratio"] = a.worst_jacobian_ratio;
    return json;
}

}  // namespace haptable
