// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/bodies.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "codegen/in_memory.hpp"
#include "host/body/assembly.hpp"
#include "host/compliance/compliance.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/write_tetgen.hpp"
#include "host/strokes/motion.hpp"

namespace haptable::test {

namespace {

using Eigen::Vector3d;

bool always(int, int, int) { return true; }

void touch_by(ForceLaw force, double mask_radius_m, Scene& scene) {
    scene.contact.force = force;
    scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? mask_radius_m : 0.0;
}

/// sum v_i w_j L_ij.
Eigen::Matrix3d between(const Eigen::MatrixXd& l, const Eigen::VectorXd& v, const Eigen::VectorXd& w) {
    Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < v.size(); ++i)
        for (Eigen::Index j = 0; j < w.size(); ++j)
            if (v[i] != 0.0 && w[j] != 0.0) c += v[i] * w[j] * l.block<3, 3>(3 * i, 3 * j);
    return c;
}

}  // namespace

Scene cube_scene(int nodes_per_side, double poisson, bool top_only) {
    Scene scene;
    scene.file = "cube.toml";
    scene.name = fmt::format("cube{}nu{:.0f}", nodes_per_side, 100 * poisson);
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.material = {1e4, poisson};
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1});
    if (top_only) scene.touch.push_back({std::array<double, 6>{0.004, 0.004, 0.03 - 1e-9, 0.026, 0.026, 1}, "", 1});
    return scene;
}

