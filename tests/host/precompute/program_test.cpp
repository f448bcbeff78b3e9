// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-precompute as a user runs it: what is printed where, the exit status, and what is left on the disk.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

const std::string kScene = R"(name = "small"
[mesh]
generate = "cube"
nodes_per_side = 3
[material]
young = 1e4
poisson = 0.3
[[fixed]]
box = [-1, -1, -1, 1, 1, 0]
)";

class PrecomputeProgram : public testing::Test {
protected:
    void SetUp() override {
        program_ = test::program("haptable-precompute");
        if (!fs::exists(program_)) GTEST_SKIP() << "no " << program_;
        write_file(scene_, kScene);
    }
    test::Outcome run(const std::string& arguments) const {
        return test::run("'" + program_.string() + "' " + arguments, folder_.path());
    }
    std::size_t file_count() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
    }

    const test::TemporaryFolder folder_;
    const fs::path scene_ = folder_.path() / "scene.toml";
    fs::path program_;
};

TEST_F(PrecomputeProgram, WritesIntoBuildNameAndTellsInATable) {
    const test::Outcome outcome = run("scene.toml");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_TRUE(fs::exists(folder_.path() / "build/small/summary.json"));
    EXPECT_TRUE(fs::exists(folder_.path() / "build/small/model.c"));
    for (const char* part : {"nodes 27", "patches 48", "||K x - b||", "columns.npy", "factor"})
        EXPECT_NE(outcome.out.find(part), std::string::npos) << part << " is missing in:\n" << outcome.out;
}

