// SPDX-License-Identifier: GPL-2.0-or-later
// Tetrahedra that are almost flat: counted, and refused where their volume is rounding.
#include <gtest/gtest.h>

#include "host/mesh/audit.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/mesh/write_tetgen.hpp"
#include "tests/cells.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

TetMesh written_and_read(double radius_ratio) {
    const TemporaryFolder folder;
    const TetMesh mesh = sliver_mesh(4, radius_ratio);
    return read_mesh(write_tetgen(mesh.position_m, mesh.tet, folder.path() / "slivers"), 1.0);
}

TEST(HardSliver, TheAuditCountsThem) {
    for (const double ratio : {1e-6, 1e-9}) {
        const Audit audit = audit_mesh(written_and_read(ratio));
        EXPECT_EQ(audit.slivers, 16U) << "a face between two cells";
        // A volume is a difference of products of edges: it loses the digits that the sliver is flat by.
        EXPECT_WITHIN(std::abs(audit.worst_ratio / ratio - 1.0), .count = 64, .condition = 1.0 / ratio);
    }
}

TEST(HardSliver, OneWhoseVolumeIsRoundingIsRefused) {
    EXPECT_EQ(written_and_read(1e-12).turned, 0U);
    const TetMesh nearly = sliver_mesh(4, 1e-15);
    EXPECT_GT(six_volumes(nearly.position_m, nearly.tet.back()), 0.0) << "some units of the last place, not none";
    for (const double ratio : {1e-15, 1e-16}) {
        const std::string said = error_of([&] { written_and_read(ratio); });
        EXPECT_NE(said.find("has no volume; remove it"), std::string::npos) << ratio << ": " << said;
    }
}

}  // namespace
}  // namespace haptable::test
