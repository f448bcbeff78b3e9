// SPDX-License-Identifier: GPL-2.0-or-later
// Names of files that a shell, make or gnuplot would execute, given to every program and script that takes one: none is
// executed, and where a name can be used the work is done.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "host/base/file.hpp"
#include "host/base/shell.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

/// Stems of names. What one executes makes a file `pwned` in the current folder.
const std::vector<std::string> kNames{
    "$(shell touch pwned)",
    "${shell touch pwned}",
    "$$(touch pwned)",
    "$(touch pwned)",
    "`touch pwned`",
    "a`touch pwned`b",
    "';touch pwned;'",
    "'; touch pwned; echo '",
    "\";touch pwned;\"",
    "\"; touch pwned; echo \"",
    ";touch pwned",
    ";touch pwned;",
    "& touch pwned &",
    "&& touch pwned",
    "|| touch pwned",
    "| touch pwned",
    "a\ntouch pwned\n",
    "a\n\ttouch pwned",
    "a\r\ntouch pwned",
    "#\ntouch pwned",
    "a:;touch pwned",
    "a: ; touch pwned",
    "a = $(shell touch pwned)",
    "a := $(shell touch pwned)",
    "$(eval x:=$(shell touch pwned))",
    "$(call shell,touch pwned)",
    "$(if $(shell touch pwned),a,b)",
    "$(error pwned)",
    "$(SCENE)",
    "$(value SCENE)",
    "'$(shell touch pwned)'",
    "\\'; touch pwned; \\'",
    "\\",
    "a\\",
    "'",
    "\"",
    "''",
    "'.system(\"touch pwned\").'",
    "';system(\"touch pwned\");'",
    "';!touch pwned;'",
    "'\nsystem(\"touch pwned\")\n'",
    ">pwned",
    "a>pwned",
    "*",
    "?[a-z]*",
    "~",
    "%",
    "-o pwned",
    "--depfile=pwned",
    "a b  c",
};

class Names : public testing::TestWithParam<std::string> {
protected:
    static void TearDownTestSuite() { fs::remove_all(build_folder() / "evil-names"); }
    void SetUp() override {
        if (!fs::exists(program("haptable-precompute"))) GTEST_SKIP() << "no programs";
        std::string scene = read_file("meshes/cube.toml");
        scene.replace(scene.find("name = \"cube\""), 13, "name = \"evil-names\"");
        scene.replace(scene.find("nodes_per_side = 5"), 18, "nodes_per_side = 3");
        write_file(in(".toml"), scene);
    }
    /// A file of that name.
    fs::path in(const std::string& suffix) const { return fs::path(work_) / (GetParam() + suffix); }
    /// As a word of the shell, which no program takes for an option.
    std::string word(const std::string& suffix) const { return shell_quoted(no_option(GetParam() + suffix)); }
    /// There, whatever it does; nothing of the name is executed.
    Outcome execute(const std::string& command, const fs::path& where) const {
        Outcome outcome = run(command, where);
        EXPECT_FALSE(fs::exists((where.empty() ? fs::path(".") : where) / "pwned")) << command << "\n" << outcome.err;
        EXPECT_FALSE(fs::exists(fs::path(work_) / "pwned")) << command;
        std::error_code ignored;
        fs::remove((where.empty() ? fs::path(".") : where) / "pwned", ignored);
        return outcome;
    }
    void expect_done(const std::string& command) const {
        const Outcome outcome = execute(command, work_);
        EXPECT_EQ(outcome.status, 0) << command << "\n" << outcome.err;
    }

    const TemporaryFolder folder_;
    const std::string work_ = folder_.path().string();
};

TEST_P(Names, AreOneWordOfAShell) { EXPECT_EQ(run("printf '%s|' " + shell_quoted(GetParam())).out, GetParam() + "|"); }