// Kernels of OpenBLAS add in other orders. Where symmetry gives 0 each leaves noise of its own, and of two modes of one
// frequency each finds another mixture.
TEST_F(PrecomputeProgram, MakesTheSameModelUnderEveryKernel) {
    __builtin_cpu_init();
    std::vector<std::string> kernels{"Nehalem"};
    if (__builtin_cpu_supports("avx")) kernels.emplace_back("Sandybridge");
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels.emplace_back("Haswell");
    if (__builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl")) kernels.emplace_back("SkylakeX");
    if (kernels.size() < 2) GTEST_SKIP() << "this processor runs one kernel alone";
    for (const std::string name : {"cube-consistent", "cube-two", "jelly"}) {
        const std::string scene = fs::absolute("meshes/" + name + ".toml").string();
        std::set<std::string> sources;
        for (const std::string& kernel : kernels) {
            const test::Outcome outcome = test::run(fmt::format("OPENBLAS_CORETYPE={} '{}' '{}' -o {} --quiet", kernel,
                                                                program_.string(), scene, kernel + name),
                                                    folder_.path());
            ASSERT_EQ(outcome.status, 0) << outcome.err;
            sources.insert(read_file(folder_.path() / (kernel + name) / "model.c"));
        }
        EXPECT_EQ(sources.size(), 1U) << name;
    }
}

TEST_F(PrecomputeProgram, WarnsOfLinearTetrahedraThatLock) {
    std::string scene = kScene;
    scene.replace(scene.find("0.3\n"), 3, "0.49");
    write_file(scene_, scene);
    for (const char* how : {"-o a", "--check"}) {
        const test::Outcome linear = run(std::string("scene.toml ") + how);
        EXPECT_EQ(linear.status, 0);
        EXPECT_NE(linear.err.find("warning: scene.toml: linear tetrahedra lock at Poisson's ratio 0.49"),
                  std::string::npos)
            << linear.err;
    }
    scene.replace(scene.find("generate"), 0, "element = \"average-nodal-pressure\"\n");
    write_file(scene_, scene);
    const test::Outcome averaged = run("scene.toml -o a --json");
    EXPECT_EQ(averaged.err, "");
    const auto summary = parse_json(averaged.out);
    EXPECT_EQ(summary.at("reused"), false) << "the tables of the other element do not stand in for these";
    EXPECT_EQ(summary.at("element").at("name"), "average-nodal-pressure");
    EXPECT_EQ(summary.at("element").at("expected_locking"), 0.0);
}

TEST_F(PrecomputeProgram, QuadraticTetrahedraHaveTheirMiddlesInEveryTable) {
    ASSERT_EQ(run("scene.toml -o a --quiet").status, 0);
    std::string scene = kScene;
    scene.replace(scene.find("generate"), 0, "element = \"quadratic\"\n");
    write_file(scene_, scene);
    const test::Outcome outcome = run("scene.toml -o a --json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto summary = parse_json(outcome.out);
    EXPECT_EQ(summary.at("reused"), false) << "the tables of the other element do not stand in for these";
    EXPECT_EQ(summary.at("element").at("name"), "quadratic");
    EXPECT_EQ(summary.at("counts").at("nodes"), 27 + 90);
    EXPECT_EQ(summary.at("counts").at("surface_patches"), 4 * 48);
    EXPECT_EQ(summary.at("counts").at("surface_nodes"), 98);
    EXPECT_EQ(summary.at("counts").at("touchable_nodes"), 98 - 25);
    const std::string vtu = read_file(folder_.path() / "a/mesh.vtu");
    EXPECT_NE(vtu.find("NumberOfPoints=\"117\""), std::string::npos);
    EXPECT_NE(vtu.find("\n10\n20\n30\n"), std::string::npos) << "ten nodes a tetrahedron";
    EXPECT_NE(vtu.find("\n24\n24\n"), std::string::npos) << "VTK_QUADRATIC_TETRA";
    // What was written is read again as it is, with the same tables.
    std::string again = scene;
    again.replace(again.find("generate = \"cube\"\nnodes_per_side = 3"), 36, "file = \"a/mesh.vtu\"");
    write_file(folder_.path() / "again.toml", again);
    ASSERT_EQ(run("again.toml -o b --quiet").status, 0);
    for (const char* file : {"stiffness.npy", "columns.npy", "patch.npy", "node_id.npy", "position.npy", "mesh.vtu"})
        EXPECT_EQ(read_file(folder_.path() / "a" / file), read_file(folder_.path() / "b" / file)) << file;
    const test::Outcome check = run("scene.toml --check");
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_NE(check.out.find("nodes in the middle of edges 90; curved tetrahedra 0"), std::string::npos) << check.out;
    const test::Outcome unchanged = run("scene.toml -o a");
    EXPECT_NE(unchanged.out.find("is unchanged in a"), std::string::npos) << unchanged.out;
}

TEST_F(PrecomputeProgram, JsonIsTheSummaryAndQuietIsSilent) {
    const test::Outcome json = run("scene.toml -o a --json");
    EXPECT_EQ(json.out, read_file(folder_.path() / "a/summary.json"));
    EXPECT_EQ(parse_json(json.out).at("counts").at("nodes"), 27);
    const test::Outcome quiet = run("scene.toml -o b/ --quiet");
    EXPECT_EQ(quiet.status, 0);
    EXPECT_EQ(quiet.out + quiet.err, "");
    EXPECT_TRUE(fs::exists(folder_.path() / "b/summary.json"));
}

// The page has the surface's patches, each held or touchable, and where the body is loose its nodes.
TEST_F(PrecomputeProgram, CheckDrawsWhatItFound) {
    const auto data_of = [&](const char* how, int status) {
        const test::Outcome check = run(std::string("scene.toml --check ") + how);
        EXPECT_EQ(check.status, status) << check.err;
        const std::string page = read_file(folder_.path() / "a/check.html");
        EXPECT_EQ(page.substr(page.size() - 8), "</html>\n");
        const std::size_t begin = page.find("const data = ") + 13;
        return parse_json(page.substr(begin, page.find(";\n", begin) - begin));
    };
    const auto data = data_of("-o a", 0);
    EXPECT_EQ(data.at("patch").size(), 48U);  // 3 x 3 x 3 nodes: six sides of 8
    const auto kinds = data.at("kind").get<std::vector<int>>();
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), 1), 8) << "the bottom is held";
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), 0), 40);
    EXPECT_EQ(data.at("worst").size(), 5U);
    EXPECT_EQ(data.at("loose").size(), 0U);
    std::string loose = kScene;  // one node alone is held
    loose.replace(loose.find("box = ["), loose.find(']', loose.find("box = [")) - loose.find("box = [") + 1,
                  "box = [-1.0, -1.0, -1.0, 1e-9, 1e-9, 1e-9]");
    write_file(scene_, loose);
    EXPECT_EQ(data_of("-o a --quiet", 1).at("loose").size(), 26U);
}

