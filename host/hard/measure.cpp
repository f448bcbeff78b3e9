// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/hard/measure.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "codegen/in_memory.hpp"
#include "codegen/precision.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d to_vector(const float x[3]) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

Eigen::Vector3d eigenvalues(const Matrix3d& a) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(0.5 * (a + a.transpose()), Eigen::EigenvaluesOnly).eigenvalues();
}

double condition(const Matrix3d& a) {
    const Vector3d value = eigenvalues(a);
    return value[2] / value[0];
}

/// What the reference says of the points of patches.
class ReferencePoints {
public:
    ReferencePoints(const HardBody& body, const Reference& reference) : body_(body), reference_(reference) {}

    Matrix3d l(std::size_t vertex_a, std::size_t vertex_b) const {
        const std::int32_t a = unknown(vertex_a), b = unknown(vertex_b);
        if (a < 0 || b < 0) return Matrix3d::Zero();
        return reference_.compliance.block<3, 3>(Index{3} * a, Index{3} * b);
    }
    bool is_free(std::size_t vertex) const { return unknown(vertex) >= 0; }
    Vector3d position(std::size_t vertex) const {
        return body_.body().mesh.position_m[static_cast<std::size_t>(body_.servo().node[vertex])];
    }
    /// S at the area coordinates of a patch: sum alpha_a (L_aa)^-1, or (sum alpha_a alpha_b L_ab)^-1 with the servo's
    /// rule for held nodes.
    Matrix3d stiffness(std::size_t patch, const Vector3d& alpha) const {
        const auto& corner = body_.servo().patch[patch];
        const double rigid = body_.tables().rigid_stiffness_n_per_m;
        Matrix3d sum = Matrix3d::Zero();
        if (body_.tables().force == ForceLaw::kInterpolated) {
            for (int a = 0; a < 3; ++a)
                sum += alpha[a] * (is_free(corner[a]) ? Matrix3d(l(corner[a], corner[a]).inverse())
                                                      : Matrix3d(rigid * Matrix3d::Identity()));
            return sum;
        }
        double held = 0.0;
        for (int a = 0; a < 3; ++a) {
            held += is_free(corner[a]) ? 0.0 : alpha[a];
            for (int b = 0; b < 3; ++b) sum += alpha[a] * alpha[b] * l(corner[a], corner[b]);
        }
        sum += std::max(0.0, held / rigid - sum.trace() / 3.0) * Matrix3d::Identity();
        return sum.inverse();
    }

private:
    std::int32_t unknown(std::size_t vertex) const {
        return body_.body().unknown[static_cast<std::size_t>(body_.servo().node[vertex])];
    }
    const HardBody& body_;
    const Reference& reference_;
};

void put(const Vector3d& x, float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(x[c]);
}

}  // namespace

HardBody::HardBody(const HardCase& hard, ForceLaw force, const std::filesystem::path& folder) : hard_(hard) {
    hard_.scene.contact.force = force;
    Progress progress(true);
    PrecomputeOptions options;
    options.force = true;
    result_ = precompute(hard_.scene, folder, progress, options);
    tables_ = read_tables(folder);
    servo_ = build_model(tables_);
}

haptable_model HardBody::model(GodObject god_object) const {
    Tables tables = tables_;
    tables.god_object = god_object;
    tables.release_n_per_ms = 0.0;
    tables.limits = {};
    return model_in_memory(tables, servo_);
}

StiffnessErrors compare_stiffness(const HardBody& body, const Reference& reference) {
    StiffnessErrors errors;
    errors.least_eigenvalue = 1.0;
    for (std::size_t i = 0; i < body.tables().stiffness.size(); ++i) {
        const Eigen::Map<const Matrix3d> rows(body.tables().stiffness[i].data());
        const Matrix3d s = rows.transpose();  // row by row
        const Index at = Index{3} * body.body().unknown[static_cast<std::size_t>(body.tables().node_id[i])];
        const Matrix3d exact = reference.compliance.block<3, 3>(at, at).inverse();
        const double off = (s - exact).norm() / exact.norm(), cond = condition(exact);
        errors.worst = std::max(errors.worst, off);
        errors.in_terms_of_l = std::max(errors.in_terms_of_l, off / cond);
        errors.asymmetry = std::max(errors.asymmetry, (s - s.transpose()).norm() / s.norm());
        errors.condition = std::max(errors.condition, cond);
        const Vector3d value = eigenvalues(s);
        errors.least_eigenvalue = std::min(errors.least_eigenvalue, value[0] / value[2]);
    }
    return errors;
}

ForceErrors compare_force(const HardBody& body, const Reference& reference, GodObject god_object, int most_patches) {
    const haptable_model model = body.model(god_object);
    const ReferencePoints exact(body, reference);
    const std::size_t count = body.servo().patch.size();
    const std::size_t step = std::max<std::size_t>(1, count / static_cast<std::size_t>(most_patches));
    const double depth = small_dent_m(body.tables());
    ForceErrors errors;
    for (std::size_t p = 0; p < count; p += step) {
        const auto& corner = body.servo().patch[p];
        const Vector3d a = exact.position(corner[0]), b = exact.position(corner[1]), c = exact.position(corner[2]);
        const Vector3d normal = (b - a).cross(c - a).normalized();
        const Vector3d on = 0.41 * a + 0.32 * b + 0.27 * c, finger = on - depth * normal;
        haptable_servo servo;
        haptable_output out{};
        haptable_servo_init(&servo);
        float x[3];
        put(on + depth * normal, x);
        haptable_servo_step(&model, &servo, x, 1000, &out);
        put(finger, x);
        haptable_servo_step(&model, &servo, x, 2000, &out);
        if (haptable_touches(out.state) == 0) {
            ++errors.missed;
            continue;
        }
        ++errors.touches;
        const Vector3d alpha = to_vector(out.alpha);
        const auto& touched = body.servo().patch[out.patch];
        Vector3d g = Vector3d::Zero();
        double coordinate = 0.0;
        for (int k = 0; k < 3; ++k) {
            g += alpha[k] * exact.position(touched[k]);
            coordinate = std::max(coordinate, exact.position(touched[k]).cwiseAbs().maxCoeff());
        }
        const Matrix3d s = exact.stiffness(out.patch, alpha);
        const Vector3d meant = -s * (finger - g), own = -s * (to_vector(x) - to_vector(out.god_object_m));
        const Vector3d force = to_vector(out.force_n);
        errors.worst = std::max(errors.worst, (force - meant).norm() / meant.norm());
        errors.rounding = std::max(errors.rounding, (force - own).norm() / own.norm() / condition(s));
        errors.misplaced = std::max(errors.misplaced, (to_vector(out.god_object_m) - g).norm() / coordinate);
    }
    return errors;
}

}  // namespace haptable
