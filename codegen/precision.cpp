// SPDX-License-Identifier: GPL-2.0-or-later
// |F - F_d| / |F_d| <= || (S - S_d) S_d^-1 ||,   S = sum alpha_i S_i   or   C^-1
#include "codegen/precision.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>

#include "codegen/in_memory.hpp"
#include "codegen/polynomial.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

constexpr float kLargestHalf = 32768.0F;  // a power of two below 65504
constexpr float kLargestInt = 32767.0F;
// Points of a patch by their area coordinates.
constexpr std::array<double, 3> kPoint[7] = {
    {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}, {1 / 3., 1 / 3., 1 / 3.}};

float largest_of(const std::array<float, 6>& block) {
    float largest = 0.0F;
    for (float s : block) largest = std::max(largest, std::abs(s));
    return largest;
}

using Floats = std::vector<std::array<float, 6>>;

/// One scale, a power of two, so that the largest number of all lies in (16384, 32768].
void pack_float16(const Floats& blocks, ServoModel& model) {
    float largest = 0.0F;
    for (const auto& block : blocks) largest = std::max(largest, largest_of(block));
    const float scale = largest > 0.0F ? std::exp2(std::ceil(std::log2(largest / kLargestHalf))) : 1.0F;
    model.packed_scale = {scale};
    for (const auto& block : blocks) {
        std::array<std::uint16_t, 6> packed{};
        for (std::size_t i = 0; i < 6; ++i) packed[i] = std::bit_cast<std::uint16_t>(Eigen::half(block[i] / scale).x);
        model.packed.push_back(packed);
    }
}

void pack_int16(const Floats& blocks, ServoModel& model) {
    for (const auto& block : blocks) {
        const float largest = largest_of(block), scale = largest / kLargestInt;
        std::array<std::uint16_t, 6> packed{};
        for (std::size_t i = 0; i < 6 && largest > 0.0F; ++i)
            packed[i] = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(block[i] / scale)));
        model.packed.push_back(packed);
        model.packed_scale.push_back(scale);
    }
}

/// What the force reads: S of the free vertices; or a compliance's blocks, in the order of haptable_model.packed.
Floats blocks_of(const ServoModel& model) {
    return model.compliance.degree == 0 ? model.stiffness_n_per_m : compliance_blocks(model);
}

using Eigen::Vector3d;
using Blocks = std::vector<Eigen::Matrix3d>;  // S of each vertex, or a compliance's

Eigen::Matrix3d symmetric_part(const std::array<double, 9>& rows) {
    const Eigen::Map<const Eigen::Matrix3d> block(rows.data());
    return 0.5 * (block + block.transpose());
}

/// As the servo reads them: of blocks_of().
Blocks stored_blocks(const Tables& tables, const ServoModel& model) {
    const haptable_model in_memory = model_in_memory(tables, model);
    const Floats floats = blocks_of(model);
    Blocks blocks;
    for (std::size_t b = 0; b < floats.size(); ++b) {
        std::array<float, 6> room = floats[b];
        if (in_memory.unpack != nullptr) in_memory.unpack(&in_memory, static_cast<std::uint32_t>(b), room.data());
        blocks.push_back(symmetric(room));
    }
    return blocks;
}

// ---- S of the vertices ----------------------------------------------------------------------------------------------

/// The coupling's spring in series with every block, as couple() has put it.
Blocks exact_stiffness(const Tables& tables, const ServoModel& model) {
    Blocks blocks;
    for (const auto& s : tables.stiffness) blocks.push_back(symmetric_part(s));
    blocks.resize(model.node.size(), tables.rigid_stiffness_n_per_m * Eigen::Matrix3d::Identity());
    if (model.stiffness.coupling_n_per_m <= 0.0) return blocks;
    const Eigen::Matrix3d spring = Eigen::Matrix3d::Identity() / model.stiffness.coupling_n_per_m;
    for (Eigen::Matrix3d& s : blocks) s = (s.inverse() + spring).inverse().eval();
    return blocks;
}

Eigen::Matrix3d mean(const Blocks& blocks, const std::array<std::uint16_t, 3>& patch,
                     const std::array<double, 3>& alpha) {
    return alpha[0] * blocks[patch[0]] + alpha[1] * blocks[patch[1]] + alpha[2] * blocks[patch[2]];
}

/// (S - S_d) S_d^-1 at every point of every patch.
Blocks stiffness_errors(const Blocks& exact, Blocks stored, const ServoModel& model) {
    stored.resize(model.node.size(), static_cast<double>(model.rigid_stiffness_n_per_m) * Eigen::Matrix3d::Identity());
    Blocks errors;
    for (const auto& patch : model.patch)
        for (const auto& alpha : kPoint) {
            const Eigen::Matrix3d s = mean(exact, patch, alpha);
            errors.push_back((mean(stored, patch, alpha) - s) * s.inverse());
        }
    return errors;
}

