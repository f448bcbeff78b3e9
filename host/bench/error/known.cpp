// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/known.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
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

/// [0, W]^2 x [0, H], E = 1, held below, its planes x = 0 and y = 0 of symmetry; the grid's cells in five tetrahedra.
class Block {
public:
    Block(const GridPlanes& plane_m, double poisson) {
        const int n = static_cast<int>(plane_m[0].size());
        TetMesh mesh = make_cube(n, n - 1.0);
        for (Vector3d& x : mesh.position_m)
            for (std::size_t a = 0; a < 3; ++a)
                x[static_cast<Index>(a)] =
                    plane_m[a].at(static_cast<std::size_t>(std::lround(x[static_cast<Index>(a)])));
        position_m = mesh.position_m;
        std::int32_t count = 0;
        for (const Vector3d& x : position_m) unknown.push_back(x[2] > 0.0 ? count++ : -1);
        const std::vector<Lame> material(mesh.tet.size(), Lame::from_young(1.0, poisson));
        auto k = assemble_stiffness({Element::kLinear, position_m, mesh.tet, material}, unknown, count).a;
        std::vector<char> held(static_cast<std::size_t>(k.rows()), 0);
        for (std::size_t i = 0; i < position_m.size(); ++i)
            for (std::size_t a = 0; a < 2; ++a)
                if (unknown[i] >= 0 && position_m[i][static_cast<Index>(a)] == 0.0)
                    held[3 * static_cast<std::size_t>(unknown[i]) + a] = 1;
        hold(held, k);
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

/// The same by tetrahedra and contact without friction: nodes under the sphere push, none pulls.
double layer_over_hertz(double chi, double nu, int cells) {
    constexpr double kRadius = 10.0, kWidth = 8.0;  // thickness 1
    const double depth = chi * chi / kRadius;
    const auto across = graded_planes(0.0, kWidth, 0.0, 1.6 * chi, cells / 2, cells - cells / 2);
    std::vector<double> up;
    for (int k = 0; k <= cells; ++k) up.push_back(static_cast<double>(k) / cells);
    const Block block({across, across, up}, nu);
    std::vector<Index> row;
    std::vector<double> want;
    for (std::size_t i = 0; i < block.position_m.size(); ++i) {
        const double r2 = block.position_m[i].head<2>().squaredNorm();
        if (!block.is_top(static_cast<std::int32_t>(i), 1.0) || r2 > 2.0 * kRadius * depth) continue;
        row.push_back(Index{3} * block.unknown[i] + 2);
        want.push_back(depth - r2 / (2.0 * kRadius));
    }
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(block.factor->size(), static_cast<Index>(row.size())), x;
    for (std::size_t k = 0; k < row.size(); ++k) b(row[k], static_cast<Index>(k)) = 1.0;
    block.factor->solve(b, x);
    std::vector<Index> active;
    for (std::size_t k = 0; k < row.size(); ++k) active.push_back(static_cast<Index>(k));
    const Eigen::MatrixXd c = x(row, Eigen::all);
    const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(want.data(), static_cast<Index>(want.size()));
    for (;;) {
        const Eigen::VectorXd f = c(active, active).ldlt().solve(u(active));
        std::vector<Index> pushing;
        for (std::size_t k = 0; k < active.size(); ++k)
            if (f[static_cast<Index>(k)] > 0.0) pushing.push_back(active[k]);
        if (pushing.size() == active.size())
            return 4.0 * f.sum() / (4.0 / 3.0 / (1.0 - nu * nu) * std::sqrt(kRadius) * std::pow(depth, 1.5));
        active = pushing;
    }
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

std::vector<std::int32_t> held_of(std::span<const std::int32_t> unknown) {
    std::vector<std::int32_t> held;
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (unknown[i] < 0) held.push_back(static_cast<std::int32_t>(i));
    return held;
}

template <typename Elements>
std::vector<std::vector<std::int32_t>> lists_of(const Elements& elements) {
    std::vector<std::vector<std::int32_t>> lists;
    for (const auto& nodes : elements) lists.emplace_back(nodes.begin(), nodes.end());
    return lists;
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

/// A beam of 10 x 10 x 100 mm.
TetMesh beam() {
    TetMesh mesh = make_cube(9, 0.01);
    for (Vector3d& x : mesh.position_m) x[2] *= 10.0;
    return mesh;
}

/// Deflection of the beam's end in 10-node tetrahedra over Timoshenko's, less 1.
double beam_error() {
    constexpr double kSide = 0.01, kLength = 0.1, kForce = 1e-3;
    const Scene scene = held_below(0.3);
    const QuadraticMesh mesh = make_quadratic(scene, beam());
    const Factor factor(assemble_quadratic(mesh, scene.material));
    const LoadShares end = shares_on(mesh, {{0.5 * kSide, 0.5 * kSide, kLength}, 0.8 * kSide, uniform_profile});
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
    for (double chi : {0.5, 1.0}) {
        const double k = layer_over_hertz(chi, 0.3, 32), answer = dimitriadis(chi, 0.3);
        table.rows.push_back({fmt::format("bonded layer under a sphere, F over Hertz's, sqrt(R d) = {} of it", chi),
                              "linear, nu 0.3", number(k, fmt::format("{:.3f}", k)),
                              number(answer, fmt::format("{:.3f}, Dimitriadis 2002", answer)),
                              share(k / answer - 1.0)});
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

// ---- large strain --------------------------------------------------------------------------------------------------

struct Direction {
    const char* name;
    Vector3d way;
};

struct Felt {
    double displacement_m, ratio;  ///< of the force to the linear one
};

/// Forces that the linear body answers with 1 mm, 2 mm, ...; what the other one gives under them.
std::vector<Felt> pull(const Body& body, const Scene& scene, const LoadShares& shares, double n_per_m,
                       const Direction& direction, const fs::path& build) {
    constexpr int kLevels = 10;
    std::vector<NodalForces> loads(kLevels);
    for (int level = 0; level < kLevels; ++level)
        for (const auto& [node, w] : shares)
            loads[static_cast<std::size_t>(level)][node] = w * 1e-3 * (level + 1) * n_per_m * direction.way;
    const Deck deck{body.mesh.position_m, lists_of(body.mesh.tet), held_of(body.unknown), scene.material, true};
    std::vector<Felt> felt;
    for (const Displacements& moved : run_calculix(deck, loads, build / fmt::format("large-{}", direction.name))) {
        double u = 0.0;
        for (const auto& [node, w] : shares) u += w * moved[static_cast<std::size_t>(node)].dot(direction.way);
        felt.push_back({u, 1e-3 * static_cast<double>(felt.size() + 1) / u});
    }
    return felt;
}

/// Where |ratio - 1| first comes to `off`, between the levels; NaN: not within them.
double where_off(const std::vector<Felt>& felt, double off) {
    Felt last{0.0, 1.0};
    for (const Felt& one : felt) {
        const double before = std::abs(last.ratio - 1.0), now = std::abs(one.ratio - 1.0);
        if (now >= off)
            return last.displacement_m + (off - before) / (now - before) * (one.displacement_m - last.displacement_m);
        last = one;
    }
    return NAN;
}

}  // namespace

NumberTable known_answers(const fs::path& build) {
    NumberTable table{{"body", "elements", "measured", "known answer", "off by"}, {}};
    add_half_space("linear, nu 0.3", half_space(by_tetrahedra, 0.3, {6, 12}, {8, 16}), table);
    add_half_space("the reference's bricks, nu 0.3", half_space(by_bricks, 0.3, {4, 8}, {5, 7}), table);
    add_half_space("the reference's bricks, nu 0.49", half_space(by_bricks, 0.49, {4, 8}, {5, 7}), table);
    add_layers(table);
    add_calculix(build, table);
    return table;
}

LargeStrain large_strain(const fs::path& build) {
    Scene scene = held_below(0.3);
    const Body body = make_body(scene, make_cube(13, 0.03));
    const LoadShares shares = shares_on(body.mesh.position_m, body.surface.patch, {{0.015, 0.015, 0.03}, 0.005});
    const Factor factor(assemble_free(scene, body));
    const Eigen::Matrix3d c = compliances(factor, std::span(&shares, 1), body.unknown).front();
    LargeStrain result{{{"13 nodes a side, nu 0.3, finger of 5 mm", "5 % off", "10 % off", "20 % off"}, {}},
                       {{"way", "displacement", "force over the linear one"}, {}}};
    for (const Direction& direction :
         {Direction{"pressing", -Vector3d::UnitZ()}, {"sideways", Vector3d::UnitX()}, {"pulling", Vector3d::UnitZ()}}) {
        const auto felt = pull(body, scene, shares, 1.0 / direction.way.dot(c * direction.way), direction, build);
        auto& row = result.limits.rows.emplace_back(std::vector<Cell>{direction.name});
        for (double off : {0.05, 0.1, 0.2}) {
            const double u = where_off(felt, off);
            row.push_back(std::isnan(u) ? Cell(fmt::format("not to {:.1f} mm", 1e3 * felt.back().displacement_m))
                                        : Cell(number(u, fmt::format("{:.1f} mm", 1e3 * u))));
        }
        for (const Felt& one : felt)
            result.curve.rows.push_back({direction.name,
                                         number(one.displacement_m, fmt::format("{:.2f} mm", 1e3 * one.displacement_m)),
                                         number(one.ratio, fmt::format("{:.3f}", one.ratio))});
    }
    return result;
}

}  // namespace haptable
