// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-precompute-mpi under mpirun against haptable-precompute: other solver, other processes, the same tables. Of
// every element and law PassesTheTestsOfAnInverse compares them (PrecomputeBy in tests/host/inverse).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "tests/bodies.hpp"
#include "tests/conditioning.hpp"
#include "tests/error_of.hpp"
#include "tests/files_apart.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

const std::string kScene = R"(name = "cube"
[mesh]
generate = "cube"
nodes_per_side = 5
side = 0.03
[material]
young = 1e4
poisson = 0.49
[[fixed]]
box = [-1, -1, -1, 1, 1, 0]
)";

// Each side is rounded once to what the file holds, and the two may fall on either side of a tie.
constexpr test::Bound kFloats{.count = 8.0, .epsilon = test::kFloat};

/// What blocks in double, by two solvers, may differ by: S_i = L_ii^-1 and the condition of L_ii, under 10.
test::Bound blocks(int nodes_per_side) {
    return test::inverse_bound(test::cube_stiffness(nodes_per_side, 0.49)).times(10.0);
}

class Mpi : public testing::TestWithParam<int> {
protected:
    void SetUp() override {
        if (!fs::exists(many_) || test::run("command -v mpirun").status != 0)
            GTEST_SKIP() << "no mpirun or no haptable-precompute-mpi: make mpi";
    }
    /// Runs both programs on a scene, into one/ and many/; the exit status of the second.
    int run(const std::string& scene) const {
        write_file(folder_.path() / "scene.toml", scene);
        system_of("'" + one_.string() + "' scene.toml -o one --column-tolerance 0 --quiet 2>one.txt");
        return system_of(start() + " 2>many.txt");
    }
    std::string start() const { return mpirun() + "'" + many_.string() + "' scene.toml -o many --quiet"; }
    static std::string mpirun() {
        // Processes that wait let others run, and none is bound to a processor that another test uses.
        return "OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1 mpirun --allow-run-as-root "
               "--oversubscribe --bind-to none -n " +
               std::to_string(GetParam()) + " ";
    }
    int system_of(const std::string& command) const { return test::run(command, folder_.path()).status; }
    fs::path one(const char* file) const { return folder_.path() / "one" / file; }
    fs::path many(const char* file) const { return folder_.path() / "many" / file; }

    const test::TemporaryFolder folder_;
    const fs::path one_ = test::program("haptable-precompute"), many_ = test::program("haptable-precompute-mpi");
};

// What three processes run as well: MPI's spin where they wait, which takes ten times as long on two processors.
class MpiOfMore : public Mpi {};

TEST_P(MpiOfMore, WritesTheTablesOfOneProcess) {
    ASSERT_EQ(run(kScene), 0) << read_file(folder_.path() / "many.txt");
    EXPECT_WITHIN(test::difference<double>(one("stiffness.npy"), many("stiffness.npy")), blocks(5));
    EXPECT_WITHIN(test::difference<float>(one("columns.npy"), many("columns.npy")), kFloats);
    for (const char* file : {"node_id.npy", "patch.npy", "row_id.npy", "position.npy", "surface.npy", "mesh.vtu"})
        EXPECT_EQ(read_file(one(file)), read_file(many(file))) << file;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path() / "one"))
        EXPECT_TRUE(fs::exists(many(entry.path().filename().c_str()))) << entry.path();
    const auto summary = parse_json(read_file(many("summary.json")));
    EXPECT_EQ(summary.at("ranks").at("count"), GetParam());
    const auto pivot = [](const nlohmann::json& json) {
        return json.at("checks").at("smallest_pivot_ratio").get<double>();
    };
    const double bound = pivot(summary), exact = pivot(parse_json(read_file(one("summary.json"))));
    EXPECT_LT(bound, exact);
    EXPECT_GT(bound, 1e-3 * exact);
    EXPECT_WITHIN(summary.at("checks").at("largest_residual").get<double>(), blocks(5));  // of unit loads
    EXPECT_EQ(summary.at("model_hash"), parse_json(read_file(one("summary.json"))).at("model_hash"));
}

TEST_P(Mpi, ARunThatWasCutShortGoesOnFromItsColumns) {
    std::string large = kScene;
    large.replace(large.find("side = 5"), 8, "side = 12");  // 584 touchable nodes, 10 groups
    ASSERT_EQ(run(large), 0) << read_file(folder_.path() / "many.txt");
    fs::rename(folder_.path() / "many", folder_.path() / "whole");
    // Rank 0 is killed, whose number is in a folder's name; mpirun ends the others.
    (void)system_of("( " + start() +
                    " & for i in $(seq 3000); do [ \"$(cat many/columns.unfinished/journal 2>/dev/null | wc -l)\" "
                    "-gt 3 ] && break; sleep 0.01; done; kill -9 $(ls many | sed -n 's/tables.haptable-//p'); wait ) "
                    ">killed.txt 2>&1");
    ASSERT_TRUE(fs::exists(folder_.path() / "many" / "columns.unfinished" / "journal"))
        << "it ended before it was stopped";
    ASSERT_EQ(system_of(start() + " 2>many.txt"), 0) << read_file(folder_.path() / "many.txt");
    EXPECT_GE(parse_json(read_file(many("summary.json"))).at("resumed_columns"), 3 * 64);
    // MUMPS on several ranks adds in the order in which messages come: the bits are not those of the other run.
    EXPECT_WITHIN(test::difference<float>(many("columns.npy"), folder_.path() / "whole" / "columns.npy"), kFloats);
    EXPECT_WITHIN(test::difference<double>(many("stiffness.npy"), folder_.path() / "whole" / "stiffness.npy"),
                  blocks(12));
    EXPECT_FALSE(fs::exists(folder_.path() / "many" / "columns.unfinished"));
}

TEST_P(Mpi, AnErrorIsTheLeadersOneLineAndEndsAllRanks) {
    std::string scene = kScene;
    EXPECT_EQ(run(scene.replace(scene.find("[[fixed]]"), std::string::npos, "")), 1);
    const std::string said = read_file(folder_.path() / "many.txt");
    EXPECT_TRUE(test::says(said, "scene.toml: fixed: 125 of 125 nodes are under-constrained"));
    EXPECT_FALSE(fs::exists(folder_.path() / "many"));
}

TEST_P(MpiOfMore, PassesTheTestsOfAnInverse) {
    const fs::path ranks = test::build_folder() / "tests/ranks";
    ASSERT_TRUE(fs::exists(ranks)) << "make " << ranks;
    const test::Outcome outcome = test::run(mpirun() + "'" + fs::absolute(ranks).string() + "' --gtest_brief=1",
                                            folder_.path(), std::chrono::seconds(300));
    EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
    EXPECT_TRUE(test::says(outcome.out, "[  PASSED  ]")) << outcome.out << outcome.err;
}

INSTANTIATE_TEST_SUITE_P(Ranks, Mpi, testing::Values(1, 2));
INSTANTIATE_TEST_SUITE_P(Ranks, MpiOfMore, testing::Values(1, 2, 3));

}  // namespace
}  // namespace haptable