TEST_P(Names, OfProgramsFiles) {
    const auto bin = [](const char* name) { return shell_quoted(program(name)) + " "; };
    const std::string scene = word(".toml"), tables = word("");
    expect_done(bin("haptable-precompute") + scene + " --quiet -o " + tables);
    EXPECT_TRUE(fs::exists(in("") / "summary.json"));
    execute(bin("haptable-precompute") + scene + " --quiet -o again --depfile " + word(".d"), work_);
    if (fs::exists(in(".d"))) {  // a name that make can read
        std::ofstream(fs::path(work_) / "Makefile") << "again/summary.json:\n\techo made >$@\ninclude "
                                                    << "the.d\n";
        fs::copy_file(in(".d"), fs::path(work_) / "the.d");
        expect_done("make -s && ! grep -q made again/summary.json");
        expect_done("touch " + scene + " && sleep 0.01 && make -s && grep -q made again/summary.json");
    }
    expect_done(bin("haptable-codegen") + tables + " --export cmake -o " + word(".project"));
    expect_done(bin("haptable-view") + tables + " --mesh --quiet --size 160x160 -o " + word(".png"));
    expect_done(bin("haptable-view") + tables + " --mesh --quiet --size 160x160 -o " + word(".svg"));
    expect_done(bin("haptable-view") + tables + " --mesh --quiet --size 160x160 -o " + word(".pictures"));
    write_file(
        in(".csv"), "time_s,depth_m,force_n\n" + [] {
            std::string lines;
            for (int i = 0; i < 40; ++i) lines += fmt::format("{},{},{}\n", 0.01 * i, 1e-5 * i, 1e-3 * i);
            return lines + "0.5,0,0\n";
        }());
    const Outcome fitted = execute(bin("haptable-fit") + word(".csv") + " " + scene + " --quiet --tables " + tables +
                                       " --terms 0 --plot " + word(".fit.svg"),
                                   work_);
    if (run("command -v gnuplot").status == 0) {
        EXPECT_EQ(fitted.status, 0) << fitted.err;
    }
    execute(bin("haptable-count") + tables + " -o " + word(".counts"), work_);
    execute(bin("haptable-bridge") + tables + " --port " + word(".port") + " --seconds 0.01 --patience 0.01", work_);
    execute(bin("haptable-device") + scene + " --tables " + tables + " --seconds 0.01 --patience 0.01 --quiet --csv " +
                word(".device.csv"),
            work_);
}

// In haptable's folder haptable-run calls make, as people do.
TEST_P(Names, OfAScene) {
    const std::string scene = shell_quoted(in(".toml").string());
    const std::string make = "make -s scene-alone SCENE_MAKES= BUILD=" + build_folder().string() + " SCENE=" + scene;
    const Outcome made = execute(make, {});
    EXPECT_EQ(made.status, 0) << make << "\n" << made.err;
    EXPECT_TRUE(fs::exists(build_folder() / "evil-names/summary.json"));
    execute("SCENE=" + scene + " make -s scene-alone SCENE_MAKES= BUILD=" + build_folder().string(), {});
    for (const char* other : {"TARGET", "NAME", "BUILD"}) {
        const Outcome refused = execute(fmt::format("make -s help {}={}", other, shell_quoted(GetParam())), {});
        EXPECT_TRUE(refused.status != 0 || GetParam() == "~") << other;
    }
    execute("make -n install uninstall PREFIX=" + shell_quoted(GetParam()) + " DESTDIR=" + shell_quoted(GetParam()) +
                " BUILD=" + build_folder().string(),
            {});
}

TEST_P(Names, OfScripts) {
    const std::string root = shell_quoted(fs::current_path()), name = word("");
    fs::create_directory(in(""));
    const std::string in_root = "cd " + root + " && ";
    for (const std::string& command : {
             "scripts/clean.sh " + name,
             "scripts/qemu.sh cortex-m7 " + name + " " + name,
             "CROSS= sh scripts/size.sh " + name + " " + name,
             "CROSS= sh scripts/stack.sh " + name + " " + name,
             "BUILD=" + name + " LINE=" + name + " BAUD=1 SECONDS_=0.01 sh scripts/loop.sh " + name + " " + name +
                 " rv32",
             "BUILD=" + name + " sh scripts/demo.sh",
             "packaging/install.sh " + name + " /" + name + " /" + name,
         })
        execute("ln -sfn " + root + "/scripts scripts; ln -sfn " + root + "/packaging packaging; " +
                    (command.starts_with("BUILD") || command.starts_with("CROSS") ? command : "sh " + command),
                work_);
}

TEST_P(Names, OfAnInstalledScene) {
    const fs::path bin = fs::path(work_) / "bin";
    fs::create_directory(bin);
    fs::create_directory(fs::path(work_) / "lib");
    fs::copy_file("packaging/haptable-build", bin / "haptable-build");
    fs::create_symlink(program("haptable-precompute"), bin / "haptable-precompute");
    // A compiler that makes what -o names.
    write_file(bin / "cc", "#!/bin/sh\nwhile [ \"$1\" != -o ]; do shift; done; : >\"$2\"\n");
    fs::permissions(bin / "cc", fs::perms::owner_all);
    const std::string cc = shell_quoted(bin / "cc");
    expect_done("CC=" + cc + " CXX=" + cc + " " + shell_quoted(bin / "haptable-build") + " " + word(".toml") + " -o " +
                shell_quoted(GetParam()));
    EXPECT_TRUE(fs::exists(in("") / "servo"));
}

std::string label(const testing::TestParamInfo<std::string>& info) { return fmt::format("N{:02}", info.index); }
INSTANTIATE_TEST_SUITE_P(Evil, Names, testing::ValuesIn(kNames), label);

}  // namespace
}  // namespace haptable::test
