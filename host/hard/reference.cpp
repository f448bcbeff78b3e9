// SPDX-License-Identifier: GPL-2.0-or-later
// K = sum_e V_e B^T D B,   B the strains (Voigt) of the corners' displacements
#include "host/hard/reference.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using Strains = Eigen::Matrix<Real, 6, 12>;
using Index = Eigen::Index;

struct Elastic {
    Real lambda, mu;
};

Elastic elastic(const Material& material) {
    const Real e = material.young_pa, nu = material.poisson;
    return {e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))};
}

struct Tetrahedron {
    Real volume;
    Strains strains;  // xx yy zz 2xy 2yz 2zx
    Eigen::Matrix<Real, 1, 12> volume_change() const { return strains.topRows<3>().colwise().sum(); }
};

/// The gradients are the rows of the inverse of [1 x y z] at the corners.
Tetrahedron tetrahedron_of(const Body& body, const Tet& tet) {
    Eigen::Matrix<Real, 4, 4> m;
    const Eigen::Vector3d& origin = body.mesh.position_m[static_cast<std::size_t>(tet[0])];
    for (Index a = 0; a < 4; ++a) {
        const auto& x = body.mesh.position_m[static_cast<std::size_t>(tet[static_cast<std::size_t>(a)])];
        m.row(a) << 1, (x.cast<Real>() - origin.cast<Real>()).transpose();
    }
    const Eigen::Matrix<Real, 4, 4> inverse = m.partialPivLu().inverse();
    Tetrahedron element{std::abs(m.partialPivLu().determinant()) / 6, Strains::Zero()};
    for (Index a = 0; a < 4; ++a) {
        const Real x = inverse(1, a), y = inverse(2, a), z = inverse(3, a);
        element.strains.middleCols<3>(3 * a) << x, 0, 0, 0, y, 0, 0, 0, z, y, x, 0, 0, z, y, z, 0, x;
    }
    return element;
}

/// The rows of the corners' displacements among the unknowns, -1 where they are held.
std::array<Index, 12> rows_of(const Body& body, const Tet& tet) {
    std::array<Index, 12> rows{};
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t node = body.unknown[static_cast<std::size_t>(tet[a])];
            rows[3 * a + c] = node < 0 ? -1 : Index{3} * node + static_cast<Index>(c);
        }
    return rows;
}

class Assembly {
public:
    Assembly(const Scene& scene, const Body& body)
        : scene_(scene),
          body_(body),
          k_(Matrix::Zero(Index{3} * std::ssize(body.free_node), Index{3} * std::ssize(body.free_node))) {}

    Matrix run() {
        for (std::size_t t = 0; t < body_.mesh.tet.size(); ++t) {
            element_.push_back(tetrahedron_of(body_, body_.mesh.tet[t]));
            const auto [lambda, mu] = material_of(t);
            const Tetrahedron& e = element_.back();
            Eigen::Matrix<Real, 6, 1> shear;
            shear << 2 * mu, 2 * mu, 2 * mu, mu, mu, mu;
            const Eigen::Matrix<Real, 12, 12> k =
                e.volume * (e.strains.transpose() * shear.asDiagonal() * e.strains +
                            kept(t) * e.volume_change().transpose() * e.volume_change());
            const auto rows = rows_of(body_, body_.mesh.tet[t]);
            for (std::size_t r = 0; r < 12; ++r)
                for (std::size_t c = 0; c < 12; ++c)
                    if (rows[r] >= 0 && rows[c] >= 0)
                        k_(rows[r], rows[c]) += k(static_cast<Index>(r), static_cast<Index>(c));
        }
        if (scene_.mesh.element == Element::kAverageNodalPressure) add_nodal_pressures();
        return k_;
    }

private:
    Material named(std::size_t t) const {
        const std::int32_t region = body_.region[t];
        return region < 0 ? scene_.material : scene_.regions[static_cast<std::size_t>(region)].material;
    }
    Elastic material_of(std::size_t t) const { return elastic(named(t)); }
    /// What an element keeps of lambda.
    Real kept(std::size_t t) const {
        const auto [lambda, mu] = material_of(t);
        return scene_.mesh.element == Element::kLinear ? lambda : std::min(lambda, mu / 2);
    }
    /// theta_a = sum of V_e / 4 div_e u over that of V_e / 4, of the elements at a node of one material.
    void add_nodal_pressures() {
        for (std::int32_t r = -1; r < static_cast<std::int32_t>(scene_.regions.size()); ++r)
            for (std::size_t a = 0; a < body_.mesh.position_m.size(); ++a) {
                Vector theta = Vector::Zero(k_.rows());
                Real volume = 0, rest = 0;
                for (std::size_t t = 0; t < element_.size(); ++t) {
                    const Tet& tet = body_.mesh.tet[t];
                    if (body_.region[t] != r ||
                        std::find(tet.begin(), tet.end(), static_cast<std::int32_t>(a)) == tet.end())
                        continue;
                    volume += element_[t].volume / 4;
                    rest = material_of(t).lambda - kept(t);
                    const auto rows = rows_of(body_, tet);
                    const auto div = element_[t].volume_change();
                    for (std::size_t c = 0; c < 12; ++c)
                        if (rows[c] >= 0) theta[rows[c]] += element_[t].volume / 4 * div[static_cast<Index>(c)];
                }
                if (volume > 0) k_ += rest / volume * theta * theta.transpose();
            }
    }

    const Scene& scene_;
    const Body& body_;
    Matrix k_;
    std::vector<Tetrahedron> element_;
};

/// By powers.
Real largest_eigenvalue(const Matrix& a) {
    Vector x = Vector::NullaryExpr(a.rows(), [](Index i) { return 1 + std::sin(static_cast<Real>(i)) / 2; });
    Real value = 0;
    for (int step = 0; step < 60; ++step) {
        x = (a * x.normalized()).eval();
        value = x.norm();
    }
    return value;
}

}  // namespace

Reference solve_densely(const Scene& scene, const Body& body) {
    const Matrix k = Assembly(scene, body).run();
    const Vector root = k.diagonal().cwiseSqrt();
    const Matrix scaled = root.cwiseInverse().asDiagonal() * k * root.cwiseInverse().asDiagonal();
    const Matrix inverse = scaled.llt().solve(Matrix::Identity(k.rows(), k.cols()));
    const Matrix l = root.cwiseInverse().asDiagonal() * inverse * root.cwiseInverse().asDiagonal();
    return {l.cast<double>(), static_cast<double>(largest_eigenvalue(scaled) * largest_eigenvalue(inverse))};
}

}  // namespace haptable
