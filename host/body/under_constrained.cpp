// SPDX-License-Identifier: GPL-2.0-or-later
// v_p(x) = t_p + w_p x (x - c):  v_p(x) = v_q(x) where parts p, q share node x,  v_p(x) = 0 where x is fixed,
//   n . v_p(x) = 0, P v_p(x) = 0 where x is on a bed that resists it
//
// A tetrahedron without strain moves rigidly, and two that share a face move alike. So the null space of the
// reduced K is the null space of these conditions on the rigid motions (t_p, w_p) of the face-connected parts: a
// matrix of 6 rows a part instead of 3 a node.
#include "host/body/under_constrained.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/dense/dense.hpp"
#include "host/inverse/factor.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/sets.hpp"

namespace haptable {

namespace {

// 6 * 64 unknowns take a fraction of a second; a body has one part, or a few.
constexpr std::int32_t kMostParts = 64;
// Eigenvalues go with the square of the lever (relative to the body) that holds a part against turning: levers
// below 1e-6.5 of the body's size are no hold.
constexpr double kZeroEigenvalue = 1e-13;
// Fraction of the largest motion that counts as moving: hinges themselves stand still to rounding.
constexpr double kMoves = 1e-6;

/// Face-connected parts, and which of them every node belongs to.
struct Parts {
    std::int32_t count = 0;
    std::vector<std::vector<std::int32_t>> of_node;  // [N] parts, ascending
};

Parts find_parts(const Body& body) {
    const std::vector<Tet>& tets = body.mesh.tet;
    Sets sets(tets.size());
    for (const auto& [a, b] : body.surface.joint) sets.join(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
    Parts parts;
    parts.of_node.resize(body.mesh.position_m.size());
    const std::vector<std::size_t> number = sets.numbers();
    for (std::size_t t = 0; t < tets.size(); ++t) {
        const auto part = static_cast<std::int32_t>(number[t]);
        parts.count = std::max(parts.count, part + 1);
        for_each_node(body.mesh, t, [&](std::int32_t node) {
            auto& list = parts.of_node[static_cast<std::size_t>(node)];
            if (std::find(list.begin(), list.end(), part) == list.end()) list.push_back(part);
        });
    }
    return parts;
}

/// Nodes of bodies that no chain of tetrahedra ties to a fixed node.
std::vector<std::int32_t> find_adrift(const Body& body) {
    const std::vector<std::size_t> of_node = number_bodies(body.mesh);
    std::vector<char> tied(of_node.size(), 0);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(of_node.size()); ++i)
        if (body.is_fixed(i)) tied[of_node[static_cast<std::size_t>(i)]] = 1;
    for (const LayeredFace& face : body.layered)
        if (face.layer.has_bed()) tied[of_node[static_cast<std::size_t>(face.node[0])]] = 1;
    std::vector<std::int32_t> adrift;
    for (std::int32_t i : body.free_node)
        if (!tied[of_node[static_cast<std::size_t>(i)]]) adrift.push_back(i);
    return adrift;
}

/// v(x) as a matrix on (t, w); lengths relative to the body, so that t and w weigh alike.
class RigidMotion {
public:
    explicit RigidMotion(const Body& body) : position_m_(body.mesh.position_m) {
        Eigen::AlignedBox3d box;
        for (const Eigen::Vector3d& p : position_m_) box.extend(p);
        centre_m_ = box.center();
        size_m_ = box.diagonal().norm();
    }
    Eigen::Matrix<double, 3, 6> at(std::int32_t node) const {
        const Eigen::Vector3d r = (position_m_[static_cast<std::size_t>(node)] - centre_m_) / size_m_;
        Eigen::Matrix<double, 3, 6> motion;
        motion << 1, 0, 0, 0, r.z(), -r.y(),  //
            0, 1, 0, -r.z(), 0, r.x(),        //
            0, 0, 1, r.y(), -r.x(), 0;
        return motion;
    }

private:
    const std::vector<Eigen::Vector3d>& position_m_;
    Eigen::Vector3d centre_m_;
    double size_m_ = 1.0;
};

/// A bed's conditions, at the corners of its faces: n . v = 0 or P v = 0, as a square matrix.
Eigen::Matrix3d bed_square(const Body& body, const LayeredFace& face) {
    const auto at = [&](std::size_t c) { return body.mesh.position_m[static_cast<std::size_t>(face.node[c])]; };
    const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
    if (face.layer.normal_n_per_m3 > 0.0) square += n * n.transpose();
    if (face.layer.tangential_n_per_m3 > 0.0) square += Eigen::Matrix3d::Identity() - n * n.transpose();
    return square;
}

void add_beds(const Body& body, const Parts& parts, const RigidMotion& motion, Eigen::MatrixXd& gram) {
    for (const LayeredFace& face : body.layered) {
        if (!face.layer.has_bed()) continue;
        const Eigen::Matrix3d square = bed_square(body, face);
        for (std::size_t c = 0; c < 3; ++c) {
            const Eigen::Matrix<double, 3, 6> v = motion.at(face.node[c]);
            const Eigen::Index p =
                6 * static_cast<Eigen::Index>(parts.of_node[static_cast<std::size_t>(face.node[c])].front());
            gram.block<6, 6>(p, p) += v.transpose() * square * v;
        }
    }
}

/// C^T C of all conditions C (t_p, w_p) = 0.
Eigen::MatrixXd gram_matrix(const Body& body, const Parts& parts, const RigidMotion& motion) {
    const Eigen::Index size = 6 * static_cast<Eigen::Index>(parts.count);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(size, size);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(parts.of_node.size()); ++i) {
        const auto& list = parts.of_node[static_cast<std::size_t>(i)];
        if (list.size() < 2 && !body.is_fixed(i)) continue;
        const Eigen::Matrix<double, 3, 6> v = motion.at(i);
        const Eigen::Matrix<double, 6, 6> square = v.transpose() * v;
        for (std::size_t k = 0; k < list.size(); ++k) {
            const Eigen::Index p = 6 * static_cast<Eigen::Index>(list[k]);
            if (body.is_fixed(i)) gram.block<6, 6>(p, p) += square;
            if (body.is_fixed(i) || k == 0) continue;
            const Eigen::Index q = 6 * static_cast<Eigen::Index>(list[0]);  // v_p = v_q
            gram.block<6, 6>(p, p) += square;
            gram.block<6, 6>(q, q) += square;
            gram.block<6, 6>(p, q) -= square;
            gram.block<6, 6>(q, p) -= square;
        }
    }
    add_beds(body, parts, motion, gram);
    return gram;
}

/// Nodes that move in any motion of the parts that the conditions allow.
std::vector<std::int32_t> find_hinged(const Body& body, const Parts& parts) {
    const RigidMotion motion(body);
    const SymmetricEigen eigen = symmetric_eigen(gram_matrix(body, parts, motion));
    const double largest = eigen.values.maxCoeff();
    Eigen::Index zeros = 0;
    while (zeros < eigen.values.size() && !(eigen.values[zeros] > kZeroEigenvalue * largest)) ++zeros;

    Eigen::VectorXd speed = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.mesh.position_m.size()));
    for (std::int32_t i : body.free_node) {
        const Eigen::Index part = parts.of_node[static_cast<std::size_t>(i)].front();
        speed[i] = (motion.at(i) * eigen.vectors.block(6 * part, 0, 6, zeros)).norm();
    }
    std::vector<std::int32_t> hinged;
    for (std::int32_t i : body.free_node)
        if (zeros > 0 && speed[i] > kMoves * speed.maxCoeff()) hinged.push_back(i);
    return hinged;
}

}  // namespace

