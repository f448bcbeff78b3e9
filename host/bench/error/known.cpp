// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/known.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>

#include "host/base/error.hpp"
#include "host/bench/error/bricks.hpp"
#include "host/bench/error/calculix.hpp"
#include "host/bench/error/quadratic_tets.hpp"
#include "host/fem/stiffness.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/cube.hpp"
#include "host/mesh/surface.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/body.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::Vector3d;
using Triangle = std::array<std::int32_t, 3>;

// ---- a quarter of a block, in the product's tetrahedra -------------------------------------------------------------

/// The grid's cells in five tetrahedra.
TetMesh mesh_of_grid(const GridPlanes& plane_m) {
    const int n = static_cast<int>(plane_m[0].size());
    TetMesh mesh = make_cube(n, n - 1.0);
    for (Vector3d& x : mesh.position_m)
        for (std::size_t a = 0; a < 3; ++a)
            x[static_cast<Index>(a)] = plane_m[a].at(static_cast<std::size_t>(std::lround(x[static_cast<Index>(a)])));
    return mesh;
}

/// Holds nodes on x = 0 and y = 0 there.
void hold_symmetry(std::span<const Vector3d> position_m, std::span<const std::int32_t> unknown,
                   Eigen::SparseMatrix<double>& k) {
    std::vector<char> held(static_cast<std::size_t>(k.rows()), 0);
    for (std::size_t i = 0; i < position_m.size(); ++i)
        for (std::size_t a = 0; a < 2; ++a)
            if (unknown[i] >= 0 && position_m[i][static_cast<Index>(a)] == 0.0)
                held[3 * static_cast<std::size_t>(unknown[i]) + a] = 1;
    hold(held, k);
}

/// [0, W]^2 x [0, H], E = 1, held below, its planes x = 0 and y = 0 of symmetry.
class Block {
public:
    Block(const GridPlanes& plane_m, double poisson) {
        const TetMesh mesh = mesh_of_grid(plane_m);
        position_m = mesh.position_m;
        std::int32_t count = 0;
        for (const Vector3d& x : position_m) unknown.push_back(x[2] > 0.0 ? count++ : -1);
        const std::vector<Lame> material(mesh.tet.size(), Lame::from_young(1.0, poisson));
        auto k = assemble_stiffness({Element::kLinear, position_m, mesh.tet, material}, unknown, count).a;
        hold_symmetry(position_m, unknown, k);
        factor = std::make_unique<Factor>(k);
        for (const Patch& patch : find_surface(mesh.tet).patch)
            if (std::all_of(patch.begin(), patch.end(), [&](std::int32_t i) { return is_top(i, plane_m[2].back()); }))
                top.push_back(patch);
    }
    bool is_top(std::int32_t i, double height_m) const {
        return position_m[static_cast<std::size_t>(i)][2] == height_m;
    }

    std::vector<Vector3d> position_m;
    std::vector<std::int32_t> unknown;
    std::vector<Triangle> top;
    std::unique_ptr<Factor> factor;
};

/// Stiffness of half-spaces of E = 1 under discs of radius 1: a profile each.
using Stiffnesses = std::array<double, 2>;
constexpr std::array<Profile, 2> kProfiles{uniform_profile, hertz_profile};

GridPlanes planes_of(double size, int inner, int outer) {
    const auto across = graded_planes(0.0, size, 0.0, 1.5, inner, outer);
    return {across, across, graded_planes(0.0, size, size - 1.5, size, inner, outer)};
}

Stiffnesses by_tetrahedra(double size, double poisson, int inner, int outer) {
    const Block block(planes_of(size, inner, outer), poisson);
    std::vector<LoadShares> loads;
    for (const Profile profile : kProfiles)
        loads.push_back(shares_on(block.position_m, block.top, {{0.0, 0.0, size}, 1.0, profile}));
    const auto c = compliances(*block.factor, loads, block.unknown);
    return {4.0 / c[0](2, 2), 4.0 / c[1](2, 2)};
}

