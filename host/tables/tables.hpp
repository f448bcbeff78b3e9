// SPDX-License-Identifier: GPL-2.0-or-later
// The folder that haptable-precompute writes and that codegen, viewer and bench read. SPEC.md describes every file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/limits.hpp"
#include "host/base/modes.hpp"
#include "host/base/relaxation.hpp"
#include "host/base/scene_options.hpp"
#include "host/base/stiffening.hpp"
#include "host/tables/folder.hpp"

namespace haptable {

/// C(alpha) of the contact point or mask on every patch (force = "consistent" or "pressure-mask"), in Bernstein's form.
/// e edges of touchable patches; for a mask also t vertices, fixed ones too.
struct ComplianceTables {
    int degree = 0;                                    ///< 2 consistent, 4 pressure-mask, 0 none
    std::vector<std::array<std::int32_t, 2>> edge_id;  ///< [e] mesh nodes, lower first (edge_id.npy)
    std::vector<std::array<double, 9>> edge;    ///< [e (degree - 1)] m/N, from the lower node (edge_compliance.npy)
    std::vector<std::int32_t> vertex_id;        ///< [t] mesh nodes (vertex_id.npy); empty for consistent
    std::vector<std::array<double, 9>> vertex;  ///< [t] m/N (vertex_compliance.npy); empty for consistent
    std::vector<std::array<double, 9>> patch;   ///< [3 p] m/N (patch_compliance.npy); empty for consistent
    /// How a load on a control point spreads over mesh nodes: of vertices, then of edges (spread_*.npy).
    std::vector<std::int32_t> spread_begin;  ///< [t + e + 1]
    std::vector<std::int32_t> spread_node;   ///< mesh nodes
    std::vector<float> spread_weight;
};

/// What the tables of one scene hold besides columns.npy, which may be large and is mapped (MappedNpy<float>).
/// N mesh nodes, n touchable free surface nodes, p touchable patches, q surface patches, r drawn rows.
struct Tables {
    // options.json, tables.json
    SceneOptions options;           ///< every key of the scene: where one that only the servo needs is read
    std::string name;               ///< of the scene; names the C model
    std::uint64_t model_hash = 0;   ///< of what they were made from: scene, mesh, options, tool version
    std::uint64_t tables_hash = 0;  ///< of all parts of the servo's tables, which messages carry; 0: not yet known
    std::string scene_file;         ///< file name only, no folder
    ForceLaw force = ForceLaw::kInterpolated;
    GodObject god_object = GodObject::kNearest;
    Storage precision = Storage::kFloat32;   ///< of S in the servo
    std::uintmax_t flash_budget = 0;         ///< bytes; 0: none
    double rigid_stiffness_n_per_m = 0.0;    ///< S of a fixed node, N/m
    double mask_radius_m = 0.0;              ///< of a pressure mask; 0 for the other forces
    int fingers = 1;                         ///< or 2
    std::vector<RelaxationTerm> relaxation;  ///< none: an elastic body
    StiffeningCurve stiffening;              ///< of dents; energy 0: they do not stiffen
    double static_friction = 0.0;            ///< 0: without friction
    double kinetic_friction = 0.0;
    bool auto_coupling = false;
    double coupling_n_per_m = 0.0;   ///< in series; 0: none
    double max_force_n = 0.0;        ///< where the servo cuts: the device's by the force scale
    SafetyLimits limits;             ///< by the scales as well
    double damping_n_s_per_m = 0.0;  ///< of the device
    double device_friction_n = 0.0;
    double encoder_step_m = 0.0;
    double device_delay_s = 0.0;                    ///< of a force on its way to the motors, their lag with it
    double motion_scale = 1.0;                      ///< of the body's motion over the hand's
    double force_scale = 1.0;                       ///< of the hand's force over the body's
    std::vector<std::int32_t> display_rows;         ///< mesh nodes whose displacement the target computes
    Storage display_precision = Storage::kFloat32;  ///< float32 | int16
    bool has_columns = false;                       ///< columns.npy
    bool has_factor = false;                        ///< instead of it: for a solve each frame
    bool half_columns = false;                      ///< columns.npy is float16, in units of:
    double column_unit_m_per_n = 1.0;

    // *.npy
    std::vector<std::array<double, 3>> position;       ///< [N] rest positions of the mesh nodes, m (position.npy)
    std::vector<std::array<std::int32_t, 3>> surface;  ///< [q] mesh nodes of all surface patches (surface.npy)
    std::vector<std::int32_t> node_id;                 ///< [n] (node_id.npy)
    std::vector<std::array<std::int32_t, 3>> patch;    ///< [p] mesh nodes (patch.npy)
    std::vector<std::array<double, 9>> stiffness;      ///< [n] (L_ii)^-1, N/m, row by row (stiffness.npy)
    ComplianceTables compliance;
    std::vector<std::int32_t> row_id;  ///< [r] mesh nodes of the rows (row_id.npy); empty without columns and factor
};

/// Reads and checks the folder. Throws Error that names the file: missing, damaged, or not fitting the others.
Tables read_tables(const TablesFolder& folder);

/// True where the symmetric part of a 3x3 block, row by row, is positive definite.
bool is_definite(const std::array<double, 9>& block);

}  // namespace haptable
