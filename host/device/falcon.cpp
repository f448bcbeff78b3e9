// SPDX-License-Identifier: GPL-2.0-or-later
// A leg in its own plane: with u, v, w the grip seen from the leg's base, the lower arm of length
// rho = d + e + sqrt(b^2 - (v + f)^2) joins (u + c, w) with the knee a (cos theta, sin theta):
//
//   g = (u + c - a cos theta)^2 + (w - a sin theta)^2 - rho^2 = 0
#include "host/device/falcon.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// libnifalcon's measurements, m, in Stamper's letters.
constexpr double kA = 0.060, kB = 0.1025, kC = 0.014, kDE = 2 * 0.01125, kF = -0.025;
constexpr double kR = 0.037233758, kS = -0.027330909;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<double, 3> kPhi{105.0 * kDegree, -15.0 * kDegree, -135.0 * kDegree};

constexpr std::uint8_t kFirst = '<', kLast = '>', kZero = 'A';
constexpr std::size_t kFrame = 16;

/// The grip from a leg's base: u outwards, v along the knee's axis, w to the user.
Matrix3d turn_of(std::size_t leg) { return Eigen::AngleAxisd(-kPhi[leg], Vector3d::UnitZ()).toRotationMatrix(); }
Vector3d seen_by(std::size_t leg, const Vector3d& grip_m) { return turn_of(leg) * grip_m + Vector3d(-kR, -kS, 0.0); }

struct Leg {
    double g = 0.0;       ///< m^2
    Vector3d by_grip;     ///< dg/d(grip)
    double by_angle = 0;  ///< dg/d(theta)
};

std::optional<Leg> leg_at(std::size_t leg, double angle, const Vector3d& grip_m) {
    const Vector3d p = seen_by(leg, grip_m);
    const double off = p.y() + kF, square = kB * kB - off * off;
    if (!(square > 0.0)) return std::nullopt;
    const double root = std::sqrt(square), rho = kDE + root;
    const double u = p.x() + kC - kA * std::cos(angle), w = p.z() - kA * std::sin(angle);
    Leg found;
    found.g = u * u + w * w - rho * rho;
    found.by_grip = turn_of(leg).transpose() * Vector3d(2.0 * u, 2.0 * rho * off / root, 2.0 * w);
    found.by_angle = 2.0 * kA * (u * std::sin(angle) - w * std::cos(angle));
    return found;
}

/// All three, a row each.
struct Legs {
    Vector3d g;
    Matrix3d by_grip;
    Vector3d by_angle;
};

std::optional<Legs> legs_at(const Vector3d& angle, const Vector3d& grip_m) {
    Legs found;
    for (std::size_t leg = 0; leg < 3; ++leg) {
        const auto row = static_cast<Eigen::Index>(leg);
        const std::optional<Leg> at = leg_at(leg, angle[row], grip_m);
        if (!at) return std::nullopt;
        found.g[row] = at->g;
        found.by_grip.row(row) = at->by_grip.transpose();
        found.by_angle[row] = at->by_angle;
    }
    return found;
}

std::int16_t nibbles(std::span<const std::uint8_t> four) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= ((four[i] - unsigned{kZero}) & 0xFU) << (4 * i);
    return static_cast<std::int16_t>(value);
}

/// Nibbles are letters from A to P; the flags have the high nibble too.
bool is_frame(std::span<const std::uint8_t> bytes) {
    return bytes[0] == kFirst && bytes[kFrame - 1] == kLast &&
           std::all_of(bytes.begin() + 1, bytes.begin() + 13,
                       [](std::uint8_t b) { return b >= kZero && b < kZero + 16; });
}

}  // namespace

std::optional<FalconState> FalconReader::add(std::span<const std::uint8_t> bytes, std::int64_t& odd) {
    held_.insert(held_.end(), bytes.begin(), bytes.end());
    std::optional<FalconState> newest;
    std::size_t at = 0;
    while (held_.size() - at >= kFrame) {
        const std::span<const std::uint8_t> frame(held_.data() + at, kFrame);
        if (!is_frame(frame)) {
            ++odd;
            ++at;
            continue;
        }
        newest.emplace();
        for (std::size_t leg = 0; leg < 3; ++leg) newest->encoder[leg] = nibbles(frame.subspan(1 + 4 * leg, 4));
        const unsigned flags = frame[13] - unsigned{kZero};
        newest->buttons = static_cast<std::uint8_t>(flags & 0xFU);
        newest->homed = static_cast<std::uint8_t>(flags >> 4 & 0x7U);
        at += kFrame;
    }
    held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(at));
    return newest;
}

std::array<std::uint8_t, 16> falcon_frame(const std::array<std::int16_t, 3>& motor, bool homing) {
    std::array<std::uint8_t, kFrame> frame;
    frame.fill(kZero);
    frame.front() = kFirst;
    frame.back() = kLast;
    for (std::size_t leg = 0; leg < 3; ++leg)
        for (std::size_t i = 0; i < 4; ++i)
            frame[1 + 4 * leg + i] =
                static_cast<std::uint8_t>(kZero + (static_cast<std::uint16_t>(motor[leg]) >> (4 * i) & 0xF));
    constexpr std::uint8_t kGreen = 2, kRed = 8, kHoming = 1;
    frame[13] = static_cast<std::uint8_t>(kZero + (homing ? kRed + kHoming : kGreen));
    return frame;
}

double falcon_angle(std::int16_t encoder) { return (35.0 + 360.0 / 1280.0 * 14.25 / 110.0 * encoder) * kDegree; }

std::optional<Vector3d> falcon_grip_m(const Vector3d& angle, const Vector3d& near_m) {
    Vector3d grip_m = near_m;
    for (int step = 0; step < 20; ++step) {
        const std::optional<Legs> legs = legs_at(angle, grip_m);
        if (!legs) return std::nullopt;
        const Vector3d more_m = -legs->by_grip.inverse() * legs->g;
        if (!more_m.allFinite()) return std::nullopt;
        grip_m += more_m;
        if (more_m.norm() < 1e-12) return grip_m;
    }
    return std::nullopt;
}

std::optional<Vector3d> falcon_angles(const Vector3d& grip_m) {
    Vector3d angle;
    for (std::size_t leg = 0; leg < 3; ++leg) {
        const Vector3d p = seen_by(leg, grip_m);
        const double off = p.y() + kF, square = kB * kB - off * off;
        if (!(square > 0.0)) return std::nullopt;
        const double rho = kDE + std::sqrt(square), u = p.x() + kC, far = std::hypot(u, p.z());
        const double cosine = (far * far + kA * kA - rho * rho) / (2.0 * kA * far);
        if (!(std::abs(cosine) <= 1.0)) return std::nullopt;
        angle[static_cast<Eigen::Index>(leg)] = std::atan2(p.z(), u) - std::acos(cosine);
    }
    return angle;
}

std::optional<Matrix3d> falcon_jacobian(const Vector3d& angle, const Vector3d& grip_m) {
    const std::optional<Legs> legs = legs_at(angle, grip_m);
    if (!legs) return std::nullopt;
    const Matrix3d jacobian = -legs->by_grip.inverse() * legs->by_angle.asDiagonal();
    if (!jacobian.allFinite()) return std::nullopt;
    return jacobian;
}

}  // namespace haptable