Stiffnesses by_quadratic_tetrahedra(double size, double poisson, int inner, int outer) {
    Scene scene;
    scene.fixed.push_back({std::array<double, 6>{-1e3, -1e3, -1.0, 1e3, 1e3, 0.0}, "", 1});
    QuadraticMesh mesh = make_quadratic(scene, mesh_of_grid(planes_of(size, inner, outer)));
    const auto height = [&](std::int32_t node) { return mesh.position_m[static_cast<std::size_t>(node)][2]; };
    std::erase_if(mesh.triangle, [&](const std::array<std::int32_t, 6>& face) {
        return std::any_of(face.begin(), face.end(), [&](std::int32_t node) { return height(node) != size; });
    });
    auto k = assemble_quadratic(mesh, {1.0, poisson});
    hold_symmetry(mesh.position_m, mesh.unknown, k);
    const Factor factor(k);
    std::vector<LoadShares> loads;
    for (const Profile profile : kProfiles) loads.push_back(shares_on(mesh, {{0.0, 0.0, size}, 1.0, profile}));
    const auto c = compliances(factor, loads, mesh.unknown);
    return {4.0 / c[0](2, 2), 4.0 / c[1](2, 2)};
}

Stiffnesses by_bricks(double size, double poisson, int inner, int outer) {
    std::vector<Footprint> footprints;
    for (const Profile profile : kProfiles) footprints.push_back({{0.0, 0.0, size}, 1.0, profile});
    const auto c = brick_compliances({planes_of(size, inner, outer), true}, Lame::from_young(1.0, poisson), footprints);
    return {1.0 / c[0](2, 2), 1.0 / c[1](2, 2)};
}

/// k (1 - nu^2) of the half-space: the mesh's error falls with its square (of bricks it is far below), the block's with
/// its size. Both are extrapolated.
template <typename Measure>
Stiffnesses half_space(const Measure& at, double poisson, std::array<int, 2> inner, std::array<int, 2> outer) {
    Stiffnesses result{};
    std::array<Stiffnesses, 2> of_size{};
    for (std::size_t s = 0; s < 2; ++s) {
        const double size = s == 0 ? 20.0 : 40.0;
        const Stiffnesses coarse = at(size, poisson, inner[0], outer[0]), fine = at(size, poisson, inner[1], outer[1]);
        for (std::size_t p = 0; p < 2; ++p) of_size[s][p] = fine[p] + (fine[p] - coarse[p]) / 3.0;
    }
    for (std::size_t p = 0; p < 2; ++p) result[p] = (2.0 * of_size[1][p] - of_size[0][p]) * (1.0 - poisson * poisson);
    return result;
}

// ---- a bonded layer under a sphere ---------------------------------------------------------------------------------

/// F of Dimitriadis et al. 2002 over Hertz's, for a layer bonded to its bed; chi = sqrt(R depth) / thickness <= 1.
double dimitriadis(double chi, double nu) {
    constexpr double kPi = std::numbers::pi;
    const double a = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
    const double b = (0.6387 - 1.0277 * nu + 1.5164 * nu * nu) / (1.0 - nu);
    const double a3 = a * a * a;
    return 1.0 - 2.0 * a / kPi * chi + 4.0 * a * a / (kPi * kPi) * chi * chi -
           8.0 / (kPi * kPi * kPi) * (a3 + 4.0 * kPi * kPi / 15.0 * b) * std::pow(chi, 3) +
           16.0 * a / std::pow(kPi, 4) * (a3 + 3.0 * kPi * kPi / 5.0 * b) * std::pow(chi, 4);
}

