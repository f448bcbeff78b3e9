// SPDX-License-Identifier: GPL-2.0-or-later
// |F - F_d| / |F_d| <= || (S - S_d) S_d^-1 ||,   S = sum alpha_i S_i
#include "codegen/precision.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>

#include "codegen/in_memory.hpp"

namespace haptable {

namespace {

constexpr float kLargestHalf = 32768.0F;  // a power of two below 65504
constexpr float kLargestInt = 32767.0F;
// Points of a patch by their area coordinates.
constexpr double kPoint[7][3] = {
    {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0}, {0.5, 0, 0.5}, {0, 0.5, 0.5}, {1 / 3., 1 / 3., 1 / 3.}};

float largest_of(const std::array<float, 6>& block) {
    float largest = 0.0F;
    for (float s : block) largest = std::max(largest, std::abs(s));
    return largest;
}

/// One scale, a power of two, so that the largest number of all lies in (16384, 32768].
void pack_float16(ServoModel& model) {
    float largest = 0.0F;
    for (const auto& block : model.stiffness_n_per_m) largest = std::max(largest, largest_of(block));
    const float scale = std::exp2(std::ceil(std::log2(largest / kLargestHalf)));
    model.packed_scale_n_per_m = {scale};
    for (const auto& block : model.stiffness_n_per_m) {
        std::array<std::uint16_t, 6> packed{};
        for (std::size_t i = 0; i < 6; ++i) packed[i] = std::bit_cast<std::uint16_t>(Eigen::half(block[i] / scale).x);
        model.packed.push_back(packed);
    }
}

void pack_int16(ServoModel& model) {
    for (const auto& block : model.stiffness_n_per_m) {
        const float scale = largest_of(block) / kLargestInt;
        std::array<std::uint16_t, 6> packed{};
        for (std::size_t i = 0; i < 6; ++i)
            packed[i] = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(block[i] / scale)));
        model.packed.push_back(packed);
        model.packed_scale_n_per_m.push_back(scale);
    }
}

using Blocks = std::vector<Eigen::Matrix3d>;  // [v] S of each vertex

Eigen::Matrix3d symmetric(const float s[6]) {
    Eigen::Matrix3d block;
    block << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
    return block;
}

Blocks exact_blocks(const Tables& tables, const ServoModel& model) {
    Blocks blocks(model.node.size(), tables.rigid_stiffness_n_per_m * Eigen::Matrix3d::Identity());
    for (std::size_t v = 0; v < model.free_count; ++v) {
        const Eigen::Map<const Eigen::Matrix3d> s(tables.stiffness[v].data());
        blocks[v] = 0.5 * (s + s.transpose());
    }
    return blocks;
}

/// As the servo reads them.
Blocks stored_blocks(const Tables& tables, const ServoModel& model) {
    const haptable_model in_memory = model_in_memory(tables, model);
    Blocks blocks(model.node.size(), static_cast<float>(tables.rigid_stiffness_n_per_m) * Eigen::Matrix3d::Identity());
    for (std::size_t v = 0; v < model.free_count; ++v) {
        std::array<float, 6> room{};
        if (in_memory.unpack != nullptr) in_memory.unpack(&in_memory, static_cast<std::uint16_t>(v), room.data());
        blocks[v] = symmetric(in_memory.unpack != nullptr ? room.data() : model.stiffness_n_per_m[v].data());
    }
    return blocks;
}

/// The coupling's spring in series with every block, as couple() has put it.
Blocks coupled(Blocks blocks, const ServoModel& model) {
    if (model.stiffness.coupling_n_per_m <= 0.0) return blocks;
    const Eigen::Matrix3d spring = Eigen::Matrix3d::Identity() / model.stiffness.coupling_n_per_m;
    for (Eigen::Matrix3d& s : blocks) s = (s.inverse() + spring).inverse().eval();
    return blocks;
}

Eigen::Matrix3d at(const Blocks& blocks, const std::array<std::uint16_t, 3>& patch, const double (&alpha)[3]) {
    return alpha[0] * blocks[patch[0]] + alpha[1] * blocks[patch[1]] + alpha[2] * blocks[patch[2]];
}

}  // namespace

void pack_blocks(Storage precision, ServoModel& model) {
    model.packed.clear();
    model.packed_scale_n_per_m.clear();
    if (model.stiffness_n_per_m.empty()) return;
    if (precision == Storage::kFloat16) pack_float16(model);
    if (precision == Storage::kInt16) pack_int16(model);
}

std::vector<PrecisionError> compare_precisions(const Tables& tables, const ServoModel& model) {
    const Blocks exact = coupled(exact_blocks(tables, model), model);
    std::vector<PrecisionError> all;
    for (const Storage precision : {Storage::kFloat32, Storage::kFloat16, Storage::kInt16}) {
        Tables as = tables;
        ServoModel stored = model;
        as.precision = precision;
        pack_blocks(precision, stored);
        const Blocks blocks = stored_blocks(as, stored);
        PrecisionError error;
        error.precision = precision;
        error.bytes = stored.packed.empty() ? 24 * model.free_count
                                            : 12 * model.free_count + 4 * stored.packed_scale_n_per_m.size();
        for (const auto& patch : model.patch)
            for (const auto& alpha : kPoint) {
                const Eigen::Matrix3d s = at(exact, patch, alpha);
                const Eigen::Matrix3d off = (at(blocks, patch, alpha) - s) * s.inverse();
                const double norm = off.jacobiSvd().singularValues()[0];
                error.worst = std::max(error.worst, norm);
                error.mean += norm / static_cast<double>(7 * model.patch.size());
            }
        all.push_back(error);
    }
    return all;
}

}  // namespace haptable
