// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fem/face_layer.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// Of three nodes or six: rows, or columns.
template <int columns>
using NodeRows = Eigen::Matrix<double, Eigen::Dynamic, columns, 0, 6, columns>;
using NodeColumns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 6>;

/// Shape functions, and their derivatives by the barycentric coordinates 1 and 2.
struct Shape {
    NodeRows<1> value;
    NodeRows<2> along;
};

Shape shape_at(const Vector3d& t, std::size_t nodes) {
    const auto count = static_cast<Index>(nodes);
    NodeRows<3> by_t = NodeRows<3>::Zero(count, 3);
    NodeRows<1> value(count);
    for (Index c = 0; c < 3; ++c) {
        value[c] = nodes == 3 ? t[c] : t[c] * (2.0 * t[c] - 1.0);
        by_t(c, c) = nodes == 3 ? 1.0 : 4.0 * t[c] - 1.0;
    }
    for (Index c = 0; c < count - 3; ++c) {  // the middle of c and the next corner
        const Index next = (c + 1) % 3;
        value[3 + c] = 4.0 * t[c] * t[next];
        by_t(3 + c, c) = 4.0 * t[next];
        by_t(3 + c, next) = 4.0 * t[c];
    }
    NodeRows<2> along(count, 2);
    along << by_t.col(1) - by_t.col(0), by_t.col(2) - by_t.col(0);
    return {value, along};
}

/// One point of integration of a face.
struct FacePoint {
    double area_m2 = 0.0;  ///< that it stands for
    Vector3d normal;
    NodeRows<1> value;
    NodeColumns gradient_per_m;  ///< along the surface
};

/// Six points, exact for polynomials of degree 4 (Cowper 1973).
template <typename Visit>
void for_each_point(std::span<const Vector3d> position_m, const LayeredFace& face, Visit visit) {
    NodeColumns x(3, static_cast<Index>(face.nodes));
    for (std::size_t a = 0; a < face.nodes; ++a)
        x.col(static_cast<Index>(a)) =
            position_m[static_cast<std::size_t>(face.node[a])] - position_m[static_cast<std::size_t>(face.node[0])];
    for (const double sign : {1.0, -1.0}) {
        const double near = (8.0 - std::sqrt(10.0) + sign * std::sqrt(38.0 - 44.0 * std::sqrt(0.4))) / 18.0;
        const double weight = (620.0 + sign * std::sqrt(213125.0 - 53320.0 * std::sqrt(10.0))) / 3720.0;
        for (Index c = 0; c < 3; ++c) {
            Vector3d t = Vector3d::Constant(near);
            t[c] = 1.0 - 2.0 * near;
            const Shape shape = shape_at(t, face.nodes);
            const Eigen::Matrix<double, 3, 2> along = x * shape.along;
            const Vector3d normal = along.col(0).cross(along.col(1));
            const Eigen::Matrix<double, 3, 2> dual = along * (along.transpose() * along).inverse();
            visit(FacePoint{0.5 * weight * normal.norm(), normal.normalized(), shape.value,
                            dual * shape.along.transpose()});
        }
    }
}

Matrix3d along_surface(const Vector3d& normal) { return Matrix3d::Identity() - normal * normal.transpose(); }

Matrix3d block_of(const FacePoint& p, const Layer& layer, Index a, Index b) {
    const Vector3d ga = p.gradient_per_m.col(a), gb = p.gradient_per_m.col(b);
    const Matrix3d tangent = along_surface(p.normal), across = p.normal * p.normal.transpose();
    return layer.lambda_n_per_m * ga * gb.transpose() +
           layer.mu_n_per_m * (gb * ga.transpose() + ga.dot(gb) * tangent) +
           p.value[a] * p.value[b] * (layer.normal_n_per_m3 * across + layer.tangential_n_per_m3 * tangent);
}

/// Stress times thickness, N/m.
Matrix3d tension_of(const FacePoint& p, const Layer& layer, const NodeColumns& moves) {
    const Matrix3d tangent = along_surface(p.normal), along = tangent * (moves * p.gradient_per_m.transpose());
    return layer.lambda_n_per_m * along.trace() * tangent + layer.mu_n_per_m * (along + along.transpose());
}

template <typename Block>
Eigen::MatrixXd integrate(std::span<const Vector3d> position_m, const LayeredFace& face, Block block) {
    const auto nodes = static_cast<Index>(face.nodes);
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * nodes, 3 * nodes);
    for_each_point(position_m, face, [&](const FacePoint& point) {
        for (Index a = 0; a < nodes; ++a)
            for (Index b = 0; b <= a; ++b) k.block<3, 3>(3 * a, 3 * b) += point.area_m2 * block(point, a, b);
    });
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return k;
}

}  // namespace

Layer Layer::membrane(double thickness_m, double young_pa, double poisson) {
    return {thickness_m * young_pa * poisson / (1.0 - poisson * poisson),
            thickness_m * young_pa / (2.0 * (1.0 + poisson)), 0.0, 0.0};
}

Layer Layer::bed(double normal_n_per_m3, double tangential_n_per_m3) {
    return {0.0, 0.0, normal_n_per_m3, tangential_n_per_m3};
}

Layer& Layer::operator+=(const Layer& other) {
    lambda_n_per_m += other.lambda_n_per_m;
    mu_n_per_m += other.mu_n_per_m;
    normal_n_per_m3 += other.normal_n_per_m3;
    tangential_n_per_m3 += other.tangential_n_per_m3;
    return *this;
}

std::span<const std::int32_t> nodes_of(const LayeredFace& face) { return std::span(face.node).first(face.nodes); }

Eigen::MatrixXd layer_stiffness(std::span<const Vector3d> position_m, const LayeredFace& face) {
    return integrate(position_m, face,
                     [&](const FacePoint& point, Index a, Index b) { return block_of(point, face.layer, a, b); });
}

Eigen::MatrixXd layer_geometric_stiffness(std::span<const Vector3d> position_m, const LayeredFace& face,
                                          const Eigen::Matrix3Xd& u) {
    NodeColumns moves(3, static_cast<Index>(face.nodes));
    for (std::size_t a = 0; a < face.nodes; ++a) moves.col(static_cast<Index>(a)) = u.col(face.node[a]);
    return integrate(position_m, face, [&](const FacePoint& p, Index a, Index b) -> Matrix3d {
        const Matrix3d tension = tension_of(p, face.layer, moves);
        return p.gradient_per_m.col(a).dot(tension * p.gradient_per_m.col(b)) * Matrix3d::Identity();
    });
}

double area_of(std::span<const Vector3d> position_m, const LayeredFace& face) {
    double area_m2 = 0.0;
    for_each_point(position_m, face, [&](const FacePoint& point) { area_m2 += point.area_m2; });
    return area_m2;
}

}  // namespace haptable
