// SPDX-License-Identifier: GPL-2.0-or-later
// scripts/stack.py: the stack of every function that a board's program calls, and no call through a pointer is missed.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "host/target/image.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

std::map<std::string, int> rows_of(const std::string& text) {
    std::map<std::string, int> rows;
    std::istringstream lines(text);
    int bytes = 0;
    for (std::string name; lines >> name >> bytes;) rows[name] = bytes;
    return rows;
}

TEST(Stack, OfEveryFunctionThatABoardCallsIsKnownOnEveryTarget) {
    for (const std::string target : kTargets)
        for (const std::string scene : {"cube", "cube-two", "free-cube", "wobbling", "display"}) {
            const fs::path folder = build_folder() / scene / "firmware" / target;
            if (!fs::exists(folder / "model.o")) GTEST_SKIP() << folder << " is not built: make images";
            SCOPED_TRACE(folder);
            const std::string cross = target == "rv32" ? "riscv64-unknown-elf-" : "arm-none-eabi-";
            const Outcome found = run("CROSS=" + cross + " python3 scripts/stack.py " + folder.string() + " " +
                                      (folder / "model.o").string());
            ASSERT_EQ(found.status, 0) << found.err;
            std::map<std::string, int> rows = rows_of(found.out);
            for (const char* entry : {"init", "step", "watch", "check", "counters_of", "pose_of", "swing_of", "deform",
                                      "line_begin", "line", "tool_watch"})
                EXPECT_EQ(rows.count(std::string("haptable_") + entry), 1U) << entry;
            EXPECT_EQ(rows.size(), 11U);
            EXPECT_GT(rows["haptable_line"], rows["haptable_step"] + 200) << "it steps, with an answer beside";
            EXPECT_GT(rows["haptable_step"], scene == "cube-two" || scene == "wobbling" ? 2000 : 500);
        }
}

// Whatever the linker keeps somebody calls: a pointer that stack.py followed to too few functions would leave some out.
TEST(Stack, EveryFunctionThatTheLinkerKeepsIsBelowAnEntry) {
    for (const std::string scene : {"cube", "cube-two", "free-cube", "wobbling"}) {
        const fs::path folder = build_folder() / scene / "firmware/cortex-m7";
        if (!fs::exists(folder / "loop.elf")) GTEST_SKIP() << folder << " is not built: make images";
        const Outcome missed = run(
            "F=" + folder.string() +
            "; plain() { sed 's/.*://; s/\\.\\(isra\\|part\\|constprop\\|cold\\)\\.[0-9]*//g' | sort -u; }; "
            "W=$(mktemp -d); CROSS=arm-none-eabi- python3 scripts/stack.py $F $F/model.o --names | plain >$W/reached; "
            "functions() { arm-none-eabi-nm \"$@\" | awk '$2 ~ /[TtWw]/ { print $3 }' | plain; }; "
            "functions $F/loop.elf >$W/kept; functions $F/haptable_*.o | comm -12 - $W/kept >$W/ours; "
            "wc -l <$W/ours; comm -23 $W/ours $W/reached; rm -r $W");
        std::istringstream lines(missed.out);
        int kept = 0;
        lines >> kept;
        EXPECT_GT(kept, 40) << scene << missed.err;
        std::string name;
        EXPECT_FALSE(lines >> name) << scene << ": nobody calls " << name;
    }
}

/// What stack.py says of one file with `haptable_go` for a board, of whose struct the scene has `near_one`.
class StackOf : public testing::Test {
protected:
    Outcome of(const std::string& header, const std::string& code) {
        const fs::path root = folder_.path();
        fs::create_directories(root / "firmware");
        fs::create_directories(root / "out");
        std::ofstream(root / "firmware/haptable.h") << "int haptable_go(int x);\n" << header;
        std::ofstream(root / "firmware/haptable_go.c") << "#include \"haptable.h\"\n" << code;
        const std::string gcc =
            "gcc -std=c99 -O1 -fno-inline -fno-optimize-sibling-calls -ffunction-sections -fdata-sections "
            "-fcallgraph-info=su -Ifirmware -c firmware/haptable_go.c -o out/haptable_go.o";
        return run("S=$PWD/scripts/stack.py; cd " + root.string() + " && " + gcc +
                   " && echo 'int scene;' | gcc -xc -c - -o model.o && CROSS= python3 $S out model.o");
    }

private:
    TemporaryFolder folder_;
};

const char* const kHeader =
    "typedef int far_fn(int x);\nstruct law {\nint degree;\nfar_fn* far;\n};\n"
    "extern const struct law haptable_law;\nstruct box {\nfar_fn* put;\n};\nfar_fn haptable_deep;\n";
const char* const kDeep = "int haptable_deep(int x) { volatile int room[250]; room[0] = x; return room[0]; }\n";

TEST_F(StackOf, ACallThroughAPointerIsFollowed) {
    constexpr std::pair<const char*, const char*> kCalls[] = {
        {"what a const struct holds",
         "const struct law haptable_law = {2, haptable_deep};\n"
         "int haptable_go(int x) { const struct law* volatile law = &haptable_law; "
         "const struct law* it = law; return it->far(x) + 1; }\n"},
        {"what code assigns",
         "int haptable_go(int x) {\n"
         "    struct box box;\n"
         "    struct box* volatile at = &box;\n"
         "    struct box* it = at;\n"
         "    it->put = haptable_deep;\n"
         "    it = at;\n"
         "    return it->put(x) + 1;\n"
         "}\n"},
    };
    for (const auto& [name, code] : kCalls) {
        const Outcome found = of(kHeader, std::string(kDeep) + code);
        ASSERT_EQ(found.status, 0) << name << found.err;
        EXPECT_GT(rows_of(found.out)["haptable_go"], 800) << name << found.out;
    }
}

TEST_F(StackOf, WhatNothingBoundsIsAnError) {
    const Outcome any = of(kHeader, std::string(kDeep) +
                                        "int haptable_go(int x) { far_fn* volatile any = haptable_deep; "
                                        "return any(x) + 1; }\n");
    EXPECT_EQ(any.status, 1) << any.out;
    EXPECT_TRUE(says(any.err, "haptable_go calls through a pointer that is no member"));
    EXPECT_TRUE(says(any.err, "firmware/haptable_go.c:3:"));
    const Outcome itself = of("", "int haptable_go(int x) { return x > 0 ? haptable_go(x - 1) + 1 : 0; }\n");
    EXPECT_EQ(itself.status, 1) << itself.out;
    EXPECT_TRUE(says(itself.err, "recursion: haptable_go > haptable_go"));
}

}  // namespace
}  // namespace haptable::test
