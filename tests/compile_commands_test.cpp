// SPDX-License-Identifier: GPL-2.0-or-later
// make compile_commands.json: what an editor and clang's tools read, made of make's own commands.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/process.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

TEST(CompileCommands, HaveEverySourceOfHostCodegenAndFirmware) {
    const Outcome made =
        run("make -nB --no-print-directory PRECOMPILED= all ${BUILD:-build}/bin/haptable-keys 2>/dev/null | sh "
            "scripts/compile_commands.sh");
    ASSERT_EQ(made.status, 0) << made.err;
    std::set<std::string> files;
    for (const auto& entry : nlohmann::json::parse(made.out)) {
        const std::string file = entry.at("file"), command = entry.at("command");
        EXPECT_TRUE(files.insert(file).second) << file << " twice";
        EXPECT_NE(command.find(" -c " + file + " -o "), std::string::npos) << command;
        EXPECT_EQ(entry.at("directory").get<std::string>(), fs::current_path().string());
    }
    for (const char* folder : {"host/scene", "host/precompute", "host/session", "host/view", "codegen", "firmware"})
        for (const auto& entry : fs::directory_iterator(folder)) {
            const fs::path& file = entry.path();
            const bool is_source = file.extension() == ".cpp" || file.extension() == ".c";
            EXPECT_TRUE(!is_source || files.contains(file.string())) << file;
        }
}

// Quotes and backslashes of a flag stay what they are; what is no command is left out; without one it is an error.
TEST(CompileCommands, AreJsonWhateverAFlagHolds) {
    const Outcome one = run(
        R"(printf '%s\n' 'echo a' 'ccache g++ -DNAME="\"a\"" -c a.cpp -o b/a.o' 'gcc a.o -o a' | sh scripts/compile_commands.sh)");
    ASSERT_EQ(one.status, 0) << one.err;
    const auto entries = nlohmann::json::parse(one.out);
    ASSERT_EQ(entries.size(), 1U);
    EXPECT_EQ(entries[0].at("command"), R"(g++ -DNAME="\"a\"" -c a.cpp -o b/a.o)");
    EXPECT_NE(run("echo nothing | sh scripts/compile_commands.sh").status, 0);
}

}  // namespace
}  // namespace haptable::test
