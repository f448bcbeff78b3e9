// SPDX-License-Identifier: GPL-2.0-or-later
// make install into an empty root, and then without the source tree: scene, servo, page, manuals, exit codes, and away.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>

#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

/// Files of a folder, and of those below it.
std::size_t count_files(const fs::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) count += entry.is_directory() ? 0 : 1;
    return count;
}

class Installed : public testing::Test {
protected:
    static void SetUpTestSuite() {
        root_ = std::make_unique<TemporaryFolder>();
        made_ =
            run("make -s install DESTDIR=" + root_->path().string() + " PREFIX=/usr BUILD=" + build_folder().string());
    }
    static void TearDownTestSuite() { root_.reset(); }

    void SetUp() override {
        ASSERT_EQ(made_.status, 0) << made_.err;
        fs::create_directory(work_ / "my scenes");
        fs::copy_file("meshes/cube.toml", work_ / "my scenes/a cube.toml");
    }

    /// A command of the shell in an empty folder, with the installed programs on the PATH.
    Outcome in_shell(const std::string& command) const {
        return run("PATH=" + usr().string() + "/bin:$PATH; " + command, work_);
    }
    static fs::path usr() { return root_->path() / "usr"; }

    static inline std::unique_ptr<TemporaryFolder> root_;
    static inline Outcome made_;
    const TemporaryFolder folder_;
    const fs::path work_ = folder_.path();
};

TEST_F(Installed, BuildsAServoWithTheBitsOfTheSourceTrees) {
    const Outcome built = in_shell("haptable-build 'my scenes/a cube.toml'");
    ASSERT_EQ(built.status, 0) << built.err;
    std::ofstream(work_ / "path.csv") << "x,y,z\n0.015,0.015,0.031\n0.0151,0.0152,0.028\n0.017,0.012,0.026\n";
    ASSERT_EQ(in_shell("build/cube/servo --quiet --replay path.csv --out felt.csv").status, 0);
    const std::string ours = fs::absolute(build_folder() / "cube/servo").string();
    ASSERT_EQ(in_shell(ours + " --quiet --replay path.csv --out expected.csv").status, 0);
    EXPECT_EQ(read_file(work_ / "felt.csv"), read_file(work_ / "expected.csv"));
    std::ofstream(work_ / "leap.csv") << "x,y,z\n0.015,0.015,0.05\n0.015,0.015,0.02\n";
    const Outcome leap = in_shell("build/cube/servo --replay leap.csv --out nothing-felt.csv");
    EXPECT_NE(leap.err.find("1 of its positions leap"), std::string::npos) << leap.err;
    const auto made = fs::last_write_time(work_ / "build/cube/servo");
    ASSERT_EQ(in_shell("haptable-build 'my scenes/a cube.toml'").status, 0);
    EXPECT_EQ(fs::last_write_time(work_ / "build/cube/servo"), made) << "made twice";
}

// docs/INSTALL.md says how much is installed: within a twentieth.
TEST_F(Installed, HasAsManyFilesAsThePageSays) {
    const std::string page = read_file("docs/INSTALL.md");
    std::size_t files = 0;
    double megabytes = 0.0;
    const std::size_t row = page.find("| `make install`, all built: ");
    ASSERT_NE(row, std::string::npos);
    ASSERT_EQ(std::sscanf(page.c_str() + row, "| `make install`, all built: %zu files | %lf MB", &files, &megabytes),
              2);
    double bytes = 0.0;
    for (const auto& entry : fs::recursive_directory_iterator(root_->path()))
        if (entry.is_regular_file() && !entry.is_symlink()) bytes += static_cast<double>(entry.file_size());
    const auto count = static_cast<double>(count_files(root_->path()));
    EXPECT_NEAR(count / static_cast<double>(files), 1.0, 0.05) << "write " << count << " into docs/numbers.json";
    EXPECT_NEAR(1e-6 * bytes / megabytes, 1.0, 0.05) << "write " << 1e-6 * bytes << " MB into docs/numbers.json";
}

TEST_F(Installed, FindsItsModulesAndThePartsOfAPage) {
    ASSERT_EQ(
        in_shell("haptable-precompute --check --quiet " + (usr() / "share/haptable/meshes/mouse.toml").string()).status,
        0);
    ASSERT_EQ(in_shell("haptable-precompute --quiet 'my scenes/a cube.toml' -o cube").status, 0);
    const Outcome page = in_shell("haptable-view cube --page touch.html --quiet");
    ASSERT_EQ(page.status, 0) << page.err;
    EXPECT_EQ(read_file(work_ / "touch.html").rfind("<!", 0), 0U);
}