// A box without its top: what closes it is far from the scan, and the page says how far.
TEST_F(PrecomputeProgram, CheckDrawsHowFarAWrapIsFromItsScan) {
    write_file(folder_.path() / "box.off",
               "OFF\n8 10 0\n0 0 0\n30 0 0\n0 30 0\n30 30 0\n0 0 30\n30 0 30\n0 30 30\n30 30 30\n"
               "3 0 2 1\n3 1 2 3\n3 0 1 5\n3 0 5 4\n3 1 3 7\n3 1 7 5\n3 3 2 6\n3 3 6 7\n3 2 0 4\n3 2 4 6\n");
    std::string scene = kScene;
    scene.replace(scene.find("generate = \"cube\"\nnodes_per_side = 3"), 36,
                  "file = \"box.off\"\nscale = 0.001\nnode_count = 300");
    write_file(scene_,
               scene.replace(scene.find("box = ["), scene.find(']', scene.find("box = [")) - scene.find("box = [") + 1,
                             "below = 0.001"));
    const test::Outcome check = run("scene.toml --check -o a");
    ASSERT_EQ(check.status, 0) << check.err;
    EXPECT_NE(check.err.find("wrapped before it was filled (the surface does not bound a body: 4 open"),
              std::string::npos)
        << check.err;
    const std::string page = read_file(folder_.path() / "a/check.html");
    const std::size_t begin = page.find("const data = ") + 13;
    const auto data = parse_json(page.substr(begin, page.find(";\n", begin) - begin));
    ASSERT_EQ(data.at("away").size(), data.at("point").size());
    EXPECT_NEAR(data.at("farthest").get<double>(), 0.015, 0.003) << "the middle of the top, to its nearest side";
    EXPECT_NE(page.find("far from the scan (at most 1"), std::string::npos);
}

// A body that nothing holds is not under-constrained.
TEST_F(PrecomputeProgram, CheckTakesABodyThatIsFree) {
    const std::string held = "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 0]\n";
    std::string scene = kScene;
    write_file(scene_, scene.replace(scene.find(held), held.size(),
                                     "[gravity]\ndensity = 1000\n[body]\nfree = true\nfloor = 0\n"));
    const test::Outcome check = run("scene.toml --check");
    EXPECT_EQ(check.status, 0) << check.err;
    EXPECT_NE(check.out.find("0 nodes fixed, free: nothing holds it"), std::string::npos) << check.out;
    EXPECT_EQ(check.out.find("UNDER-CONSTRAINED"), std::string::npos) << check.out;
    write_file(scene_,
               scene.replace(scene.find("generate = \"cube\"\nnodes_per_side = 3"), 36, "file = \"hinge.node\""));
    write_file(folder_.path() / "hinge.node",
               "8 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 2\n6 1 0 2\n7 0 1 2\n8 0 0 3\n");
    write_file(folder_.path() / "hinge.ele", "2 4 0\n1 1 2 3 4\n2 5 6 7 8\n");
    const test::Outcome parts = run("scene.toml --check");
    EXPECT_EQ(parts.status, 1) << "two parts that touch nowhere are no free body: " << parts.out;
}

/// "feels this mesh 40 % stiffer than" or "5.1 times as stiff as", of what was written on standard error.
std::string locking_of(const std::string& err) {
    const std::size_t begin = err.find("linear tetrahedra lock");
    return begin == std::string::npos ? "" : err.substr(begin, err.find('\n', begin) - begin);
}

TEST_F(PrecomputeProgram, CheckAndRunTellTheSameLocking) {
    const std::string held = "[[fixed]]\nbox = [-1, -1, -1, 1, 1, 0]\n";
    const std::string free = "[body]\nfree = true\nmass = 0.1\n";
    const std::string mask = "[contact]\nforce = \"pressure-mask\"\nmask_radius = 0.006\n";
    for (const std::string& with : {held, free, held + mask}) {
        std::string scene = kScene;
        scene.replace(scene.find(held), held.size(), with);
        scene.replace(scene.find("0.3\n"), 3, "0.49");
        write_file(scene_, scene.replace(scene.find("side = 3"), 8, "side = 5"));
        const std::string check = locking_of(run("scene.toml --check").err);
        EXPECT_NE(check.find("by nodal pressures (the most of"), std::string::npos) << check;
        EXPECT_EQ(check, locking_of(run("scene.toml -o a --force").err)) << with;
    }
}