/// A quarter of a layer of thickness 1 and a sphere above it.
class Layer {
public:
    /// Fine to 1.6 times `chi`; `cells` along each edge.
    Layer(double chi, double nu, double width, int cells)
        : nu_(nu), block_(planes(chi, width, cells), nu), reach_(1.52 * chi) {
        for (std::size_t i = 0; i < block_.position_m.size(); ++i)
            if (block_.is_top(static_cast<std::int32_t>(i), 1.0) && r2(i) < reach_ * reach_) near_.push_back(i);
        const auto count = static_cast<Index>(near_.size());
        Eigen::MatrixXd b = Eigen::MatrixXd::Zero(block_.factor->size(), count), x;
        for (Index k = 0; k < count; ++k) b(row(k), k) = 1.0;
        block_.factor->solve(b, x);
        c_.resize(count, count);
        for (Index k = 0; k < count; ++k) c_.row(k) = x.row(row(k));
    }

    /// F over Hertz's, without friction: nodes under the sphere push, none pulls.
    double over_hertz(double chi) const {
        const double depth = chi * chi / kRadius;
        std::vector<Index> active;
        for (Index k = 0; k < c_.rows(); ++k)
            if (gap(k, depth) > 0.0) active.push_back(k);
        for (;;) {
            Eigen::VectorXd u(static_cast<Index>(active.size()));
            for (Index k = 0; k < u.size(); ++k) u[k] = gap(active[static_cast<std::size_t>(k)], depth);
            const Eigen::VectorXd f = c_(active, active).ldlt().solve(u);
            std::vector<Index> pushing;
            for (Index k = 0; k < f.size(); ++k)
                if (f[k] > 0.0) pushing.push_back(active[static_cast<std::size_t>(k)]);
            if (pushing.size() == active.size())
                return 4.0 * f.sum() / (4.0 / 3.0 / (1.0 - nu_ * nu_) * std::sqrt(kRadius) * std::pow(depth, 1.5));
            active = pushing;
        }
    }

private:
    static constexpr double kRadius = 100.0;  // of the sphere: so flat that it is a paraboloid

    static GridPlanes planes(double chi, double width, int cells) {
        const auto across = graded_planes(0.0, width, 0.0, 1.6 * chi, cells / 2, cells - cells / 2);
        std::vector<double> up;
        for (int k = 0; k <= cells; ++k) up.push_back(static_cast<double>(k) / cells);
        return {across, across, up};
    }
    double r2(std::size_t node) const { return block_.position_m[node].head<2>().squaredNorm(); }
    double gap(Index k, double depth) const { return depth - r2(near_[static_cast<std::size_t>(k)]) / (2.0 * kRadius); }
    Index row(Index k) const { return Index{3} * block_.unknown[near_[static_cast<std::size_t>(k)]] + 2; }

    double nu_;
    Block block_;
    double reach_;
    std::vector<std::size_t> near_;  // nodes on top that the sphere may touch
    Eigen::MatrixXd c_;
};

/// F over Dimitriadis's at chi, extrapolated over the mesh (its error falls with the square of the edge) and corrected
/// for the width. The mean of depths around it: the rim of contact moves from node to node.
double layer_over_dimitriadis(double chi, double nu) {
    const auto mean = [&](double width, int cells) {
        constexpr int kDepths = 9;
        const Layer layer(chi, nu, width, cells);
        double sum = 0.0;
        for (int k = 0; k < kDepths; ++k) {
            const double at = chi * (0.94 + 0.12 * k / (kDepths - 1));
            sum += layer.over_hertz(at) / dimitriadis(at, nu) / kDepths;
        }
        return sum;
    };
    const double coarse = mean(5.0, 14), fine = mean(5.0, 28);
    return fine + (fine - coarse) / 3.0 + mean(8.0, 14) - coarse;
}

// ---- CalculiX ------------------------------------------------------------------------------------------------------

double largest_difference(const Displacements& theirs, const Eigen::MatrixXd& ours,
                          std::span<const std::int32_t> unknown) {
    double difference = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < theirs.size(); ++i) {
        const Vector3d u = unknown[i] < 0 ? Vector3d::Zero().eval() : ours.block<3, 1>(Index{3} * unknown[i], 0).eval();
        difference = std::max(difference, (u - theirs[i]).norm());
        largest = std::max(largest, theirs[i].norm());
    }
    return difference / largest;
}

