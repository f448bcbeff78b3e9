// SPDX-License-Identifier: GPL-2.0-or-later
// Tables of the paper's cube for tests of what reads them.
#pragma once

#include <filesystem>

#include "host/precompute/precompute.hpp"
#include "host/tables/tables.hpp"
#include "tests/bodies.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

struct CubeOptions {
    int nodes_per_side = 5;
    ColumnRows columns = ColumnRows::kSurface;
    double touch_above_m = -1.0;  ///< patches with a node lower than this must not be touched
};

inline Scene cube_with(const CubeOptions& options) {
    Scene scene = cube_scene(options.nodes_per_side, 0.4);
    scene.name = "cube";
    scene.tables.columns = options.columns;
    scene.touch.push_back({std::array<double, 6>{-1, -1, options.touch_above_m, 1, 1, 1}, "", 1});
    return scene;
}

/// Without their C; of columns one rounding is in the file.
inline void write_cube_tables(const std::filesystem::path& folder, const CubeOptions& options = {}) {
    Progress quiet(true);
    precompute(cube_with(options), folder, quiet, {.column_tolerance = 0.0, .code = false});
}

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