/// Its servo is made where it is missing, by haptable-build, in build/ of the current folder, where the device finds
/// it.
TEST_F(Installed, RunsASessionWithoutTheSourceTree) {
    const std::string loopback = "sh " + fs::absolute("scripts/loopback.sh").string() + " ";
    if (run(loopback + "true").status == 77) GTEST_SKIP() << "LCM cannot work here";
    const Outcome session = in_shell(
        loopback + "haptable-run 'my scenes/a cube.toml' --path poke --lockstep --draw nothing --json -o session");
    ASSERT_EQ(session.status, 0) << session.err;
    EXPECT_TRUE(fs::exists(work_ / "build/cube/servo"));
    EXPECT_NE(session.out.find("\"contact_ticks\""), std::string::npos) << session.out;
    EXPECT_EQ(session.out.find("\"contact_ticks\": 0,"), std::string::npos) << session.out;
}

TEST_F(Installed, StatusTellsWhoIsWrong) {
    for (const std::string name : {"build", "precompute", "codegen", "device", "view", "bridge", "run", "fit"}) {
        const std::string command = "haptable-" + name;
        EXPECT_EQ(in_shell(command + " --version").status, 0) << name;
        EXPECT_EQ(in_shell(command + " --no-such-option").status, 2) << name;
        const Outcome none = in_shell(command + " none.toml -o out");
        EXPECT_TRUE(none.status == 1 || (none.status == 2 && name != "build" && name != "precompute")) << name;
        const std::string version = in_shell(command + " --version").out;
        EXPECT_EQ(version.rfind(command + " ", 0), 0U) << version;
        const std::string manual = (usr() / "share/man/man1" / (command + ".1.gz")).string();
        EXPECT_NE(in_shell("zcat " + manual).out.find(".SH \"EXIT STATUS\""), std::string::npos) << name;
    }
}

/// What a user types for an example, the library found by its prefix alone.
TEST_F(Installed, CompilesTheExamplesByPkgConfigAndByCMake) {
    ASSERT_EQ(in_shell("haptable-precompute --quiet 'my scenes/a cube.toml' -o cube").status, 0);
    const std::string found = "export PKG_CONFIG_SYSROOT_DIR=" + root_->path().string() +
                              " PKG_CONFIG_PATH=" + (usr() / "lib/pkgconfig").string() +
                              " LD_LIBRARY_PATH=" + (usr() / "lib").string() + " CMAKE_PREFIX_PATH=" + usr().string() +
                              "; cp -r " + (usr() / "share/doc/haptable/examples").string() + " .; ";
    const Outcome c = in_shell(
        found + "gcc -Wall -Werror -pedantic examples/touch.c $(pkg-config --cflags --libs haptable) -o c && ./c cube");
    EXPECT_EQ(c.status, 0) << c.err;
    const Outcome cpp = in_shell(
        found +
        "g++ -std=c++17 -Wall -Werror examples/touch.cpp $(pkg-config --cflags --libs haptable) -o cpp && ./cpp cube");
    EXPECT_EQ(cpp.status, 0) << cpp.err;
    write_file(work_ / "CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.16)\nproject(touch C)\nfind_package(haptable 0.1 REQUIRED)\n"
               "add_executable(touch examples/touch.c)\ntarget_link_libraries(touch PRIVATE haptable::haptable)\n");
    const Outcome cmake =
        in_shell(found + "cmake -S . -B out >/dev/null && cmake --build out >/dev/null && out/touch cube");
    EXPECT_EQ(cmake.status, 0) << cmake.err;
    EXPECT_EQ(cmake.out, c.out);
    // 3.9 mm below the top: what the servo of the source tree says of that path.
    std::ofstream path(work_ / "path.csv");
    path << "x,y,z\n";
    for (int tick = 0; tick < 60; ++tick)
        path << fmt::format("0.015,0.015,{:.9g}\n", 0.032F - 1e-4F * static_cast<float>(tick));
    path.close();
    const Outcome servo =
        in_shell(fs::absolute(build_folder() / "cube/servo").string() +
                 " --quiet --replay path.csv --out felt.csv && "
                 "tail -n 1 felt.csv | awk -F, '{ printf \"%.4g N on nodes %d %d %d\", $17, $6, $7, $8 }'");
    EXPECT_NE(c.out.find(servo.out), std::string::npos) << c.out << servo.out << servo.err;
    EXPECT_EQ(cpp.out.rfind("node ", 0), 0U) << cpp.out;
}

