// SPDX-License-Identifier: GPL-2.0-or-later
// The tables' files, and the folder that they come into: all of them or none. docs/SPEC.md describes them.
#pragma once

#include "host/base/own_folder.hpp"
#include "host/compliance/point_compliance.hpp"
#include "host/precompute/plan.hpp"

namespace haptable {

/// What every scene has. stiffness_n_per_m: [n] S_i; sag_m: [N], or empty without [gravity]. The surface that is
/// touched and drawn is the one that has sagged.
void write_tables(const Scene& scene, const Body& body, Drawing drawing,
                  const std::vector<Eigen::Matrix3d>& stiffness_n_per_m, std::span<const Eigen::Vector3d> sag_m,
                  const std::filesystem::path& folder);

/// sag.npy of an earlier run, [N] m.
std::vector<Eigen::Vector3d> read_sag(const std::filesystem::path& folder);

/// L_ij of every touchable edge; 0 where an end is fixed. l_ij: of coupled_edges()
void write_edges(const Scene& scene, const Body& body, std::span<const Eigen::Matrix3d> l_ij,
                 const std::filesystem::path& folder);

/// The pressure mask's.
void write_mask(const Masks& masks, const MaskCompliance& c, const std::filesystem::path& folder);

/// All but summary.json and tables.json, by name.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);

/// An absolute path without a slash at its end has a parent and a name, which "." and "out/" have not.
std::filesystem::path plain_folder(const std::filesystem::path& given);

/// Throws Error where the disk has not that much left for a file.
void require_room(const char* file, double needed_bytes, const std::filesystem::path& folder);

/// Renames every file from the folder beside into its place, tables.json last: who finds it finds all. What earlier
/// runs made and this scene does without goes; what haptable did not make stays, or is an Error where it is in the way.
void publish(const std::filesystem::path& beside, OwnFolder& folder);

/// What make looks at: the tables are as new as their inputs.
void touch_summary(const std::filesystem::path& folder);

}  // namespace haptable