TEST_F(PrecomputeProgram, MuchThatIsHeldIsTold) {
    std::string scene = kScene;
    scene.replace(scene.find("side = 3"), 8, "side = 5");
    write_file(scene_, scene);
    EXPECT_EQ(run("scene.toml --check").err.find("holds"), std::string::npos) << "a fifth, one side of it";
    write_file(scene_, scene.replace(scene.find("box = "), 30, "box = [-1, -1, -1, 1, 1, 0.008]"));
    for (const char* how : {"--check", "-o a"})
        EXPECT_NE(run(std::string("scene.toml ") + how).err.find("fixed: holds 50 of 125 nodes (40 %)"),
                  std::string::npos);
}

// A layer from the lowest node on, wherever the body stands.
TEST_F(PrecomputeProgram, ALayerHoldsTheLowestNodes) {
    const std::string box = "box = [-1, -1, -1, 1, 1, 0]";
    for (const auto& [keys, held] : {std::pair{"below = 0.001", 9},
                                     {"below = 0.0151", 18},
                                     {"below = 0\naxis = \"-x\"", 9},
                                     {"below = 1\naxis = \"y\"", 27}}) {
        std::string scene = kScene;
        write_file(scene_, scene.replace(scene.find(box), box.size(), keys));
        const test::Outcome outcome = run("scene.toml -o a --json");
        if (held == 27)
            EXPECT_NE(outcome.err.find("all nodes of its patches are fixed"), std::string::npos) << outcome.err;
        else
            EXPECT_EQ(parse_json(outcome.out).at("counts").at("fixed_nodes"), held) << keys;
    }
    ASSERT_EQ(run("scene.toml --check").status, 1);
}

TEST_F(PrecomputeProgram, TwoScenesOfOneNameKeepTheirTables) {
    ASSERT_EQ(run("scene.toml --quiet").status, 0);
    const std::string tables = read_file(folder_.path() / "build/small/stiffness.npy");
    std::string other = kScene;
    write_file(folder_.path() / "other.toml", other.replace(other.find("1e4"), 3, "2e4"));
    for (const char* how : {"other.toml", "other.toml --build build"}) {
        const test::Outcome outcome = run(how);
        EXPECT_EQ(outcome.status, 1);
        EXPECT_NE(outcome.err.find("other.toml: name: \"small\" is the name of scene.toml too, whose tables are in "
                                   "build/small: give one of them another name"),
                  std::string::npos)
            << outcome.err;
    }
    EXPECT_EQ(read_file(folder_.path() / "build/small/stiffness.npy"), tables);
    EXPECT_EQ(run("./scene.toml --quiet").status, 0) << "the same file by another path";
    EXPECT_EQ(run("other.toml -o mine --quiet").status, 0) << "a folder that was named";
    fs::rename(scene_, folder_.path() / "moved.toml");
    EXPECT_EQ(run("moved.toml --quiet").status, 0) << "the first one has gone";
}

// Who left [contact] out is told what else there is; who chose is not.
TEST_F(PrecomputeProgram, LeadsToAFingerWithASize) {
    const std::string line =
        "contact = { force = \"pressure-mask\", mask_radius = 0.005, god_object = "
        "\"least-energy\" }";
    EXPECT_NE(run("scene.toml -o a").out.find(line), std::string::npos);
    std::string scene = kScene;
    write_file(scene_, scene.insert(scene.find('\n') + 1, line + "\n"));
    const test::Outcome chosen = run("scene.toml -o a");
    EXPECT_EQ(chosen.status, 0) << chosen.err;
    EXPECT_EQ(chosen.out.find("contact = {"), std::string::npos) << chosen.out;
}

TEST_F(PrecomputeProgram, PrintNameWritesNothing) {
    const test::Outcome outcome = run("scene.toml --print-name");
    EXPECT_EQ(outcome.out, "small\n");
    EXPECT_EQ(file_count(), 1U);
}

TEST_F(PrecomputeProgram, DepfileIsARuleForMake) {
    EXPECT_EQ(run("scene.toml -o a --quiet --depfile a.d").status, 0);
    EXPECT_EQ(read_file(folder_.path() / "a.d"), "a/summary.json: scene.toml\n\nscene.toml:\n");
}

