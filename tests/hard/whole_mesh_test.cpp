// SPDX-License-Identifier: GPL-2.0-or-later
// Meshes by other people against what their owners' tools count (the README beside them), by the audit that users see.
#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/precompute/precompute.hpp"
#include "host/tables/tables.hpp"
#include "tests/bodies.hpp"
#include "tests/conditioning.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

const fs::path kMeshes = "../shared/meshes";

struct Known {
    std::string file;
    std::size_t nodes, unused, tets, surface_nodes, patches;
    double box[3];
    double worst, median, least_deg, greatest_deg;
    std::size_t slivers, bodies, shells, inverted, hinge_edges;
    std::int64_t euler;
    double volume;
};

/// Row by row in the order of Known.
constexpr const char* kTable =
    R"(liver_181.msh 181 0 596 140 276 6.483 4.939 4.421 .017 .65 6.2 171.2 2 1 1 0 0 2 36.5609
elbow_1823.mesh 1823 0 8161 841 1678 .26 .1299 .06 .37 .84 19 149.2 0 1 1 0 0 2 .000877362
elbow2_inverted_1823.mesh 1823 0 8161 841 1678 .26 .1299 .06 .37 .84 19 149.2 0 1 1 8161 0 2 .000877362
octahedron_330.node 330 0 1224 234 464 8 8 8 .12 .78 5.6 170 0 1 1 0 0 2 85.3333
abaqus_tet_13.inp 13 0 14 13 22 1.414 1.414 1 .34 .63 18 148.5 0 1 1 0 0 2 .666667
armadillo_1180.node 1180 0 3717 1053 2102 2.538 3.029 2.315 .0045 .60 2.5 174.8 32 1 1 0 0 2 1.8596
microstructure_1585.msh 1585 0 6414 861 1762 1.002 1.002 1.001 5.8e-05 .27 .036 179.4 1080 1 1 8 0 -20 .0467215
mat40x40_3200.msh 3200 0 9126 3200 6396 1 .008 1 .31 .47 17 156.2 0 1 1 0 0 2 .008
two_parts_285.msh 285 0 812 259 510 .03 .021 .02 .18 .72 8.7 164.4 0 2 2 0 0 4 5.9997e-06
cubes2mat_7714.msh 7714 0 32981 3807 7610 2.1 1.001 1.001 .14 .81 11 157.5 0 1 1 0 0 2 2.0979
turtle_347.veg 347 0 1185 267 530 7.191 7.47 3.733 .16 .79 8.6 165.6 0 1 1 0 0 2 45.187
teddy_410.vtk 410 0 1207 312 620 .7043 1.026 .8162 .081 .62 11 157.5 2 1 1 0 0 2 .2297
ditto_2580.vtk 2580 0 10415 1486 2968 4.574 3.486 3.424 .24 .81 13 151.1 0 1 1 0 0 2 23.4659
shark_429_22bin.msh 429 0 1073 396 792 .1426 .06207 .1662 .08 .47 8.1 164.8 8 1 1 0 1 1 .000110256
bracket_56786_unused.vtu 16468 86110 56786 12832 25696 4 4 3.25 .085 .76 5.6 170.1 4 1 1 0 0 -16 7.41372
sphere_p2_1310.msh 214 1096 722 163 322 .9971 .997 1 .29 .78 13 156.4 0 1 1 0 0 2 .505397
pepper_big.vtu 137286 0 806437 14980 29956 60.39 135.9 51.2 2.8e-07 .88 .015 180 1859 1 1 0 0 2 135358)";

std::vector<Known> read_table() {
    std::vector<Known> all;
    std::istringstream table(kTable);
    for (Known k; table >> k.file >> k.nodes >> k.unused >> k.tets >> k.surface_nodes >> k.patches >> k.box[0] >>
                  k.box[1] >> k.box[2] >> k.worst >> k.median >> k.least_deg >> k.greatest_deg >> k.slivers >>
                  k.bodies >> k.shells >> k.inverted >> k.hinge_edges >> k.euler >> k.volume;)
        all.push_back(k);
    return all;
}

const std::vector<Known>& known_meshes() {
    static const std::vector<Known> all = read_table();
    return all;
}

// The table's digits are rounded by half a unit of the last one, which may be the second, fourth or sixth.
constexpr double kTwoDigits = 3.0 * 0.5e-1, kFourDigits = 3.0 * 0.5e-3, kSixDigits = 3.0 * 0.5e-5;

class WholeMesh : public testing::TestWithParam<Known> {};

TEST_P(WholeMesh, HasTheCountsOfItsOwners) {
    const Known& known = GetParam();
    if (!fs::exists(kMeshes / known.file)) GTEST_SKIP() << "no " << kMeshes / known.file;
    const Audit audit = audit_mesh(read_mesh(kMeshes / known.file, ReadOptions{1.0, true, {}}));
    EXPECT_EQ(std::tie(audit.nodes, audit.unused_nodes, audit.tets, audit.surface_nodes, audit.patches, audit.slivers,
                       audit.bodies, audit.shells, audit.turned, audit.hinge_edges, audit.euler),
              std::tie(known.nodes, known.unused, known.tets, known.surface_nodes, known.patches, known.slivers,
                       known.bodies, known.shells, known.inverted, known.hinge_edges, known.euler));
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_WITHIN(std::abs(audit.box_m.sizes()[axis] / known.box[axis] - 1.0), .epsilon = kFourDigits);
    EXPECT_WITHIN(std::abs(audit.worst_ratio / known.worst - 1.0), .epsilon = kTwoDigits) << audit.worst_ratio;
    EXPECT_WITHIN(std::abs(audit.median_ratio / known.median - 1.0), .epsilon = kTwoDigits) << audit.median_ratio;
    EXPECT_WITHIN(std::abs(audit.least_angle_deg / known.least_deg - 1.0), .epsilon = kTwoDigits);
    EXPECT_WITHIN(std::abs(audit.greatest_angle_deg - known.greatest_deg), .epsilon = 3.0 * 0.05);
    EXPECT_WITHIN(std::abs(audit.volume_m3 / known.volume - 1.0), .epsilon = kSixDigits);
    // Only where the geometry folds: the turned elbow is only turned, the microstructure is not.
    EXPECT_EQ(audit.folded, known.file.starts_with("microstructure") ? 8U : 0U);
}