TEST_F(Installed, BashCompletesOptions) {
    const std::string script = (usr() / "share/bash-completion/completions/haptable-view").string();
    const Outcome view = in_shell("bash -c '. " + script +
                                  "; COMP_WORDS=(haptable-view --v); COMP_CWORD=1; _haptable haptable-view; "
                                  "echo ${COMPREPLY[@]}'");
    EXPECT_EQ(view.out, "--vtu --version\n");
}

TEST_F(Installed, GoesWithoutAResidue) {
    const TemporaryFolder root;
    const std::string where = " DESTDIR=" + root.path().string() + " PREFIX=/opt BUILD=" + build_folder().string();
    ASSERT_EQ(run("make -s install" + where).status, 0);
    ASSERT_GT(count_files(root.path()), 100U);
    std::ofstream(root.path() / "opt/share/haptable/mine") << "not haptable's\n";
    ASSERT_EQ(run("make -s uninstall" + where).status, 0);
    EXPECT_EQ(count_files(root.path()), 1U);
    EXPECT_TRUE(fs::exists(root.path() / "opt/share/haptable/mine"));
    EXPECT_FALSE(fs::exists(root.path() / "opt/bin"));
}

TEST(Install, RefusesAPrefixOfTheCurrentFolder) {
    const Outcome outcome =
        run("BUILD=" + build_folder().string() + " sh packaging/install.sh '' some/where some/where/lib");
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("PREFIX=some/where: give it from the root"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists("some"));
}

TEST(Clean, KeepsTablesAndFinishedColumns) {
    const TemporaryFolder folder;
    const fs::path build = folder.path() / "build";
    for (const char* file :
         {"bin/haptable-view", "cube/summary.json", "cube/node_id.npy", "cube/model.c", "cube/servo", "cube/model.c.o",
          "cube/firmware/rv32/loop.elf", "liver/columns.unfinished/columns.npy", "report/bench.json"}) {
        fs::create_directories((build / file).parent_path());
        std::ofstream(build / file) << file;
    }
    for (const char* how : {"", " all"}) {  // a folder that is not make's
        EXPECT_EQ(run("sh scripts/clean.sh " + build.string() + how).status, 1);
        EXPECT_EQ(count_files(build), 9U);
    }
    std::ofstream(build / "setup.stamp") << "";
    ASSERT_EQ(run("sh scripts/clean.sh " + build.string()).status, 0);
    EXPECT_EQ(count_files(build), 5U);
    for (const char* file : {"cube/summary.json", "cube/node_id.npy", "cube/model.c", "setup.stamp",
                             "liver/columns.unfinished/columns.npy"})
        EXPECT_TRUE(fs::exists(build / file)) << file;
    fs::remove_all(build / "cube");
    fs::remove_all(build / "liver");
    ASSERT_EQ(run("sh scripts/clean.sh " + build.string()).status, 0);
    EXPECT_FALSE(fs::exists(build));
}

// Dependencies are written with a folder's name: by another name they would not be read, and old objects be linked.
TEST(BuildFolder, HasOneNameHoweverItIsGiven) {
    const std::string here = fs::current_path().string();
    for (const std::string& name :
         {std::string("build"), std::string("build/"), std::string("./build"), here + "/build", here + "/build//"})
        EXPECT_EQ(run("make -pn help BUILD=" + name + " | grep '^BUILD :='").out, "BUILD := build\n") << name;
    EXPECT_EQ(run("make -pn help BUILD=/elsewhere/ | grep '^BUILD :='").out, "BUILD := /elsewhere\n");
}

TEST(MakeScene, TakesAPathWithBlanks) {
    const TemporaryFolder folder;
    const fs::path scene = folder.path() / "my scenes" / "a b.toml", tables = build_folder() / "path-with-blanks";
    fs::create_directories(scene.parent_path());
    std::string text = read_file("meshes/cube.toml");
    text.replace(text.find("\"cube\""), 6, "\"path-with-blanks\"");
    write_file(scene, text);
    const std::string make =
        "make -s scene-alone SCENE_MAKES=summary.json 'SCENE=" + scene.string() + "' BUILD=" + build_folder().string();
    const Outcome first = run(make);
    ASSERT_EQ(first.status, 0) << first.err;
    const auto made = fs::last_write_time(tables / "summary.json");
    const Outcome again = run(make);
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(fs::last_write_time(tables / "summary.json"), made) << "made twice";
    fs::remove_all(tables);
}

}  // namespace
}  // namespace haptable::test