TEST_F(PrecomputeProgram, BadInputIsOneLineAStatusAndNothingWritten) {
    struct Bad {
        std::string from, to, part;
    };
    const std::vector<Bad> all{
        {"young", "yung", "scene.toml:6: material.yung: unknown key"},
        {"0.3", "0.5", "scene.toml:7: material.poisson"},
        {"1e4", "-1e4", "scene.toml:6: material.young"},
        {"[[fixed]]\nbox = [-1, -1, -1, 1, 1, 0]\n", "", "scene.toml: fixed: 27 of 27 nodes are under-constrained"},
        {"generate = \"cube\"\nnodes_per_side = 3", "file = \"no.msh\"", "no.msh: mesh file cannot be read"},
        {"[[fixed]]", "[[touch]]\nbox = [5, 5, 5, 6, 6, 6]\n[[fixed]]", "scene.toml:8: touch.box"},
        {"name = ", "name ", "scene.toml:1: "},
    };
    for (const Bad& bad : all) {
        std::string text = kScene;
        write_file(scene_, text.replace(text.find(bad.from), bad.from.size(), bad.to));
        const test::Outcome outcome = run("scene.toml -o a");
        EXPECT_EQ(outcome.status, 1) << bad.to;
        EXPECT_EQ(outcome.out, "");
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        EXPECT_NE(outcome.err.find(bad.part), std::string::npos) << outcome.err;
        EXPECT_EQ(file_count(), 1U) << bad.to;
    }
}

TEST_F(PrecomputeProgram, AKilledRunLeavesNothingThatTheNextOneKeeps) {
    std::string large = kScene;
    write_file(folder_.path() / "large.toml",
               large.replace(large.find("side = 3"), 8, "side = 24"));  // seconds of work
    const std::string script = "{ '" + program_.string() +
                               "' large.toml -o a --quiet & } && for i in $(seq 1000); do "
                               "[ -e a/tables.haptable-$! ] && break; sleep 0.01; done; kill -9 $!; wait";
    test::run(script, folder_.path());
    ASSERT_EQ(file_count(), 3U) << "two scenes and a folder";
    ASSERT_FALSE(fs::exists(folder_.path() / "a/summary.json"));
    const test::Outcome outcome = run("scene.toml -o a --quiet");
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    for (const auto& entry : fs::directory_iterator(folder_.path() / "a"))
        EXPECT_EQ(entry.path().filename().string().find("tables.haptable-"), std::string::npos) << entry.path();
}

// A build system's lock file, a folder of pages, a link: each stays as it is, and the error says what to do.
TEST_F(PrecomputeProgram, FilesOfOthersStay) {
    write_file(folder_.path() / "Cargo.lock", "the user's");
    write_file(folder_.path() / "victim", "the user's");
    fs::create_symlink("victim", folder_.path() / "out.lock");
    fs::create_directories(folder_.path() / "docs");
    write_file(folder_.path() / "docs/summary.json", "the user's");
    EXPECT_EQ(run("scene.toml -o Cargo --quiet").status, 0);
    EXPECT_EQ(run("scene.toml -o out --quiet").status, 0);
    for (const char* how : {"-o docs", "-o .", "-o docs --force"}) {
        const test::Outcome refused = run(std::string("scene.toml ") + how);
        EXPECT_EQ(refused.status, 1) << how;
        EXPECT_NE(refused.err.find("holds files that haptable did not write"), std::string::npos) << refused.err;
        EXPECT_NE(refused.err.find("give a new or an empty folder"), std::string::npos) << refused.err;
    }
    const test::Outcome check = run("scene.toml --check -o docs");
    EXPECT_NE(check.err.find("warning: docs: holds files that haptable did not write"), std::string::npos) << check.err;
    for (const char* kept : {"Cargo.lock", "victim", "docs/summary.json"})
        EXPECT_EQ(read_file(folder_.path() / kept), "the user's") << kept;
    EXPECT_TRUE(fs::is_symlink(folder_.path() / "out.lock"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path() / "docs"), {}), 1);
}

TEST_F(PrecomputeProgram, AMissingSceneAndABadCommandLineFail) {
    const test::Outcome missing = run("none.toml -o a");
    EXPECT_EQ(missing.status, 1);
    EXPECT_NE(missing.err.find("none.toml: cannot be read"), std::string::npos) << missing.err;
    EXPECT_EQ(run("").status, 2);
    EXPECT_EQ(run("scene.toml --no-such-option").status, 2);
    EXPECT_EQ(file_count(), 1U);
}

}  // namespace

}  // namespace haptable
