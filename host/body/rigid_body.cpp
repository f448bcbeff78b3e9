// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/rigid_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/base/limits.hpp"
#include "host/base/mass_range.hpp"
#include "host/body/assembly.hpp"
#include "host/body/under_constrained.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// A tick's turn, relative to a second: where the midpoint rule is 2 % slow.
constexpr double kMostFrequency_hz = 80.0;

// Stiffness of a point that carries the whole body: 16 Hz, and half of critical damping.
constexpr double kFloorTurn = 0.1;  // rad a tick
constexpr double kFloorDamping = 0.5;

const Vector3d& at(const Body& body, std::int32_t node) { return body.mesh.position_m[static_cast<std::size_t>(node)]; }

Matrix3d cross_matrix(const Vector3d& r) {
    Matrix3d m;
    m << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
    return m;
}

MatrixXd motions_about(const Body& body, const Vector3d& centre_m) {
    MatrixXd r(3 * static_cast<Index>(body.mesh.position_m.size()), 6);
    for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i)
        r.middleRows<3>(3 * static_cast<Index>(i)) << Matrix3d::Identity(),
            -cross_matrix(body.mesh.position_m[i] - centre_m);
    return r;
}

template <typename Distance>
std::int32_t farthest(const Body& body, Distance distance) {
    std::int32_t best = 0;
    for (std::int32_t i = 1; i < static_cast<std::int32_t>(body.mesh.position_m.size()); ++i)
        if (distance(at(body, i)) > distance(at(body, best))) best = i;
    return best;
}

[[noreturn]] void fail(const Scene& scene, const std::string& what) {
    throw Error(fmt::format("{}:{}: body.{}", scene.file.string(), scene.free_body->line, what));
}

/// Mass, by whatever key, and inertia within what a tick computes in float.
void require_moved(const Scene& scene, const RigidBody& rigid) {
    constexpr double kRoundingOfSum = 1e-9;  // of a sum over elements, where mass is given
    if (!(rigid.mass_kg >= (1.0 - kRoundingOfSum) * kLeastMass_kg &&
          rigid.mass_kg <= (1.0 + kRoundingOfSum) * kMostMass_kg))
        fail(scene, fmt::format("density: the body has {:g} kg, and a servo moves {:g} to {:g} kg: give densities in "
                                "kg/m^3 and the mesh in m ([mesh] scale)",
                                rigid.mass_kg, kLeastMass_kg, kMostMass_kg));
    const Vector3d inertia = symmetric_eigenvalues(rigid.inertia_kg_m2);
    if (!(inertia[0] >= kLeastInertia_kg_m2 && inertia[2] <= kMostInertia_kg_m2))
        fail(scene, fmt::format("{}: the body's principal moments of inertia are {:g} to {:g} kg m^2, and a servo "
                                "turns {:g} to {:g}: give mass in kg, densities in kg/m^3 and the mesh in m ([mesh] "
                                "scale)",
                                scene.mass_kg() > 0.0 ? "mass" : "density", inertia[0], inertia[2], kLeastInertia_kg_m2,
                                kMostInertia_kg_m2));
}

/// Hz of the six suspended directions, without what couples them.
void require_slow(const Scene& scene, const RigidBody& rigid) {
    const Vector3d inertia = symmetric_eigenvalues(rigid.inertia_kg_m2);
    for (std::size_t i = 0; i < 6; ++i) {
        const double mass = i < 3 ? rigid.mass_kg : inertia[0];
        const double hz = std::sqrt(scene.free_body->stiffness[i] / mass) / (2.0 * std::numbers::pi);
        if (hz <= kMostFrequency_hz) continue;
        const double most = mass * std::pow(2.0 * std::numbers::pi * kMostFrequency_hz, 2);
        fail(scene, fmt::format("suspension: entry {} swings with up to {:.3g} Hz, and at 1 kHz at most {} Hz are what "
                                "they should be: at most {:.3g}, or hold the body by [[fixed]]",
                                i, hz, kMostFrequency_hz, most));
    }
}

/// Surface nodes that come to lie lowest as the body turns: in directions all around, the farthest; then those that are
/// farthest from the ones taken.
std::vector<std::int32_t> find_rests(const Body& body, const Vector3d& up) {
    std::vector<std::int32_t> outer;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0}) {
                const Vector3d along = Vector3d(x, y, z) - 1e-3 * up;
                outer.push_back(farthest(body, [&](const Vector3d& p) { return along.dot(p); }));
            }
    std::sort(outer.begin(), outer.end());
    outer.erase(std::unique(outer.begin(), outer.end()), outer.end());
    return outer;
}

template <typename Vector>
std::vector<double> list(const Vector& v) {
    return {v.begin(), v.end()};
}

void add_floor(const Scene& scene, const Body& body, const RigidBody& rigid, nlohmann::ordered_json& json) {
    const auto& floor = scene.free_body->floor;
    const Vector3d up = floor ? Vector3d(floor->normal[0], floor->normal[1], floor->normal[2]) : Vector3d::UnitZ();
    const double stiffness = rigid.mass_kg * std::pow(kFloorTurn / kServoTick_s, 2);
    json["floor_normal"] = list(up);
    json["floor_along"] = list(Vector3d(up.unitOrthogonal()));
    json["floor_m"] = floor ? floor->height_m - body.mesh.origin_m.dot(up) : 0.0;
    json["floor_stiffness_n_per_m"] = stiffness;
    json["floor_damping_n_s_per_m"] = 2.0 * kFloorDamping * std::sqrt(stiffness * rigid.mass_kg);
    json["floor_friction"] = floor ? floor->friction : 0.0;
    json["point_m"] = nlohmann::ordered_json::array();
    if (!floor) return;
    for (const std::int32_t node : find_rests(body, up)) json["point_m"].push_back(list(at(body, node)));
}

}  // namespace

