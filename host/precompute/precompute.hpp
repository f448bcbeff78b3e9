// SPDX-License-Identifier: GPL-2.0-or-later
// scene + mesh -> K -> factor -> blocks and columns of L -> tables -> C
#pragma once

#include <Eigen/SparseCore>
#include <filesystem>

#include "host/base/progress.hpp"
#include "host/precompute/body.hpp"
#include "host/precompute/summary.hpp"

namespace haptable {

/// K of the body's free nodes, N/m: three rows a node in the order of body.free_node, both triangles stored.
Eigen::SparseMatrix<double> assemble_free(const Scene& scene, const Body& body);

/// What a run worked on and what it found.
struct Result {
    Body body;
    Summary summary;
};

/// Reads the scene's mesh, computes its tables and writes them, with summary.json and the generated C, into `folder`,
/// which is made where it is missing: all files or none; files of other names in it stay. Throws Error, in particular
/// where parts of the body are loose. docs/SPEC.md describes the files.
Result precompute(const Scene& scene, const std::filesystem::path& folder, Progress& progress);

}  // namespace haptable
