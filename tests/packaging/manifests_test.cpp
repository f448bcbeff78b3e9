// SPDX-License-Identifier: GPL-2.0-or-later
// The firmware as a library of other people's projects: the manifests that are checked in are those of the files that
// there are, and a project that has nothing but one line for it and a scene's model.c feels the servo's force.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.push_back(entry.path().lexically_relative(folder));
    std::sort(files.begin(), files.end());
    return files;
}

TEST(Manifests, AreThoseOfTheFilesThatThereAre) {
    const TemporaryFolder fresh;
    const Outcome made = run("sh packaging/manifests.sh " + fresh.path().string());
    ASSERT_EQ(made.status, 0) << made.err;
    const std::vector<fs::path> files = files_below(fresh.path());
    EXPECT_EQ(files,
              (std::vector<fs::path>{
                  "firmware/CMakeLists.txt", "firmware/haptable.haptable.pdsc", "firmware/idf_component.yml",
                  "firmware/library.json", "firmware/library.properties", "firmware/zephyr/CMakeLists.txt",
                  "firmware/zephyr/Kconfig", "firmware/zephyr/module.yml", "library.json", "zephyr/module.yml"}));
    for (const fs::path& file : files)
        EXPECT_EQ(read_file(file), read_file(fresh.path() / file)) << file << ": run make manifests";
}

/// Zephyr's and ESP-IDF's own functions are not here: in their place ones that look at every file.
TEST(Manifests, OfZephyrAndEspIdfNameEveryFile) {
    const TemporaryFolder folder;
    write_file(
        folder.path() / "lists.cmake",
        "function(look)\nforeach(file ${ARGN})\nif(NOT EXISTS ${file})\nmessage(FATAL_ERROR \"no ${file}\")\n"
        "endif()\nmath(EXPR n \"${n} + 1\")\nendforeach()\nmessage(STATUS \"${n} files\")\nendfunction()\n"
        "function(zephyr_library_named)\nendfunction()\nfunction(zephyr_library_compile_options)\nendfunction()\n"
        "function(zephyr_include_directories)\nlook(${ARGV}/haptable.h)\nendfunction()\n"
        "function(zephyr_library_sources)\nlook(${ARGV})\nendfunction()\n"
        "function(target_compile_options)\nendfunction()\n"
        "function(idf_component_register)\ncmake_parse_arguments(A \"\" \"\" \"SRCS;INCLUDE_DIRS\" ${ARGN})\n"
        "list(TRANSFORM A_SRCS PREPEND ${CMAKE_CURRENT_LIST_DIR}/)\nlook(${A_SRCS})\nendfunction()\n"
        "set(CONFIG_HAPTABLE y)\nset(ESP_PLATFORM y)\n"
        "include(${HAPTABLE}/firmware/zephyr/CMakeLists.txt)\ninclude(${HAPTABLE}/firmware/CMakeLists.txt)\n");
    const Outcome looked = run("cmake -DHAPTABLE=" + fs::current_path().string() + " -P lists.cmake", folder.path());
    ASSERT_EQ(looked.status, 0) << looked.err;
    const auto sources = std::count_if(fs::directory_iterator("firmware"), fs::directory_iterator(),
                                       [](const auto& entry) { return entry.path().extension() == ".c"; });
    const std::string files = fmt::format("-- {} files\n", sources);
    EXPECT_EQ(looked.out, files + "-- 1 files\n" + files);
}

/// 60 ticks down into the cube, as in docs/INSTALL.md; the last force as bits.
constexpr const char* kMain =
    "#include <stdio.h>\n#include \"haptable.h\"\n#include \"model.h\"\n"
    "int main(void) {\n"
    "    static HAPTABLE_MODEL_STATE state;\n    struct haptable_output out;\n    uint32_t tick;\n"
    "    haptable_init(&HAPTABLE_MODEL_SCENE, &state);\n"
    "    haptable_check(&HAPTABLE_MODEL_SCENE, &state, HAPTABLE_CHECK_ALL);\n"
    "    for (tick = 0; tick < 60; ++tick) {\n"
    "        const struct haptable_input in = {{0.015f, 0.015f, 0.032f - 1e-4f * (float)tick}, 0, 1};\n"
    "        haptable_step(&HAPTABLE_MODEL_SCENE, &state, &in, 1000u * tick, &out);\n    }\n"
    "    printf(\"%.9g,%.9g,%.9g\\n\", (double)out.force_n[0], (double)out.force_n[1], (double)out.force_n[2]);\n"
    "    return 0;\n}\n";

TEST(Manifests, OneLineOfCMakeFeelsTheServosForce) {
    const fs::path cube = fs::absolute(build_folder() / "cube");
    if (!fs::exists(cube / "servo")) GTEST_SKIP() << "build/cube/servo is not built: make scene";
    const TemporaryFolder app;
    write_file(app.path() / "main.c", kMain);
    for (const char* file : {"model.c", "model.h"}) fs::copy_file(cube / file, app.path() / file);
    write_file(app.path() / "CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.16)\nproject(app C)\nadd_subdirectory(${HAPTABLE}/firmware haptable)\n"
               "add_executable(app main.c model.c)\ntarget_compile_options(app PRIVATE -ffp-contract=off)\n"
               "target_link_libraries(app PRIVATE haptable::firmware)\n");
    const Outcome felt = run("cmake -S . -B out -DHAPTABLE=" + fs::current_path().string() +
                                 " >/dev/null && cmake --build out >/dev/null && out/app",
                             app.path());
    ASSERT_EQ(felt.status, 0) << felt.err;
    std::string path = "x,y,z\n";
    for (int tick = 0; tick < 60; ++tick)
        path += fmt::format("0.015,0.015,{:.9g}\n", 0.032F - 1e-4F * static_cast<float>(tick));
    write_file(app.path() / "path.csv", path);
    const Outcome servo =
        run((cube / "servo").string() +
                " --quiet --replay path.csv --out felt.csv && awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) at[$i] = i }"
                " END { print $at[\"force_x\"] \",\" $at[\"force_y\"] \",\" $at[\"force_z\"] }' felt.csv",
            app.path());
    ASSERT_EQ(servo.status, 0) << servo.err;
    EXPECT_EQ(felt.out, servo.out);
    EXPECT_NE(felt.out, "0,0,0\n");
}

}  // namespace
}  // namespace haptable::test
