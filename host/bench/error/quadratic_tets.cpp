// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/quadratic_tets.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "host/base/error.hpp"
#include "host/fem/elasticity.hpp"
#include "host/mesh/middles.hpp"
#include "host/mesh/quadratic_tet.hpp"
#include "host/mesh/surface.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// The four tetrahedra around one of the octahedron's three diagonals: its ends, then the ring of the other four.
constexpr std::array<std::array<std::size_t, 6>, 3> kDiagonals{
    {{0, 5, 1, 2, 3, 4}, {1, 3, 0, 2, 5, 4}, {2, 4, 0, 1, 5, 3}}};  // numbers of kTetEdges

std::size_t shortest_diagonal(const std::vector<Vector3d>& position_m, const std::array<std::int32_t, 6>& middle) {
    std::array<double, 3> length{};
    for (std::size_t d = 0; d < 3; ++d)
        length[d] = (position_m[static_cast<std::size_t>(middle[kDiagonals[d][0]])] -
                     position_m[static_cast<std::size_t>(middle[kDiagonals[d][1]])])
                        .norm();
    return static_cast<std::size_t>(std::min_element(length.begin(), length.end()) - length.begin());
}

using Linear = Eigen::Matrix<double, 3, 4>;

/// Gradients of the ten shape functions where the corners' linear ones are `at`.
Eigen::Matrix<double, 3, 10> gradients(const Linear& linear, const Eigen::Vector4d& at) {
    Eigen::Matrix<double, 3, 10> g;
    for (Index c = 0; c < 4; ++c) g.col(c) = (4.0 * at[c] - 1.0) * linear.col(c);
    for (std::size_t e = 0; e < 6; ++e) {
        const auto a = static_cast<Index>(kTetEdges[e][0]), b = static_cast<Index>(kTetEdges[e][1]);
        g.col(4 + static_cast<Index>(e)) = 4.0 * (at[a] * linear.col(b) + at[b] * linear.col(a));
    }
    return g;
}

using ElementMatrix = Eigen::Matrix<double, 30, 30>;

ElementMatrix tet_stiffness(const TetGeometry& geometry, const Lame& material, Volume volume) {
    constexpr double kFar = 0.58541019662496852, kNear = 0.1381966011250105;  // exact for degree 2
    ElementMatrix k = ElementMatrix::Zero();
    Eigen::Matrix<double, 3, 10> mean = Eigen::Matrix<double, 3, 10>::Zero();
    const double lambda_pa = volume == Volume::kEverywhere ? material.lambda_pa : 0.0;
    for (Index q = 0; q < 4; ++q) {
        Eigen::Vector4d at = Eigen::Vector4d::Constant(kNear);
        at[q] = kFar;
        const auto g = gradients(geometry.gradient_per_m, at);
        mean += 0.25 * g;
        for (Index a = 0; a < 10; ++a)
            for (Index b = 0; b < 10; ++b)
                k.block<3, 3>(3 * a, 3 * b) +=
                    0.25 * geometry.volume_m3 *
                    (lambda_pa * g.col(a) * g.col(b).transpose() +
                     material.mu_pa *
                         (g.col(b) * g.col(a).transpose() + g.col(a).dot(g.col(b)) * Eigen::Matrix3d::Identity()));
    }
    const Eigen::Map<const Eigen::Matrix<double, 30, 1>> swelling(mean.data());
    return k + (material.lambda_pa - lambda_pa) * geometry.volume_m3 * swelling * swelling.transpose();
}

bool is_held(const Scene& scene, const Vector3d& x) {
    return std::any_of(scene.fixed.begin(), scene.fixed.end(), [&](const Selection& where) {
        if (!where.box_m) throw Error("the bench's reference holds bodies by boxes only");
        const auto& box = *where.box_m;
        return (x.array() >= Eigen::Array3d(box[0], box[1], box[2])).all() &&
               (x.array() <= Eigen::Array3d(box[3], box[4], box[5])).all();
    });
}

}  // namespace