std::vector<Support> find_supports(const Body& body, const std::vector<std::int32_t>& under_constrained) {
    const std::vector<std::size_t> of_node = number_bodies(body.mesh);
    std::vector<Support> supports(of_node.empty() ? 0 : *std::max_element(of_node.begin(), of_node.end()) + 1);
    const auto of = [&](std::int32_t node) -> Support& { return supports[of_node[static_cast<std::size_t>(node)]]; };
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(of_node.size()); ++i) {
        ++of(i).nodes;
        of(i).fixed_nodes += body.is_fixed(i) ? 1 : 0;
    }
    for (const Tet& tet : body.mesh.tet) ++of(tet[0]).tets;
    for (const LayeredFace& face : body.layered) of(face.node[0]).bed_faces += face.layer.has_bed() ? 1 : 0;
    for (std::int32_t i : under_constrained) of(i).is_constrained = false;
    return supports;
}

std::vector<std::int32_t> find_under_constrained(const Body& body) {
    const Parts parts = find_parts(body);
    return parts.count > kMostParts ? find_adrift(body) : find_hinged(body, parts);
}

std::vector<std::int32_t> find_softest_nodes(const Stiffness& k) {
    // The shift makes K definite; it is far below every stiffness of a constrained body and far above rounding.
    constexpr double kShift = 1e-9;
    const Factor factor(k.shifted(kShift));
    Eigen::MatrixXd x(k.size(), 1);
    for (Eigen::Index j = 0; j < k.size(); ++j) x(j, 0) = 1.0 + 0.5 * static_cast<double>(j % 7);  // no symmetry
    for (int step = 0; step < 3 && factor.weakest_pivot().ratio > 0.0; ++step) {
        Eigen::MatrixXd next;
        factor.solve(x, next);
        x = next / next.norm();
    }
    std::vector<std::int32_t> softest;
    const double most = x.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < k.size() / 3; ++i)
        if (x.block<3, 1>(3 * i, 0).norm() > 1e-3 * most) softest.push_back(static_cast<std::int32_t>(i));
    return softest;
}

std::string describe_under_constrained(const std::vector<std::int32_t>& nodes, const Body& body) {
    Eigen::AlignedBox3d box_m;
    for (std::int32_t i : nodes) box_m.extend(body.mesh.position_m[static_cast<std::size_t>(i)]);
    const std::size_t shown = std::min<std::size_t>(nodes.size(), 5);
    const auto first = nodes.begin();
    const bool has_bed = std::any_of(body.layered.begin(), body.layered.end(),
                                     [](const LayeredFace& face) { return face.layer.has_bed(); });
    return fmt::format(
        "{} of {} nodes are under-constrained (mesh nodes {}{}, in the box {}), so that K is singular; fix "
        "at least three of them that are not on one line, by [[fixed]], or {}",
        nodes.size(), body.mesh.position_m.size(), fmt::join(first, first + static_cast<std::ptrdiff_t>(shown), ", "),
        shown < nodes.size() ? ", ..." : "", describe(box_m),
        has_bed ? "give its [[bed]] tangential too: on a flat one with normal alone a body slides"
                : "lay it on a [[bed]]");
}

}  // namespace haptable
