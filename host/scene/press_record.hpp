// SPDX-License-Identifier: GPL-2.0-or-later
// A measured press of a body, and the curve that its dent stiffens by.
#pragma once

#include <filesystem>
#include <vector>

#include "host/base/stiffening.hpp"

namespace haptable {

/// How deep, how hard, when.
struct ForceRecord {
    std::vector<double> time_s;            ///< [samples], ascending; empty: a slow press without times
    std::vector<double> depth_m, force_n;  ///< [samples]
};

/// A file with the header time_s,depth_m,force_n or depth_m,force_n and a sample a line, the force that of the body
/// against the press; lines that begin with # are not read. What comes after the body has let go (no force, after the
/// largest) is left out: there the depth is not its surface's. Throws Error "FILE:LINE: what is wrong".
ForceRecord read_force_record(const std::filesystem::path& file);

/// A press that was slow, or of a body that does not relax, and stiffens: F = k d Psi', s = d / the deepest.
struct DentFit {
    double stiffness_n_per_m = 0.0;
    double depth_m = 0.0;    ///< of the deepest sample
    StiffeningCurve curve;   ///< energy: k depth^2 / 2
    double misfit_n = 0.0;   ///< root of the mean squared difference
    double largest_n = 0.0;  ///< force of the record
};

/// Least squares over k and the curve: a number for each two samples, and fewer where the tangent would not stay
/// positive. Throws Error where the record has too few depths.
DentFit fit_dent(const ForceRecord& record);

}  // namespace haptable