/// An oblique force on one free node of the surface, its opposite on another.
NodalForces pulled_apart(std::span<const std::int32_t> free_surface) {
    const Vector3d force(0.03, -0.02, -0.09);
    return {{free_surface[free_surface.size() / 3], force}, {free_surface[2 * free_surface.size() / 3], -0.4 * force}};
}

Eigen::MatrixXd solve(const Factor& factor, const NodalForces& load, std::span<const std::int32_t> unknown) {
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(factor.size(), 1), x;
    for (const auto& [node, force] : load) b.block<3, 1>(Index{3} * unknown[static_cast<std::size_t>(node)], 0) = force;
    factor.solve(b, x);
    return x;
}

double against_c3d4(const Scene& scene, const Body& body, const fs::path& folder) {
    const NodalForces load = pulled_apart(body.free_surface_node);
    const Factor factor(assemble_free(scene, body));
    const Deck deck{body.mesh.position_m, lists_of(body.mesh.tet), held_of(body.unknown), scene.material};
    const auto theirs = run_calculix(deck, std::span(&load, 1), folder);
    return largest_difference(theirs.front(), solve(factor, load, body.unknown), body.unknown);
}

double against_c3d10(const Scene& scene, const TetMesh& mesh, const NodalForces& load, const fs::path& folder) {
    const QuadraticMesh quadratic = make_quadratic(scene, mesh);
    const Factor factor(assemble_quadratic(quadratic, scene.material));
    const Deck deck{quadratic.position_m, lists_of(quadratic.tet), held_of(quadratic.unknown), scene.material};
    const auto theirs = run_calculix(deck, std::span(&load, 1), folder);
    return largest_difference(theirs.front(), solve(factor, load, quadratic.unknown), quadratic.unknown);
}

Scene held_below(double poisson) {
    Scene scene;
    scene.material = {1e4, poisson};
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1});
    return scene;
}

/// A beam of 10 x 10 x 100 mm: ten cubes of 4 x 4 x 4 cells, one upon the other.
TetMesh beam() {
    constexpr double kSide = 0.01, kCell = kSide / 4.0;
    const TetMesh cube = make_cube(5, kSide);
    TetMesh mesh;
    std::map<std::array<std::int64_t, 3>, std::int32_t> node_at;
    for (int k = 0; k < 10; ++k)
        for (Tet tet : cube.tet) {
            for (std::int32_t& node : tet) {
                const Vector3d x = cube.position_m[static_cast<std::size_t>(node)] + Vector3d(0.0, 0.0, k * kSide);
                const std::array place{std::llround(x[0] / kCell), std::llround(x[1] / kCell),
                                       std::llround(x[2] / kCell)};
                const auto [found, is_new] =
                    node_at.try_emplace({place[0], place[1], place[2]}, static_cast<std::int32_t>(node_at.size()));
                if (is_new) mesh.position_m.push_back(x);
                node = found->second;
            }
            mesh.tet.push_back(tet);
        }
    return mesh;
}

/// Deflection of the beam's end in 10-node tetrahedra over Timoshenko's, less 1.
double beam_error() {
    constexpr double kSide = 0.01, kLength = 0.1, kForce = 1e-3;
    const Scene scene = held_below(0.3);
    const QuadraticMesh mesh = make_quadratic(scene, beam());
    const Factor factor(assemble_quadratic(mesh, scene.material));
    // Within the end: a wider disc would push the sides near it too, and be felt as a shorter beam.
    const LoadShares end = shares_on(mesh, {{0.5 * kSide, 0.5 * kSide, kLength}, 0.45 * kSide, uniform_profile});
    const double deflection = kForce * compliances(factor, std::span(&end, 1), mesh.unknown).front()(0, 0);
    const double e = scene.material.young_pa, nu = scene.material.poisson, inertia = std::pow(kSide, 4) / 12.0;
    const double shear = (12.0 + 11.0 * nu) / (10.0 * (1.0 + nu)) / (e / (2.0 * (1.0 + nu)) * kSide * kSide);
    return deflection / (kForce * (std::pow(kLength, 3) / (3.0 * e * inertia) + shear * kLength)) - 1.0;
}

