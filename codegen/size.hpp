// SPDX-License-Identifier: GPL-2.0-or-later
// What a servo's model takes, what storing it otherwise would, and what it feels like: numbers, without the firmware.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/modes.hpp"

namespace haptable {

/// Bytes of flash of one table.
struct TableBytes {
    std::string name;
    std::size_t bytes;
};

/// How stiff the servo's object is to a finger.
struct ServoStiffness {
    double largest_n_per_m = 0.0;   ///< largest eigenvalue of any point's S, without a coupling
    double stable_n_per_m = 0.0;    ///< what the device renders stably
    double coupling_n_per_m = 0.0;  ///< spring in series; 0: none
    double felt_n_per_m = 0.0;      ///< the largest with it
};

/// How large the spatial index is, and what a search of it takes.
struct ServoIndex {
    std::size_t boxes = 0;
    std::size_t fast_way_boxes = 0;  ///< most that a segment of HAPTABLE_FAST_SEGMENT_M visits
    std::size_t tick_boxes = 0;      ///< most that a tick visits
};

/// What one way of storing the blocks costs and gives.
struct PrecisionError {
    Storage precision = Storage::kFloat32;
    std::size_t bytes = 0;  ///< of the blocks
    double worst = 0.0;  ///< largest |F - F_double| / |F_double| over patches, points of them and all directions of u
    double mean = 0.0;   ///< over patches and points, of the worst direction there
};

/// What the servo's float32 costs, from positions to force, with blocks in float32: largest |F - F_double| / |F_double|
/// over patches, points of them and three directions of u (along the normal and across it), as deep as a small dent.
struct ServoError {
    double depth_m = 0.0;  ///< of the dent

    double worst = 0.0;        ///< of the servo as it is
    double force_alone = 0.0;  ///< with u exact: blocks and arithmetic, not the positions that u is a difference of
};

/// Above this the servo's rounding is told, 1 % of what a hand can tell apart.
inline constexpr double kMostServoError = 1e-3;

/// Another way to make the tables of the same body.
struct Remedy {
    std::string text;    ///< what to write into the scene
    double error = 0.0;  ///< ServoError::worst with it, measured
};

/// What a model takes, and what other ways to store its blocks would.
struct ModelSize {
    std::uint64_t tables_hash = 0;          ///< haptable_model.hash, of all parts
    std::vector<TableBytes> flash;          ///< by table, in the order of model.c
    std::vector<PrecisionError> precision;  ///< of S; empty where the force reads none
    ServoError servo;                       ///< what float32 costs of the force
    std::vector<Remedy> remedies;  ///< where that is more than kMostServoError: what would leave less, best first
    ServoStiffness stiffness;      ///< what it feels like
    ServoIndex index;              ///< of the spatial index
};

/// "; WHAT leaves ERROR, ..."; empty without any.
std::string describe(const std::vector<Remedy>& remedies);

}  // namespace haptable