TetMesh in_eight(const TetMesh& mesh) {
    TetMesh fine;
    fine.position_m = mesh.position_m;
    fine.origin_m = mesh.origin_m;
    Middles middles(fine.position_m);
    const auto add = [&](Tet tet) {
        if (six_volumes(fine.position_m, tet) < 0.0) std::swap(tet[2], tet[3]);
        fine.tet.push_back(tet);
    };
    for (const Tet& tet : mesh.tet) {
        std::array<std::int32_t, 6> middle{};
        for (std::size_t e = 0; e < 6; ++e) middle[e] = middles.of(tet[kTetEdges[e][0]], tet[kTetEdges[e][1]]);
        const auto between = [&](std::size_t a, std::size_t b) { return middles.of(tet[a], tet[b]); };
        for (std::size_t c = 0; c < 4; ++c)
            add({tet[c], between(c, (c + 1) % 4), between(c, (c + 2) % 4), between(c, (c + 3) % 4)});
        const auto& diagonal = kDiagonals[shortest_diagonal(fine.position_m, middle)];
        for (std::size_t r = 0; r < 4; ++r)
            add({middle[diagonal[0]], middle[diagonal[1]], middle[diagonal[2 + r]], middle[diagonal[2 + (r + 1) % 4]]});
    }
    return fine;
}

QuadraticMesh make_quadratic(const Scene& scene, const TetMesh& mesh) {
    QuadraticMesh quadratic;
    quadratic.position_m = mesh.position_m;
    Middles middles(quadratic.position_m);
    for (const Tet& tet : mesh.tet) {
        auto& nodes = quadratic.tet.emplace_back();
        for (std::size_t c = 0; c < 4; ++c) nodes[c] = tet[c];
        for (std::size_t e = 0; e < 6; ++e) nodes[4 + e] = middles.of(tet[kTetEdges[e][0]], tet[kTetEdges[e][1]]);
    }
    for (const Patch& corner : find_surface(mesh.tet).patch)
        quadratic.triangle.push_back({corner[0], corner[1], corner[2], middles.of(corner[0], corner[1]),
                                      middles.of(corner[1], corner[2]), middles.of(corner[2], corner[0])});
    for (const Vector3d& x : quadratic.position_m)
        quadratic.unknown.push_back(is_held(scene, mesh.origin_m + x) ? -1 : quadratic.free_count++);
    return quadratic;
}

Eigen::SparseMatrix<double> assemble_quadratic(const QuadraticMesh& mesh, const Material& material, Volume volume) {
    const Lame lame = Lame::from_young(material.young_pa, material.poisson);
    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& tet : mesh.tet) {
        Corners corner;
        for (std::size_t c = 0; c < 4; ++c) corner[c] = mesh.position_m[static_cast<std::size_t>(tet[c])];
        const ElementMatrix k = tet_stiffness(tet_geometry(corner), lame, volume);
        for (Index a = 0; a < 30; ++a)
            for (Index b = 0; b < 30; ++b) {
                const std::int32_t i = mesh.unknown[static_cast<std::size_t>(tet[static_cast<std::size_t>(a / 3)])];
                const std::int32_t j = mesh.unknown[static_cast<std::size_t>(tet[static_cast<std::size_t>(b / 3)])];
                if (i >= 0 && j >= 0)
                    entries.emplace_back(3 * i + static_cast<int>(a % 3), 3 * j + static_cast<int>(b % 3), k(a, b));
            }
    }
    const Eigen::Index unknowns = 3 * Eigen::Index{mesh.free_count};
    Eigen::SparseMatrix<double> k(unknowns, unknowns);
    k.setFromTriplets(entries.begin(), entries.end());
    return k;
}

LoadShares shares_on(const QuadraticMesh& mesh, const Footprint& footprint) {
    LoadShares shares;
    for (const auto& node : mesh.triangle) {
        std::array<Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c) x[c] = mesh.position_m[static_cast<std::size_t>(node[c])];
        const double longest = std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
        if ((x[0] - footprint.centre_m).norm() > footprint.radius_m + longest) continue;
        const double area = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
        for_each_piece(12, [&](const Vector3d& alpha) {
            const double p = area * footprint.pressure(alpha[0] * x[0] + alpha[1] * x[1] + alpha[2] * x[2]);
            if (p == 0.0) return;
            for (std::size_t c = 0; c < 3; ++c) {
                const double a = alpha[static_cast<Index>(c)], b = alpha[static_cast<Index>((c + 1) % 3)];
                shares[node[c]] += p * a * (2.0 * a - 1.0);
                shares[node[3 + c]] += p * 4.0 * a * b;
            }
        });
    }
    return normed(shares);
}

}  // namespace haptable