// ---- tables --------------------------------------------------------------------------------------------------------

Number share(double value) { return number(value, fmt::format("{:+.2g} %", 100.0 * value)); }

void add_half_space(const std::string& elements, const Stiffnesses& k, NumberTable& table) {
    const Stiffnesses answer{3.0 * std::numbers::pi * std::numbers::pi / 16.0, 5.0 / 3.0};
    constexpr std::array kWhat{"half-space under a uniform disc, k (1 - nu^2) / (E a)",
                               "half-space under Hertz's pressure, k (1 - nu^2) / (E a)"};
    for (std::size_t p = 0; p < 2; ++p)
        table.rows.push_back({kWhat[p], elements, number(k[p], fmt::format("{:.3f}", k[p])),
                              number(answer[p], fmt::format("{:.3f}", answer[p])), share(k[p] / answer[p] - 1.0)});
}

void add_layers(NumberTable& table) {
    for (double chi : {0.25, 0.5, 1.0}) {
        const double off = layer_over_dimitriadis(chi, 0.3), answer = dimitriadis(chi, 0.3);
        table.rows.push_back({fmt::format("bonded layer under a sphere, F over Hertz's, sqrt(R d) = {} of it", chi),
                              "linear, nu 0.3", number(off * answer, fmt::format("{:.3f}", off * answer)),
                              number(answer, fmt::format("{:.3f}, Dimitriadis 2002", answer)), share(off - 1.0)});
    }
}

void add_calculix(const fs::path& build, NumberTable& table) {
    const auto add = [&](const std::string& what, const char* elements, const char* answer, double difference) {
        table.rows.push_back({what, elements, "displacements of all nodes", answer, error_of(difference)});
    };
    for (const char* name : {"cube", "mouse", "liver"}) {
        const Scene scene = read_scene(fmt::format("meshes/{}.toml", name));
        const Body body = make_body(scene, make_mesh(scene.mesh));
        add(name, "linear", "CalculiX, C3D4", against_c3d4(scene, body, build / (std::string(name) + "-c3d4")));
        add(name, "the reference's 10-node tetrahedra", "CalculiX, C3D10",
            against_c3d10(scene, body.mesh, pulled_apart(body.free_surface_node),
                          build / (std::string(name) + "-c3d10")));
    }
    const Scene scene = held_below(0.3);
    const Body body = make_body(scene, beam());
    add("cantilever 1:10", "linear", "CalculiX, C3D4", against_c3d4(scene, body, build / "beam-c3d4"));
    table.rows.push_back({"cantilever 1:10, deflection of its end", "the reference's 10-node tetrahedra", "",
                          "Timoshenko", share(beam_error())});
}

}  // namespace

NumberTable known_answers(const fs::path& build, Progress& progress) {
    NumberTable table{{"body", "elements", "measured", "known answer", "off by"}, {}};
    progress.stage("half-spaces");
    add_half_space("linear, nu 0.3", half_space(by_tetrahedra, 0.3, {8, 16}, {9, 18}), table);
    add_half_space("10-node tetrahedra, nu 0.3", half_space(by_quadratic_tetrahedra, 0.3, {3, 6}, {4, 7}), table);
    add_half_space("the reference's bricks, nu 0.3", half_space(by_bricks, 0.3, {3, 6}, {4, 6}), table);
    add_half_space("the reference's bricks, nu 0.49", half_space(by_bricks, 0.49, {3, 6}, {4, 6}), table);
    progress.stage("a bonded layer");
    add_layers(table);
    progress.stage("CalculiX");
    add_calculix(build, table);
    return table;
}

}  // namespace haptable