std::string name_of(const testing::TestParamInfo<Known>& known) { return test_name(known.param.file); }
INSTANTIATE_TEST_SUITE_P(Shared, WholeMesh, testing::ValuesIn(known_meshes()), name_of);

class WholePrecompute : public testing::TestWithParam<Known> {};

/// Sound ones through the whole precompute, the tenth with the lowest z held.
TEST_P(WholePrecompute, TakesIt) {
    const Known& known = GetParam();
    if (!fs::exists(kMeshes / known.file)) GTEST_SKIP() << "no " << kMeshes / known.file;
    Scene scene;
    scene.file = "whole.toml";
    scene.name = "whole";
    scene.mesh.file = kMeshes / known.file;
    scene.mesh.linearize = true;
    scene.mesh.scale_m = 0.1 / known.box[0];
    scene.material = {1e4, 0.3};
    scene.tables.columns = ColumnRows::kNone;
    scene.fixed.push_back({std::array<double, 6>{-9, -9, -9, 9, 9, lowest_tenth_m(make_mesh(scene.mesh))}, "", 1});
    const TemporaryFolder folder;
    Progress progress(true);
    // One is folded, the other has a part that nothing holds.
    if (known.inverted == 8 || known.bodies == 2) {
        EXPECT_THROW(precompute(scene, folder.path() / "out", progress), Error);
        EXPECT_FALSE(fs::exists(folder.path() / "out"));
        return;
    }
    const Result result = precompute(scene, folder.path() / "out", progress);
    const Bound bound = inverse_bound(assemble_free(scene, result.body));
    EXPECT_WITHIN(result.summary.inverse.checks.largest_residual, bound);
    EXPECT_WITHIN(result.summary.inverse.checks.largest_block_difference, bound);
    EXPECT_EQ(read_tables(folder.path() / "out").stiffness.size(), result.body.touch_node.size());
    EXPECT_TRUE(fs::exists(folder.path() / "out/model.c"));
}

/// All but the largest, the table's last, which would take two minutes.
INSTANTIATE_TEST_SUITE_P(Shared, WholePrecompute,
                         testing::ValuesIn(known_meshes().begin(), std::prev(known_meshes().end())), name_of);

TEST(WholeMeshes, SecondOrderIsTakenOnlyWhenAsked) {
    ASSERT_EQ(known_meshes().size(), 17U) << "a row of the table cannot be read";
    for (const char* file : {"sphere_p2_1310.msh", "bracket_56786_unused.vtu"}) {
        if (!fs::exists(kMeshes / file)) GTEST_SKIP() << "no " << kMeshes / file;
        const std::string said = error_of([&] { read_mesh(kMeshes / file, 1.0); });
        EXPECT_NE(said.find("linearize = true"), std::string::npos) << said;
    }
}

/// Closed and open surfaces: counted the same way.
TEST(WholeSurfaces, AreCountedWhereTheyCannotBeTaken) {
    for (const auto& [file, says] :
         {std::pair{"surf_pepper_14980.ply",
                    "14980 vertices, 29956 triangles, 1 parts, 0 open, 0 non-manifold and 0 flipped edges, Euler "
                    "characteristic 2, 60.39 x 135.9 x 51.2 long, volume 1.354e+05 (units of the file); to fill it "
                    "give node_count = 2000 or edge_length (metres) in [mesh]; the body is 136 m long: is mesh.scale "
                    "(metres per unit) right? If its file is in millimetres, it is 0.136 m: write scale = 0.001 in "
                    "[mesh]"},
          {"surf_featuretype_1722.stl",
           "1722 vertices, 3476 triangles, 1 parts, 0 open, 0 non-manifold and 0 flipped edges, Euler characteristic "
           "-16, 5 x 2.5 x 1.375 long, volume 11.63 (units of the file); to fill it give node_count = 2000 or "
           "edge_length (metres) in [mesh]; the body is 5 m long: is mesh.scale (metres per unit) right? If its file "
           "is in centimetres, it is 0.05 m: write scale = 0.01 in [mesh]"},
          {"surf_bunny_open.ply",
           "8146 vertices, 16301 triangles, 1 parts, 123 open, 150 non-manifold and 298 flipped edges, Euler "
           "characteristic 84"},
          {"surf_multibody.stl",
           "20 vertices, 32 triangles, 2 parts, 0 open, 0 non-manifold and 12 flipped edges, Euler characteristic "
           "4"}}) {
        if (!fs::exists(kMeshes / file)) GTEST_SKIP() << "no " << kMeshes / file;
        const std::string said = error_of([&] { read_mesh(kMeshes / file, 1.0); });
        EXPECT_NE(said.find(says), std::string::npos) << file << ": " << said;
    }
}

}  // namespace
}  // namespace haptable::test
