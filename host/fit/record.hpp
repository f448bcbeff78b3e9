// SPDX-License-Identifier: GPL-2.0-or-later
// A measured press: how deep, how hard, when.
#pragma once

#include <filesystem>
#include <vector>

namespace haptable {

struct ForceRecord {
    std::vector<double> time_s, depth_m, force_n;  ///< [samples]; time ascends
};

/// A file with the header time_s,depth_m,force_n and a sample a line, the force that of the body against the press.
/// What comes after the body has let go (no force, after the largest) is left out: there the depth is not its
/// surface's. Throws Error "FILE:LINE: what is wrong".
ForceRecord read_force_record(const std::filesystem::path& file);

}  // namespace haptable