RigidBody rigid_body_of(const Scene& scene, const Body& body) {
    RigidBody rigid;
    const Eigen::SparseMatrix<double> mass = assemble_mass(scene, body);
    const MatrixXd about_origin = motions_about(body, Vector3d::Zero());
    const MatrixXd gram = transposed_product(about_origin, mass * about_origin);
    rigid.mass_kg = gram.topLeftCorner<3, 3>().trace() / 3.0;
    const Matrix3d moment = gram.topRightCorner<3, 3>() / rigid.mass_kg;  // -cross_matrix(centre)
    rigid.centre_m = {moment(1, 2), moment(2, 0), moment(0, 1)};
    rigid.motion = motions_about(body, rigid.centre_m);
    rigid.momentum = mass * rigid.motion;
    const MatrixXd inertia = transposed_product(rigid.motion.rightCols<3>(), rigid.momentum.rightCols<3>());
    rigid.inertia_kg_m2 = 0.5 * (inertia + inertia.transpose());
    return rigid;
}

void require_movable(const Scene& scene, const RigidBody& rigid) {
    require_moved(scene, rigid);
    require_slow(scene, rigid);
}

std::array<std::int32_t, 3> find_holds(const Body& body) {
    Vector3d centre_m = Vector3d::Zero();
    for (const Vector3d& p : body.mesh.position_m) centre_m += p;
    centre_m /= static_cast<double>(body.mesh.position_m.size());
    const std::int32_t a = farthest(body, [&](const Vector3d& p) { return (p - centre_m).norm(); });
    const std::int32_t b = farthest(body, [&](const Vector3d& p) { return (p - at(body, a)).norm(); });
    const Vector3d line = (at(body, b) - at(body, a)).normalized();
    const std::int32_t c = farthest(body, [&](const Vector3d& p) { return (p - at(body, a)).cross(line).norm(); });
    return {a, b, c};
}

Eigen::SparseMatrix<double> hold_springs(const Body& body, const Eigen::VectorXd& k_diagonal) {
    const auto [a, b, c] = find_holds(body);
    const Vector3d line = (at(body, b) - at(body, a)).normalized();
    const Vector3d across = line.cross(at(body, c) - at(body, a)).normalized();
    const std::array<std::pair<std::int32_t, Matrix3d>, 3> holds{{{a, Matrix3d::Identity()},
                                                                  {b, Matrix3d::Identity() - line * line.transpose()},
                                                                  {c, across * across.transpose()}}};
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [node, square] : holds) {
        const Index first = Index{3} * body.unknown[static_cast<std::size_t>(node)];
        const double stiffness = k_diagonal.segment<3>(first).mean();
        for (Index i = 0; i < 3; ++i)
            for (Index j = 0; j < 3; ++j) entries.emplace_back(first + i, first + j, stiffness * square(i, j));
    }
    Eigen::SparseMatrix<double> springs(k_diagonal.size(), k_diagonal.size());
    springs.setFromTriplets(entries.begin(), entries.end());
    return springs;
}

Stiffness assemble_held(const Scene& scene, const Body& body) {
    Stiffness k = assemble_free(scene, body);
    return scene.free_body ? assemble_free(scene, body, hold_springs(body, k.diagonal())) : k;
}

void require_one_body(const Scene& scene, const Body& body) {
    Body held = body;
    for (const std::int32_t node : find_holds(body)) {
        held.unknown[static_cast<std::size_t>(node)] = -1;
        std::erase(held.free_node, node);
    }
    const std::vector<std::int32_t> loose = find_under_constrained(held);
    if (loose.empty()) return;
    fail(scene, fmt::format("free: the body does not hang together as one: {} of {} nodes (mesh node {} is the first) "
                            "can move while the rest stands still and no element deforms; join the parts in the mesh, "
                            "or hold them by [[fixed]]",
                            loose.size(), body.mesh.position_m.size(), loose.front()));
}

void write_rigid_body(const Scene& scene, const Body& body, const RigidBody& rigid,
                      const std::filesystem::path& folder) {
    const Matrix3d& j = rigid.inertia_kg_m2;
    const auto& [k, d] = std::pair{scene.free_body->stiffness, scene.free_body->damping};
    nlohmann::ordered_json json{
        {"mass_kg", rigid.mass_kg},
        {"centre_m", list(rigid.centre_m)},
        {"inertia_kg_m2", {j(0, 0), j(1, 1), j(2, 2), j(0, 1), j(1, 2), j(2, 0)}},
        {"gravity_m_per_s2", scene.gravity ? list(scene.gravity->acceleration_m_per_s2) : std::vector<double>(3)},
        {"stiffness_n_per_m", std::vector<double>(k.begin(), k.begin() + 3)},
        {"damping_n_s_per_m", std::vector<double>(d.begin(), d.begin() + 3)},
        {"turn_stiffness_n_m", std::vector<double>(k.begin() + 3, k.end())},
        {"turn_damping_n_m_s", std::vector<double>(d.begin() + 3, d.end())}};
    add_floor(scene, body, rigid, json);
    write_file(folder / "body.json", json_text(json, 1) + "\n");
}

}  // namespace haptable