// ---- C of the patches -----------------------------------------------------------------------------------------------

Blocks exact_blocks(const Tables& tables, const ServoModel& model) {
    const ExactCompliance exact = exact_compliance(tables, model);
    const double k = model.stiffness.coupling_n_per_m;
    Blocks blocks;
    for (const auto* list : {&exact.vertex, &exact.edge, &exact.patch})
        for (const auto& block : *list)
            blocks.push_back(symmetric_part(block) + (k > 0.0 ? 1.0 / k : 0.0) * Eigen::Matrix3d::Identity());
    return blocks;
}

/// The same with S = C^-1: C^-1 (C_d - C).
Blocks compliance_errors(const Blocks& exact, const Blocks& stored, const ServoModel& model) {
    std::vector<BernsteinPoint> points;
    for (const auto& alpha : kPoint) points.emplace_back(model.compliance.degree, alpha);
    Blocks errors;
    for (std::size_t p = 0; p < model.patch.size(); ++p) {
        Blocks of_exact, of_stored;
        for (std::size_t b : control_blocks(model, p)) {
            of_exact.push_back(exact[b]);
            of_stored.push_back(stored[b]);
        }
        for (const BernsteinPoint& point : points) {
            const Eigen::Matrix3d c = compliance_at(model, p, of_stored, point);
            errors.push_back(c.inverse() * (compliance_at(model, p, of_exact, point) - c));
        }
    }
    return errors;
}

// ---- the servo's own force ------------------------------------------------------------------------------------------

// Points of a patch where a finger presses: no rounding of theirs is zero.
constexpr std::array<double, 3> kPressed[3] = {{0.41, 0.32, 0.27}, {0.17, 0.22, 0.61}, {0.73, 0.18, 0.09}};

/// S in double at points of patches.
class ExactForce {
public:
    ExactForce(const Tables& tables, const ServoModel& model)
        : model_(model),
          blocks_(model.compliance.degree == 0 ? exact_stiffness(tables, model) : exact_blocks(tables, model)) {}
    Eigen::Matrix3d at(std::size_t patch, const std::array<double, 3>& alpha) const {
        if (model_.compliance.degree == 0) return mean(blocks_, model_.patch[patch], alpha);
        Blocks control;
        for (std::size_t b : control_blocks(model_, patch)) control.push_back(blocks_[b]);
        return compliance_at(model_, patch, control, BernsteinPoint(model_.compliance.degree, alpha)).inverse();
    }

private:
    const ServoModel& model_;
    Blocks blocks_;
};

void put(const Vector3d& x, float out[3]) {
    for (int c = 0; c < 3; ++c) out[c] = static_cast<float>(x[c]);
}

Vector3d in_double(const float x[3]) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

/// F of the firmware for a contact and a finger.
Vector3d servo_force(const haptable_model& model, const haptable_contact& contact, const Vector3d& finger_m) {
    float finger[3], nodal_n[3][3], force_n[3];
    put(finger_m, finger);
    model.force(&model, &contact, finger, nodal_n, force_n);
    return in_double(force_n);
}

/// The god-object at these area coordinates, as the servo has it.
haptable_contact contact_at(const haptable_model& model, std::size_t patch, const std::array<double, 3>& alpha) {
    haptable_contact contact{};
    contact.patch = static_cast<std::uint16_t>(patch);
    put({alpha[0], alpha[1], alpha[2]}, contact.alpha);
    for (int c = 0; c < 3; ++c) {
        const float* vertex_m = model.vertex_m[model.patch[patch][c]];
        for (int k = 0; k < 3; ++k) contact.god_object_m[k] += contact.alpha[c] * vertex_m[k];
    }
    return contact;
}

/// The normal of a triangle, and two directions across it.
Eigen::Matrix3d frame_of(const std::array<Vector3d, 3>& corner) {
    const Vector3d along = (corner[1] - corner[0]).normalized();
    const Vector3d normal = along.cross(corner[2] - corner[0]).normalized();
    Eigen::Matrix3d frame;
    frame << normal, along, normal.cross(along);
    return frame;
}

/// 2-norm, by the largest eigenvalue of A^T A in closed form; infinite where A is not finite.
double norm_of(const Eigen::Matrix3d& a) {
    if (!a.allFinite()) return HUGE_VAL;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
    eigen.computeDirect(a.transpose() * a, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(0.0, eigen.eigenvalues()[2]));
}

}  // namespace

void pack_blocks(Storage precision, ServoModel& model) {
    model.packed.clear();
    model.packed_scale.clear();
    const Floats blocks = blocks_of(model);
    if (blocks.empty()) return;
    if (precision == Storage::kFloat16) pack_float16(blocks, model);
    if (precision == Storage::kInt16) pack_int16(blocks, model);
}

