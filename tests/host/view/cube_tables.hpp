// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of a cube for the viewer's tests, without finite elements: a smooth made-up compliance.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "host/tables/tables.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

struct CubeOptions {
    int nodes_per_side = 5;
    double side_m = 0.03;
    std::string columns = "surface";
    double touch_above_m = -1.0;  ///< patches with a node lower than this must not be touched
};

/// Displacement of `to` per force on `from`, m/N: Kelvin's solution of an infinite body, rounded off at the source,
/// times a factor that vanishes at z = 0, which is held still. L(a, b) = L(b, a)^T.
Eigen::Matrix3d cube_compliance(const Eigen::Vector3d& to, const Eigen::Vector3d& from);

/// Writes the files that the viewer reads: the surface nodes of the cube [0, side]^3, bottom fixed.
void write_cube_tables(const std::filesystem::path& folder, const CubeOptions& options = {});

/// A test with these tables in a folder.
class WithCube : public ::testing::Test {
protected:
    WithCube() { remake({}); }
    void remake(const CubeOptions& options) {
        write_cube_tables(folder_.path(), options);
        tables_ = read_tables(folder_.path());
    }

    TemporaryFolder folder_;
    Tables tables_;
};

}  // namespace haptable::test
