// SPDX-License-Identifier: GPL-2.0-or-later
// scene + mesh -> K -> factor -> blocks and columns of L -> tables -> C
#pragma once

#include <filesystem>

#include "host/base/progress.hpp"
#include "host/body/body.hpp"
#include "host/inverse/inverse.hpp"
#include "host/precompute/summary.hpp"

namespace haptable {

/// What a run worked on and what it found.
struct Result {
    Body body;
    Summary summary;
    bool unchanged = false;  ///< the folder already had these tables: nothing was computed, the summary has no checks
};

/// How a run computes; what it computes is the scene's.
struct PrecomputeOptions {
    /// Relative error that a block of stiffness.npy may have. 0: everything in double. Above it, the selected inversion
    /// runs in float, in half the time, where the condition of the L_ii keeps the error below.
    double tolerance = 0.0;
    /// Relative error (2-norm of a column) that the solves for columns.npy may have, before it is stored in float32 or
    /// float16. 0: in double. Above it, they run in float on the factor in double, in half the time, where a trial on
    /// the nodes of the checks stays below.
    double column_tolerance = 1e-5;
    bool code = true;           ///< as C too; without, the folder is for this host alone
    bool force = false;         ///< compute even where the folder holds the same tables already
    double memory_bytes = 0.0;  ///< most to use; 0: what the machine has free
    /// 0: all processors, one for less than 10,000 nodes. The tables are the same bytes for any number.
    int threads = 0;
    /// Null: a CholmodInverse. Of a distributed one all is in double, and where columns are over their budget there are
    /// none.
    Inverse* inverse = nullptr;
};

/// Where columns are worked on, beside the folder; it stays when a run is cut short, and the next one goes on from it.
std::filesystem::path work_folder(const std::filesystem::path& folder);

/// Reads the scene's mesh, computes its tables and writes them, with summary.json and the generated C, into `folder`,
/// which is made where it is missing: all files or none; files of other names in it stay. Throws Error, in particular
/// where parts of the body are under-constrained. docs/SPEC.md describes the files.
Result precompute(const Scene& scene, const std::filesystem::path& folder, Progress& progress,
                  const PrecomputeOptions& options = {});

}  // namespace haptable
