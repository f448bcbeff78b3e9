// SPDX-License-Identifier: GPL-2.0-or-later
// The Novint Falcon's frames and its delta mechanism (Stamper 1997, after libnifalcon's measurements).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptable {

/// What the Falcon says: 16 bytes, '<', three encoders of four nibbles from the lowest on, the grip and the homed
/// flags, one byte more, '>'. A nibble n is the letter 'A' + n.
struct FalconState {
    std::array<std::int16_t, 3> encoder{};
    std::uint8_t buttons = 0;  ///< of the grip, four bits
    std::uint8_t homed = 0;    ///< one bit a leg
};

/// Finds the frames in a stream of bytes, whatever stands between them.
class FalconReader {
public:
    /// Appends bytes; returns the newest whole frame of them, if any. `odd` counts bytes that belong to none.
    std::optional<FalconState> add(std::span<const std::uint8_t> bytes, std::int64_t& odd);

private:
    std::vector<std::uint8_t> held_;
};

/// What is said to it: the motors' values of 16 bits, in the same form; lights, and whether it shall home.
std::array<std::uint8_t, 16> falcon_frame(const std::array<std::int16_t, 3>& motor, bool homing);

/// Radians of a leg for its encoder: 1,280 counts a turn of the motor, of 14.25 mm, on the leg's drum of 110 mm; 35
/// degrees where it counts 0.
double falcon_angle(std::int16_t encoder);

/// The grip for the three legs' angles, by Newton from `near_m`. x to the right, y up, z to the user, from the base's
/// middle, m. None where it does not converge.
std::optional<Eigen::Vector3d> falcon_grip_m(const Eigen::Vector3d& angle, const Eigen::Vector3d& near_m);
/// The legs' angles for a grip; none where a leg does not reach it.
std::optional<Eigen::Vector3d> falcon_angles(const Eigen::Vector3d& grip_m);
/// d(grip)/d(angle), m/rad: torques are its transpose times the force.
std::optional<Eigen::Matrix3d> falcon_jacobian(const Eigen::Vector3d& angle, const Eigen::Vector3d& grip_m);

}  // namespace haptable