const ElasticBody& coupled_cube(ForceLaw force) {
    static const ElasticBody consistent(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    static const ElasticBody mask(for_two(cube_scene(5, 0.3)), ForceLaw::kPressureMask, 0.01);
    return force == ForceLaw::kConsistent ? consistent : mask;
}

Eigen::SparseMatrix<double> cube_stiffness(int nodes_per_side, double poisson) {
    const Scene scene = cube_scene(nodes_per_side, poisson);
    return assemble_free(scene, make_body(scene, make_mesh(scene.mesh))).matrix();
}

Scene mouse_scene(bool front_only) {
    Scene scene = read_scene("meshes/mouse.toml");
    if (front_only) scene.touch.push_back({std::array<double, 6>{-1, -1, -1, 0.03, 1, 1}, "", 1});
    return scene;
}

void set_free(Scene& scene, double density_kg_per_m3) {
    scene.fixed.clear();
    scene.free_body = FreeBody{};
    scene.free_body->density_kg_per_m3 = density_kg_per_m3;
}

Scene for_two(Scene scene, std::uintmax_t coupling_bytes) {
    scene.contact.fingers = 2;
    scene.tables.coupling_bytes = coupling_bytes;
    return scene;
}

SceneFiles files_of(const Scene& scene) {
    const TemporaryFolder folder;
    Progress quiet(true);
    precompute(scene, folder.path() / "out", quiet);
    return read_scene_files(folder.path() / "out");
}

Cells sphere_cells(int n, double radius) {
    return {{n, n, n},
            [=](double a, double b, double c) {
                const Vector3d x = 2.0 * Vector3d(a, b, c) - Vector3d::Ones();
                return Vector3d(x.norm() == 0.0 ? x : radius * x.lpNorm<Eigen::Infinity>() / x.norm() * x);
            },
            always,
            [=](const Vector3d& x) { return x.z() < -0.8 * radius; }};
}

Cells plate_cells(int n, double side, double thickness) {
    return {{n, n, 2},
            [=](double a, double b, double c) { return Vector3d(side * a, side * b, thickness * c); },
            always,
            [=](const Vector3d& x) {
                return std::min({x.x(), x.y(), side - x.x(), side - x.y()}) < 0.51 * side / n;
            }};
}

Cells needle_cells(int n, double length, double width) {
    return {{2, 2, n},
            [=](double a, double b, double c) {
                const double w = width * (1.0 - 0.95 * c);
                return Vector3d(w * (a - 0.5), w * (b - 0.5), length * c);
            },
            always,
            [](const Vector3d& x) { return x.z() < 1e-9; }};
}

Cells torus_cells(int around, int across, double major, double minor) {
    return {{around, across, across},
            [=](double a, double b, double c) {
                const double turn = 2.0 * std::numbers::pi * (a == 1.0 ? 0.0 : a);
                const Eigen::Vector2d q = 2.0 * Eigen::Vector2d(b, c) - Eigen::Vector2d::Ones();
                const Eigen::Vector2d disc =
                    q.norm() == 0.0 ? q : Eigen::Vector2d(minor * q.lpNorm<Eigen::Infinity>() / q.norm() * q);
                const double r = major + disc.x();
                return Vector3d(r * std::cos(turn), r * std::sin(turn), disc.y());
            },
            always,
            [=](const Vector3d& x) { return x.z() < -0.8 * minor; }};
}

ElasticBody::ElasticBody(Scene scene, ForceLaw force, double mask_radius_m) {
    touch_by(force, mask_radius_m, scene);
    load(scene);
}

ElasticBody::ElasticBody(const Cells& cells, const std::string& name, ForceLaw force, double mask_radius_m) {
    const TetMesh mesh = mesh_of(cells);
    Scene scene;
    scene.file = name + ".toml";
    scene.name = name;
    scene.mesh.file = write_tetgen(mesh.position_m, mesh.tet, folder_.path() / name);
    scene.material = {1e4, 0.3};
    touch_by(force, mask_radius_m, scene);
    for (const Vector3d& x : mesh.position_m) {  // a box around each held node: the cells are larger than its slack
        if (!cells.held(x)) continue;
        const double e = 1e-9;
        scene.fixed.push_back(
            {std::array<double, 6>{x.x() - e, x.y() - e, x.z() - e, x.x() + e, x.y() + e, x.z() + e}, "", 1});
    }
    load(scene);
}

void ElasticBody::load(const Scene& scene) {
    scene_ = scene;
    scene_.tables.columns = ColumnRows::kNone;
    scene_.device.limits = {};  // it is the body's force that is looked at
    Progress progress(true);
    const auto out = folder_.path() / "out";
    precompute(scene_, out, progress);
    tables_ = read_tables(out);
    servo_ = build_model(tables_);
}

haptable_model ElasticBody::model(GodObject god_object) const {
    Tables tables;
    tables.force = tables_.force;
    tables.god_object = god_object;
    tables.model_hash = tables_.model_hash;
    tables.max_force_n = tables_.max_force_n;
    tables.rigid_stiffness_n_per_m = tables_.rigid_stiffness_n_per_m;
    return model_in_memory(tables, servo_);
}

const Eigen::MatrixXd& ElasticBody::compliance() const {
    if (compliance_) return *compliance_;
    const Body body = make_body(scene_, make_mesh(scene_.mesh));
    const auto k = assemble_free(scene_, body);
    const Factor factor(k);
    std::vector<std::int32_t> node;
    for (std::int32_t i : body.touch_node) node.push_back(body.unknown[std::size_t(i)]);
    const auto n = Eigen::Index(node.size());
    compliance_ = std::make_unique<Eigen::MatrixXd>(3 * n, 3 * n);
    Progress progress(true);
    solve_columns(factor, k, node, progress, [&](std::size_t first, const Eigen::MatrixXd& x) {
        for (Eigen::Index i = 0; i < n; ++i)
            compliance_->block(3 * i, 3 * Eigen::Index(first), 3, x.cols()) = x.middleRows<3>(3 * node[std::size_t(i)]);
    });
    return *compliance_;
}

Vector3d ElasticBody::corner(int patch, int c) const {
    return Eigen::Vector3f(servo_.vertex_m[vertex(patch, c)].data()).cast<double>();
}

Vector3d ElasticBody::point(int patch, const Vector3d& alpha) const {
    return alpha[0] * corner(patch, 0) + alpha[1] * corner(patch, 1) + alpha[2] * corner(patch, 2);
}

Vector3d ElasticBody::normal(int patch) const {
    return (corner(patch, 1) - corner(patch, 0)).cross(corner(patch, 2) - corner(patch, 0)).normalized();
}

Tables ElasticBody::tables(const TouchOptions& options) const {
    Tables tables = tables_;
    tables.god_object = options.god_object;
    tables.static_friction = tables.kinetic_friction = options.friction;
    tables.options.set("contact.release_slew", 0.0);
    tables.options.set("contact.passivity", options.passivity);
    tables.max_force_n = options.max_force_n;
    tables.limits = options.limits;
    return tables;
}

Eigen::Matrix3d ElasticBody::coupling(const haptable_contact& a, const haptable_contact& b) const {
    return between(compliance(), weights(a.patch, to_vector(a.alpha)), weights(b.patch, to_vector(b.alpha)));
}

Eigen::VectorXd ElasticBody::weights(int patch, const Vector3d& alpha) const {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(Eigen::Index(servo_.free_count));
    const ComplianceTables& c = tables_.compliance;
    if (c.degree != 4) {
        for (int i = 0; i < 3; ++i)
            if (is_free(vertex(patch, i))) w[Eigen::Index(vertex(patch, i))] += alpha[i];
        return w;
    }
    const auto add = [&](std::size_t control, double share) {
        for (auto i = std::size_t(c.spread_begin[control]); i < std::size_t(c.spread_begin[control + 1]); ++i) {
            const auto at = std::lower_bound(tables_.node_id.begin(), tables_.node_id.end(), c.spread_node[i]);
            if (at != tables_.node_id.end() && *at == c.spread_node[i])
                w[at - tables_.node_id.begin()] += share * double(c.spread_weight[i]);
        }
    };
    for (int i = 0; i < 3; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        const auto node = [&](int corner) { return servo_.node[vertex(patch, corner)]; };
        const auto v = std::lower_bound(c.vertex_id.begin(), c.vertex_id.end(), node(i)) - c.vertex_id.begin();
        const std::array<std::int32_t, 2> edge{std::min(node(a), node(b)), std::max(node(a), node(b))};
        const auto e = std::lower_bound(c.edge_id.begin(), c.edge_id.end(), edge) - c.edge_id.begin();
        add(std::size_t(v), alpha[i] * alpha[i]);
        add(c.vertex_id.size() + std::size_t(e), 2.0 * alpha[a] * alpha[b]);
    }
    return w;
}

Eigen::Matrix3d ElasticBody::compliance_at(int patch, const Vector3d& alpha) const {
    const Eigen::VectorXd w = weights(patch, alpha);
    return between(compliance(), w, w);
}

int ElasticBody::patch_over(double x, double y, Vector3d& alpha) const {
    int best = -1;
    double highest = -HUGE_VAL;
    for (int p = 0; p < patches(); ++p) {
        std::array<Vector3d, 3> v{corner(p, 0), corner(p, 1), corner(p, 2)};
        const auto twice = [&](const Vector3d& a, const Vector3d& b) {
            return (a.x() - x) * (b.y() - y) - (a.y() - y) * (b.x() - x);
        };
        const Vector3d area(twice(v[1], v[2]), twice(v[2], v[0]), twice(v[0], v[1]));
        if (area.sum() <= 0.0 || area.minCoeff() < -1e-12 * area.sum()) continue;
        const Vector3d here = area / area.sum();
        if (point(p, here).z() <= highest) continue;
        highest = point(p, here).z();
        alpha = here;
        best = p;
    }
    return best;
}

const ElasticBody& body_of_modes(const std::string& name, ForceLaw force) {
    static std::map<std::string, std::unique_ptr<ElasticBody>> made;
    std::unique_ptr<ElasticBody>& one = made[name + word(force)];
    if (!one && name == "cube") one = std::make_unique<ElasticBody>(cube_scene(5, 0.49), force, 0.012);
    if (!one) one = std::make_unique<ElasticBody>(needle_cells(6, 0.06, 0.006), name, force, 0.004);
    return *one;
}

std::string test_name(std::string words) {
    std::replace_if(
        words.begin(), words.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return words;
}

Vector3d random_alpha(std::mt19937& random) {
    std::exponential_distribution<double> e;
    const Vector3d a(e(random), e(random), e(random));
    return a / a.sum();
}

haptable_contact contact_at(const ElasticBody& body, int patch, const Vector3d& alpha) {
    haptable_contact contact{};
    contact.patch = std::uint16_t(patch);
    std::copy_n(alpha.data(), 3, contact.alpha);
    std::copy_n(body.point(patch, to_vector(contact.alpha)).data(), 3, contact.god_object_m);
    return contact;
}

}  // namespace haptable::test