std::vector<PrecisionError> compare_precisions(const Tables& tables, const ServoModel& model) {
    const bool is_stiffness = model.compliance.degree == 0;
    const Blocks exact = is_stiffness ? exact_stiffness(tables, model) : exact_blocks(tables, model);
    std::vector<PrecisionError> all;
    for (const Storage precision : {Storage::kFloat32, Storage::kFloat16, Storage::kInt16}) {
        Tables as = tables;
        ServoModel stored = model;
        as.precision = precision;
        pack_blocks(precision, stored);
        const Blocks blocks = stored_blocks(as, stored);
        PrecisionError error;
        error.precision = precision;
        error.bytes = stored.packed.empty() ? 24 * blocks.size() : 12 * blocks.size() + 4 * stored.packed_scale.size();
        const Blocks errors =
            is_stiffness ? stiffness_errors(exact, blocks, model) : compliance_errors(exact, blocks, model);
        for (const Eigen::Matrix3d& off : errors) {
            const double norm = norm_of(off);
            error.worst = std::max(error.worst, norm);
            error.mean += norm / static_cast<double>(errors.size());
        }
        all.push_back(error);
    }
    return all;
}

double small_dent_m(const Tables& tables) {
    double volume = 0.0, area = 0.0;
    const Vector3d origin(tables.position.front().data());
    for (const auto& corner : tables.surface) {
        std::array<Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c)
            x[c] = Vector3d(tables.position[static_cast<std::size_t>(corner[c])].data()) - origin;
        volume += x[0].dot(x[1].cross(x[2])) / 6.0;
        area += (x[1] - x[0]).cross(x[2] - x[0]).norm() / 2.0;
    }
    return 0.2 * std::abs(volume) / area;
}

ServoError measure_servo(const Tables& tables, const ServoModel& model) {
    Tables plain = tables;  // the force itself, not what a god-object has made of it
    plain.god_object = GodObject::kNearest;
    plain.static_friction = 0.0;
    plain.precision = Storage::kFloat32;
    ServoModel in_float = model;
    pack_blocks(plain.precision, in_float);
    const haptable_model servo = model_in_memory(plain, in_float);
    const ExactForce exact(tables, model);
    ServoError error;
    error.depth_m = small_dent_m(tables);
    const auto take = [](const Vector3d& force, const Vector3d& meant, double& worst) {
        const double off = (force - meant).norm() / meant.norm();
        worst = std::max(worst, std::isfinite(off) ? off : HUGE_VAL);
    };
    for (std::size_t p = 0; p < model.patch.size(); ++p) {
        std::array<Vector3d, 3> corner;
        for (std::size_t c = 0; c < 3; ++c)
            corner[c] = Vector3d(tables.position[static_cast<std::size_t>(model.node[model.patch[p][c]])].data());
        const Eigen::Matrix3d frame = frame_of(corner);
        for (const auto& alpha : kPressed) {
            const haptable_contact contact = contact_at(servo, p, alpha);
            const Vector3d at = in_double(contact.alpha), g = at[0] * corner[0] + at[1] * corner[1] + at[2] * corner[2];
            const Eigen::Matrix3d s = exact.at(p, {at[0], at[1], at[2]});
            if (!s.allFinite() || !frame.allFinite()) continue;
            for (int d = 0; d < 3; ++d) {
                const Vector3d u = error.depth_m * frame.col(d);
                take(servo_force(servo, contact, g + u), -s * u, error.worst);
                haptable_contact at_origin = contact;
                put(Vector3d::Zero(), at_origin.god_object_m);
                float exact_u[3];
                put(u, exact_u);
                take(servo_force(servo, at_origin, u), -s * in_double(exact_u), error.force_alone);
            }
        }
    }
    return error;
}

bool has_definite_blocks(const Tables& tables, const ServoModel& model) {
    if (model.compliance.degree != 0) return true;  // only sums of them are to be
    const Blocks blocks = stored_blocks(tables, model);
    return std::all_of(blocks.begin(), blocks.end(), [](const Eigen::Matrix3d& s) {
        return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(s, Eigen::EigenvaluesOnly).eigenvalues()[0] > 0.0;
    });
}

void require_precision(const std::vector<PrecisionError>& all, Storage chosen) {
    if (all.empty() || !(all.front().worst < 1.0)) return;  // C is singular at a point: float32 cannot hold it either
    for (const PrecisionError& error : all)
        if (error.precision == chosen && !(error.worst < 1.0))
            throw Error(
                fmt::format("tables.precision = \"{}\" cannot hold blocks that are as different as this body's: the "
                            "worst force would be off by {:.2g} of itself; choose another",
                            word(chosen), error.worst));
}

}  // namespace haptable
